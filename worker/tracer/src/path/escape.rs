//! Where the sky ends a ray, and the light that a path meets there.

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

/// Weight of a sample of density `pdf` against one other technique of density
/// `other` (Veach and Guibas 1995: power heuristic, exponent 2).
#[inline]
pub(super) fn power_heuristic(pdf: f32, other: f32) -> f32 {
    let ratio = other / pdf;
    // A ratio of infinity gives weight 0.
    1.0 / (1.0 + ratio * ratio)
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
            radiance += light * power_heuristic(choice.pdf, pdf);
        } else {
            radiance += sky.radiance(ray.o, d);
        }
    }
    if let Some(sun) = &scene.common.sun
        && sun.contains(d)
    {
        let weight = if choice.sun_sampled {
            power_heuristic(choice.pdf, sun.pdf())
        } else {
            1.0
        };
        radiance += sun.radiance * weight;
    }
    radiance
}

#[cfg(test)]
mod tests {
    use super::power_heuristic;

    #[test]
    fn weights_of_two_techniques_add_up() {
        for (a, b) in [(1.0, 1.0), (0.2, 14_000.0), (1e10, 1e-3), (3.0, 0.0)] {
            let sum = power_heuristic(a, b) + if b > 0.0 { power_heuristic(b, a) } else { 0.0 };
            assert!((sum - 1.0).abs() < 1e-6, "{a} {b}: {sum}");
        }
        assert_eq!(power_heuristic(0.0, 1.0), 0.0);
        assert_eq!(power_heuristic(1.0, 0.0), 1.0);
    }
}
