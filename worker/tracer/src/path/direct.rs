//! Next event estimation: light sampled straight from a vertex.

use super::escape::ray_under_sky;
use super::vertex::Vertex;
use super::weight::light_weight;
use crate::geometry::Ray;
use crate::scene::Scene;
use glam::Vec3;

/// A light sample that still has to be seen from the vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShadowRay {
    /// From the vertex to the light.
    pub ray: Ray,
    /// Radiance that it adds to the pixel when nothing is in between.
    pub contribution: Vec3,
}

/// A sample of the sun; `None` when it adds nothing.
#[inline]
pub(super) fn sample_sun<const USES: u8>(
    scene: &Scene,
    at: &Vertex,
    time_s: f32,
    throughput: Vec3,
    u: [f32; 2],
) -> Option<ShadowRay> {
    let sun = scene.common.sun.as_ref()?;
    shadow_ray::<USES>(
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
pub(super) fn sample_sky<const USES: u8>(
    scene: &Scene,
    at: &Vertex,
    time_s: f32,
    throughput: Vec3,
    u: [f32; 2],
) -> Option<ShadowRay> {
    let sample = scene.common.sky.as_ref()?.sample(at.point.p, u)?;
    shadow_ray::<USES>(
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
fn shadow_ray<const USES: u8>(
    scene: &Scene,
    at: &Vertex,
    time_s: f32,
    throughput: Vec3,
    wi: Vec3,
    radiance: Vec3,
    pdf: f32,
) -> Option<ShadowRay> {
    let (f_cos, pdf_scatter) = at.eval_pdf::<USES>(&scene.common.tables, wi);
    let contribution = throughput
        * f_cos
        * radiance
        * (light_weight(scene.common.strategy.mis, pdf, pdf_scatter) / pdf);
    // NaN passes, to be counted as a bad sample.
    if contribution != Vec3::ZERO {
        Some(ShadowRay {
            ray: ray_under_sky::<USES>(scene, at.point.origin_towards(wi), wi, time_s),
            contribution,
        })
    } else {
        None
    }
}
