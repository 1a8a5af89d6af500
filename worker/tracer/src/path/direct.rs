//! Next event estimation: light sampled straight from a surface.

use super::escape::power_heuristic;
use super::interaction::Interaction;
use crate::geometry::Ray;
use crate::scene::Scene;
use glam::Vec3;

/// A light sample that still has to be seen from the surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShadowRay {
    /// From the surface to the light.
    pub ray: Ray,
    /// Radiance that it adds to the pixel when nothing is in between.
    pub contribution: Vec3,
}

/// A sample of the sun; `None` when it adds nothing.
#[inline]
pub(super) fn sample_sun(
    scene: &Scene,
    at: &Interaction,
    time_s: f32,
    throughput: Vec3,
    u: [f32; 2],
) -> Option<ShadowRay> {
    let sun = scene.common.sun.as_ref()?;
    shadow_ray(
        scene,
        at,
        time_s,
        throughput,
        sun.sample(u),
        sun.radiance,
        sun.pdf(),
    )
}

/// A sample of the sky; `None` when it adds nothing.
#[inline]
pub(super) fn sample_sky(
    scene: &Scene,
    at: &Interaction,
    time_s: f32,
    throughput: Vec3,
    u: [f32; 2],
) -> Option<ShadowRay> {
    let sample = scene.common.sky.as_ref()?.sample(u)?;
    shadow_ray(
        scene,
        at,
        time_s,
        throughput,
        sample.wi,
        sample.radiance,
        sample.pdf,
    )
}

#[inline]
fn shadow_ray(
    scene: &Scene,
    at: &Interaction,
    time_s: f32,
    throughput: Vec3,
    wi: Vec3,
    radiance: Vec3,
    pdf: f32,
) -> Option<ShadowRay> {
    // Light from behind the surface itself never counts, whatever the shading
    // normal says: no leaks.
    if wi.dot(at.n_geometric) <= 0.0 {
        return None;
    }
    let (f_cos, pdf_bsdf) =
        at.bsdf
            .eval_pdf(&scene.common.tables, at.wo_local, at.frame.to_local(wi));
    let contribution = throughput * f_cos * radiance * (power_heuristic(pdf, pdf_bsdf) / pdf);
    // NaN passes, to be counted as a bad sample.
    if contribution != Vec3::ZERO {
        Some(ShadowRay {
            ray: Ray::at_time(at.point.origin_towards(wi), wi, time_s),
            contribution,
        })
    } else {
        None
    }
}
