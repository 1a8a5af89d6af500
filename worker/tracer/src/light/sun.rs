//! The sun: a disc of constant radiance at infinity.

use crate::math::frame::Frame;
use glam::Vec3;
use shearwater_shared::scene::Sun;

/// Light from a cone of directions.
#[derive(Clone, Copy, Debug)]
pub struct SunLight {
    direction: Vec3,
    frame: Frame,
    /// 1 - cos of the angular radius, without cancellation.
    one_minus_cos: f32,
    /// Square of the chord between the centre and the rim on the unit sphere.
    chord_squared: f32,
    /// Per solid angle.
    pdf: f32,
    /// Radiance of the disc.
    pub radiance: Vec3,
}

impl SunLight {
    /// From its description, with its own radiance; `None` when it gives no light.
    #[must_use]
    pub fn new(sun: &Sun) -> Option<Self> {
        Self::with_radiance(sun, Vec3::from_array(sun.radiance?))
    }

    /// The same with another radiance.
    #[must_use]
    pub fn with_radiance(sun: &Sun, radiance: Vec3) -> Option<Self> {
        let azimuth = sun.azimuth_deg.to_radians();
        let elevation = sun.elevation_deg.to_radians();
        let direction = Vec3::new(
            (libm::cos(elevation) * libm::sin(azimuth)) as f32,
            libm::sin(elevation) as f32,
            (-libm::cos(elevation) * libm::cos(azimuth)) as f32,
        );
        if radiance.max_element() <= 0.0 {
            return None;
        }
        // 1 - cos(r) = 2 sin^2(r / 2): exact for any radius.
        let half_sin = libm::sin(sun.angular_radius_deg.to_radians() * 0.5);
        let one_minus_cos = 2.0 * half_sin * half_sin;
        Some(Self {
            direction,
            frame: Frame::from_normal(direction),
            one_minus_cos: one_minus_cos as f32,
            chord_squared: (2.0 * one_minus_cos) as f32,
            pdf: (1.0 / (2.0 * std::f64::consts::PI * one_minus_cos)) as f32,
            radiance,
        })
    }

    /// Whether a unit direction meets the disc. By the chord, since the cosine
    /// of a small angle has no digits left in f32.
    #[inline]
    #[must_use]
    pub fn contains(&self, direction: Vec3) -> bool {
        (direction - self.direction).length_squared() <= self.chord_squared
    }

    /// A uniform direction of the disc.
    #[inline]
    #[must_use]
    pub fn sample(&self, u: [f32; 2]) -> Vec3 {
        self.frame
            .to_world(crate::math::warp::uniform_cone(u, self.one_minus_cos))
    }

    /// Density of [`Self::sample`] per solid angle.
    #[inline]
    #[must_use]
    pub fn pdf(&self) -> f32 {
        self.pdf
    }

    /// Direction of the centre.
    #[must_use]
    pub fn direction(&self) -> Vec3 {
        self.direction
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sun(elevation_deg: f64, angular_radius_deg: f64) -> SunLight {
        let radiance = Some([1e6; 3]);
        SunLight::new(&Sun {
            azimuth_deg: 30.0,
            elevation_deg,
            angular_radius_deg,
            radiance,
        })
        .expect("light")
    }

    // E = pi L sin^2(r) cos(zenith angle), exactly, while the disc is above the
    // horizon: 69.763606 at the zenith for 0.27 degrees and L = 1e6.
    #[test]
    fn irradiance_is_exact() {
        for (elevation, expected) in [
            (90.0, 69.763_606),
            (60.0, 60.417_055),
            (30.0, 34.881_803),
            (10.0, 12.114_323),
        ] {
            let light = sun(elevation, 0.27);
            let n = 1 << 16;
            let mut sum = 0.0;
            for i in 0..n {
                let u = crate::sampler::sobol4_owen(i, 1, 2).map(crate::math::hash::u32_to_unit);
                sum += f64::from(light.radiance.x * light.sample([u[0], u[1]]).y / light.pdf());
            }
            let irradiance = sum / f64::from(n);
            assert!(
                (irradiance / expected - 1.0).abs() < 2e-5,
                "{elevation}: {irradiance} against {expected}"
            );
        }
    }

    #[test]
    fn samples_lie_in_the_disc_and_fill_it() {
        for radius in [0.05, 0.27, 5.0, 45.0] {
            let light = sun(20.0, radius);
            let mut rim = 0;
            let mut distinct = std::collections::BTreeSet::new();
            for i in 0..10_000u32 {
                let u = crate::sampler::sobol4_owen(i, 3, 4).map(crate::math::hash::u32_to_unit);
                let d = light.sample([u[0], u[1]]);
                // One ulp of the direction at the rim.
                let chord = (d - light.direction()).length_squared();
                assert!(chord <= light.chord_squared * (1.0 + 1e-3), "{radius}");
                rim += u32::from(chord > 0.5 * light.chord_squared);
                distinct.insert(chord.to_bits());
            }
            assert!(
                (4800..5200).contains(&rim),
                "half of the disc lies outside half its area: {rim}"
            );
            assert!(
                distinct.len() > 5000,
                "rings: {} distinct radii at {radius} degrees",
                distinct.len()
            );
        }
    }
}
