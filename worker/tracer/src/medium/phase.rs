//! Phase functions: how a medium turns light.

use core::f32::consts::FRAC_1_PI;

use glam::Vec3;

use crate::math::frame::Frame;
use crate::math::warp::azimuth;

/// Below this |g| the exact inversion divides two small numbers; the other form
/// of it is used.
const STEEP_G_MIN: f32 = 0.5;

/// The scattering of one place in a medium: Henyey and Greenstein 1941, "Diffuse
/// radiation in the galaxy". Small plain data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phase {
    /// Share of light that is scattered rather than absorbed, per channel, 0 to 1.
    pub albedo: Vec3,
    /// Mean cosine between the directions before and after, -0.99 to 0.99: 0
    /// scatters evenly, 1 would go straight on, -1 back.
    pub g: f32,
}

/// One sampled direction of a [`Phase`]. Its weight is the albedo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseSample {
    /// The direction the light comes from, world space, unit.
    pub wi: Vec3,
    /// Density per steradian.
    pub pdf: f32,
}

impl Phase {
    /// Density per steradian of scattering between `wo` and `wi` (unit, both
    /// leaving the place). It integrates to 1, so it is also the density with
    /// which [`Phase::sample`] makes `wi`; the scattered share is the albedo.
    #[inline]
    #[must_use]
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        henyey_greenstein(self.g, -wo.dot(wi))
    }

    /// A direction drawn exactly in proportion to the phase function; `u` uniform
    /// in [0, 1).
    #[inline]
    #[must_use]
    pub fn sample(&self, wo: Vec3, u: [f32; 2]) -> PhaseSample {
        let cos = sample_cosine(self.g, u[0]);
        let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
        let (sin_phi, cos_phi) = azimuth(u[1]);
        let wi = Frame::from_normal(-wo).to_world(Vec3::new(sin * cos_phi, sin * sin_phi, cos));
        PhaseSample {
            wi,
            pdf: henyey_greenstein(self.g, cos),
        }
    }
}

/// `(1 - g^2) / (4 pi (1 + g^2 - 2 g cos)^(3/2))`; `cos` between the directions of
/// flight before and after.
#[inline]
fn henyey_greenstein(g: f32, cos: f32) -> f32 {
    // Written so that nothing cancels near the peak, whichever way it points.
    let steep = g.abs();
    let off_peak = if g < 0.0 { 1.0 + cos } else { 1.0 - cos }.max(0.0);
    let base = (1.0 - steep) * (1.0 - steep) + 2.0 * steep * off_peak;
    (0.25 * FRAC_1_PI) * (1.0 - g * g) / (base * base.sqrt())
}

/// The inverse of the distribution of `cos`, `u = 0` being straight back.
#[inline]
fn sample_cosine(g: f32, u: f32) -> f32 {
    let s = 2.0 * u - 1.0;
    let cos = if g.abs() > STEEP_G_MIN {
        let a = (1.0 - g * g) / (1.0 + g * s);
        (1.0 + g * g - a * a) / (2.0 * g)
    } else {
        // The same, with the 2 g divided out by hand.
        let q = 1.0 + g * s;
        let rest = 0.5 * g * (s * s + 3.0) + g * g * s - 0.5 * g * g * g * (1.0 - s * s);
        (s + rest) / (q * q)
    };
    cos.clamp(-1.0, 1.0)
}
