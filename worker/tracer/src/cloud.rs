//! Clouds as formations of semi-opaque ellipsoids.

use crate::geometry::Ellipsoid;
use crate::math::hash::mix64;
use glam::{DVec3, Vec3};
use shearwater_shared::scene::{Formation, ParticleCloud};
use std::f64::consts::PI;

/// How far the two jittered components of the spreading direction go, as in the
/// report: 0.8 u - 0.4.
const JITTER: f64 = 0.4;
/// Exponent on the uniform number that says how far a particle is pushed: below 1
/// it thins the cloud towards its far end less than linearly.
const PUSH_EXPONENT: f64 = 0.7;

/// The particles of a cloud, relative to `origin_m`. Uniform in the core
/// ellipsoid (uniform direction, cube-root radius), then pushed along the jittered
/// direction; opacity falls with the push. A function of the description alone.
pub(crate) fn particles(cloud: &ParticleCloud, origin_m: DVec3) -> impl Iterator<Item = Ellipsoid> {
    let Formation::Radial(radial) = &cloud.formation;
    let axis = DVec3::from_array(radial.direction).normalize_or(DVec3::X);
    let (side, other) = axis.any_orthonormal_pair();
    (0..cloud.count).map(move |index| {
        let mut draw = Draws::new(cloud.seed, index);
        let in_core = draw.in_unit_ball() * DVec3::from_array(radial.radii_m);
        let jitter =
            (side * (2.0 * draw.next() - 1.0) + other * (2.0 * draw.next() - 1.0)) * JITTER;
        let push = libm::pow(draw.next(), PUSH_EXPONENT);
        let centre = DVec3::from_array(radial.centre_m)
            + in_core
            + (axis + jitter).normalize() * (push * radial.length_m);
        let between = |bounds: [f64; 2], u: f64| bounds[0] + (bounds[1] - bounds[0]) * u;
        let radius = between(cloud.particle_radius_m, draw.next());
        let stretch = between(cloud.stretch_x, draw.next());
        let opacity = cloud.opacity[1] + (cloud.opacity[0] - cloud.opacity[1]) * push as f32;
        Ellipsoid {
            centre: (centre - origin_m).as_vec3(),
            radii: Vec3::new((radius * stretch) as f32, radius as f32, radius as f32),
            opacity: opacity.clamp(0.0, 1.0),
        }
    })
}

// Uniform numbers of one particle: a hash of (seed, particle, counter).
struct Draws {
    key: u64,
    counter: u64,
}

impl Draws {
    fn new(seed: u64, index: u32) -> Self {
        Self {
            key: mix64(seed ^ mix64(u64::from(index) ^ 0xC10D_5EED)),
            counter: 0,
        }
    }

    fn next(&mut self) -> f64 {
        self.counter += 1;
        (mix64(self.key ^ self.counter) >> 11) as f64 / 9_007_199_254_740_992.0
    }

    fn in_unit_ball(&mut self) -> DVec3 {
        let y = 1.0 - 2.0 * self.next();
        let angle = 2.0 * PI * self.next();
        let ring = libm::sqrt((1.0 - y * y).max(0.0));
        let radius = libm::cbrt(self.next());
        DVec3::new(ring * libm::cos(angle), y, ring * libm::sin(angle)) * radius
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shearwater_shared::scene::RadialFormation;

    fn radial(radius_m: f64, length_m: f64) -> Formation {
        Formation::Radial(RadialFormation {
            centre_m: [5.0, 0.0, -3.0],
            radii_m: [radius_m; 3],
            direction: [0.0, 0.0, 2.0],
            length_m,
        })
    }

    fn cloud() -> ParticleCloud {
        ParticleCloud {
            formation: radial(1.0, 0.0),
            count: 20_000,
            particle_radius_m: [0.1, 0.3],
            stretch_x: [1.0, 2.0],
            opacity: [0.2, 0.8],
            albedo: [0.9; 3],
            seed: 3,
        }
    }

    // Uniform in the ball: E r = 3/4 R, E r^2 = 3/5 R^2, and no direction is
    // preferred (a normalised cube would be 5.2 times denser at its corners).
    #[test]
    fn the_core_is_a_uniform_ball() {
        let centre = DVec3::new(5.0, 0.0, -3.0);
        let all: Vec<Vec3> = particles(&cloud(), centre).map(|p| p.centre).collect();
        let n = all.len() as f32;
        let mean = |f: &dyn Fn(&Vec3) -> f32| all.iter().map(f).sum::<f32>() / n;
        assert!((mean(&|p| p.length()) - 0.75).abs() < 0.006);
        assert!((mean(&|p| p.length_squared()) - 0.6).abs() < 0.008);
        for axis in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE.normalize()] {
            assert!(mean(&|p| p.dot(axis)).abs() < 0.015, "{axis}");
            assert!(
                (mean(&|p| p.dot(axis) * p.dot(axis)) - 0.2).abs() < 0.01,
                "{axis}"
            );
        }
    }

    #[test]
    fn particles_keep_their_bounds_and_thin_out() {
        let spread = ParticleCloud {
            formation: radial(0.01, 50.0),
            ..cloud()
        };
        let all: Vec<_> = particles(&spread, DVec3::ZERO).collect();
        for p in &all {
            assert!((0.1..=0.3001).contains(&p.radii.y) && p.radii.y == p.radii.z);
            assert!((0.999..=2.001).contains(&(p.radii.x / p.radii.y)));
            assert!((0.2..=0.8).contains(&p.opacity));
        }
        let reach = |p: &Ellipsoid| (p.centre - Vec3::new(5.0, 0.0, -3.0)).length();
        let (near, far): (Vec<&Ellipsoid>, Vec<&Ellipsoid>) =
            all.iter().partition(|p| reach(p) < 25.0);
        let opacity =
            |of: &[&Ellipsoid]| of.iter().map(|p| p.opacity).sum::<f32>() / of.len() as f32;
        assert!(opacity(&near) > opacity(&far) + 0.2);
        assert!(
            all.iter().all(|p| (p.centre.z + 3.0) > -0.02),
            "spreads along +z only"
        );
    }

    #[test]
    fn the_same_description_gives_the_same_cloud() {
        let one: Vec<_> = particles(&cloud(), DVec3::ONE).map(|p| p.centre).collect();
        let two: Vec<_> = particles(&cloud(), DVec3::ONE).map(|p| p.centre).collect();
        let other: Vec<_> = particles(&ParticleCloud { seed: 4, ..cloud() }, DVec3::ONE)
            .map(|p| p.centre)
            .collect();
        assert_eq!(one, two);
        assert_ne!(one, other);
    }
}
