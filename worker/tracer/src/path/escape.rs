//! Where the sky ends a ray, and the light that a path meets there.

use super::weight::chance_weight;
use crate::geometry::Ray;
use crate::scene::Scene;
use crate::uses::SURROUNDINGS;
use glam::Vec3;

/// How the direction of a path segment was chosen, and what else could have
/// found the same light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Choice {
    /// Density of the direction per solid angle; ignored when neither light was
    /// also sampled.
    pub pdf: f32,
    /// The sun was also sampled from the segment's start.
    pub sun_sampled: bool,
    /// The sky was also sampled from the segment's start.
    pub sky_sampled: bool,
}

impl Choice {
    /// A segment that no light sampling competes with.
    pub(super) const ALONE: Self = Self {
        pdf: 0.0,
        sun_sampled: false,
        sky_sampled: false,
    };
}

/// A ray of the scene: a finite sky ends it.
#[inline]
pub(super) fn ray_under_sky<const USES: u8>(scene: &Scene, o: Vec3, d: Vec3, time_s: f32) -> Ray {
    let mut ray = Ray::at_time(o, d, time_s);
    if USES & SURROUNDINGS != 0
        && let Some(sky) = &scene.common.sky
    {
        ray.t_max = sky.reach(o, d);
    }
    ray
}

/// Radiance that a segment which met nothing carries from sky and sun, weighted
/// against their own sampling. The sun shines through a dome.
#[inline]
pub(super) fn escaped_radiance(scene: &Scene, ray: &Ray, choice: Choice) -> Vec3 {
    let d = ray.d;
    let mut radiance = Vec3::ZERO;
    if let Some(sky) = &scene.common.sky {
        if choice.sky_sampled {
            let (light, pdf) = sky.radiance_and_pdf(ray.o, d);
            radiance += light * chance_weight(scene.common.strategy.mis, choice.pdf, pdf);
        } else {
            radiance += sky.radiance(ray.o, d);
        }
    }
    if let Some(sun) = &scene.common.sun
        && sun.contains(d)
    {
        let weight = if choice.sun_sampled {
            chance_weight(scene.common.strategy.mis, choice.pdf, sun.pdf())
        } else {
            1.0
        };
        radiance += sun.radiance * weight;
    }
    radiance
}
