//! The sky: radiance from every direction, sampled by importance.

use super::dome::SkyDome;
use super::map::{MapSample, SkyMap};
use crate::math::elementary::sin_cos;
use glam::Vec3;
use std::f32::consts::PI;
use std::sync::Arc;

/// Light from all around.
#[derive(Clone, Debug)]
pub enum SkyLight {
    /// The same radiance from everywhere.
    Constant(Vec3),
    /// An equirectangular map at infinity, bilinearly interpolated.
    Map(Arc<SkyMap>),
    /// A map on the inside of a sphere in the scene, which ends every ray.
    Dome(SkyDome),
}

/// A direction towards the sky.
#[derive(Clone, Copy, Debug)]
pub struct SkySample {
    /// Unit direction.
    pub wi: Vec3,
    /// Radiance from there.
    pub radiance: Vec3,
    /// Density per solid angle.
    pub pdf: f32,
}

impl SkyLight {
    /// Whether light comes so unevenly that sampling it pays.
    #[must_use]
    pub fn is_sampled(&self) -> bool {
        match self {
            Self::Constant(_) => false,
            Self::Map(map) => map.is_sampled(),
            Self::Dome(dome) => dome.map().is_sampled(),
        }
    }

    /// Mean radiance over all directions (of a dome: from its centre), of the
    /// brightest channel.
    #[must_use]
    pub fn mean(&self) -> f32 {
        match self {
            Self::Constant(radiance) => radiance.max_element(),
            Self::Map(map) => map.mean(),
            Self::Dome(dome) => dome.map().mean(),
        }
    }

    /// Whether it is at a finite distance, so that it ends rays.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        matches!(self, Self::Dome(_))
    }

    /// Where the sky ends the ray from `o` in the unit direction `d`, in metres
    /// along it: nothing beyond can be seen, nor dim any light. Infinite but for a
    /// dome.
    #[inline]
    #[must_use]
    pub fn reach(&self, o: Vec3, d: Vec3) -> f32 {
        match self {
            Self::Constant(_) | Self::Map(_) => f32::INFINITY,
            Self::Dome(dome) => dome.reach(o, d),
        }
    }

    /// Radiance that arrives at `o` from the unit direction `d`.
    #[inline]
    #[must_use]
    pub fn radiance(&self, o: Vec3, d: Vec3) -> Vec3 {
        match self {
            Self::Constant(radiance) => *radiance,
            Self::Map(map) => map.radiance(d),
            Self::Dome(dome) => dome.radiance(o, d),
        }
    }

    /// Radiance that arrives at `o` from `d`, and the density of [`Self::sample`]
    /// there.
    #[inline]
    #[must_use]
    pub fn radiance_and_pdf(&self, o: Vec3, d: Vec3) -> (Vec3, f32) {
        match self {
            Self::Constant(radiance) => (*radiance, 0.25 / PI),
            Self::Map(map) => map.radiance_and_pdf(d),
            Self::Dome(dome) => dome.radiance_and_pdf(o, d),
        }
    }

    /// A direction from `o` with density roughly proportional to radiance; `None`
    /// from a black sky, and where the draw adds nothing at `o`.
    #[inline]
    #[must_use]
    pub fn sample(&self, o: Vec3, u: [f32; 2]) -> Option<SkySample> {
        match self {
            Self::Constant(radiance) => {
                if radiance.max_element() <= 0.0 {
                    return None;
                }
                let y = 1.0 - 2.0 * u[0];
                let (sin, cos) = sin_cos(2.0 * PI * u[1]);
                let r = (1.0 - y * y).max(0.0).sqrt();
                Some(SkySample {
                    wi: Vec3::new(r * cos, y, r * sin),
                    radiance: *radiance,
                    pdf: 0.25 / PI,
                })
            }
            Self::Map(map) => map
                .sample(u)
                .map(|MapSample { d, radiance, pdf }| SkySample {
                    wi: d,
                    radiance,
                    pdf,
                }),
            Self::Dome(dome) => dome.sample(o, u),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::u32_to_unit;
    use crate::sampler::sobol4_owen;

    #[test]
    fn a_constant_sky_gives_pi() {
        let (sky, n) = (SkyLight::Constant(Vec3::ONE), 1u32 << 16);
        let sum: f64 = (0..n)
            .map(|i| sobol4_owen(i, 11, 12).map(u32_to_unit))
            .filter_map(|u| sky.sample(Vec3::ZERO, [u[0], u[1]]))
            .map(|s| f64::from(s.radiance.x * s.wi.y.max(0.0) / s.pdf))
            .sum();
        assert!((sum / f64::from(n) / std::f64::consts::PI - 1.0).abs() < 1e-3);
        assert!(!sky.is_sampled());
        assert_eq!(sky.reach(Vec3::ZERO, Vec3::X), f32::INFINITY);
    }
}
