//! The modified Phong model (Lafortune and Willems 1994).

use core::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::error::{check_color, check_range};
use super::fresnel::luminance;
use super::lobe::{above, lobe_sample, mixture_sample, specular_probability};
use super::{BsdfError, BsdfSample, LobeSampling};
use crate::math::elementary::{exp, expm1, ln, log1p};
use crate::math::frame::Frame;
use crate::math::warp::{azimuth, cosine_hemisphere};

/// Largest exponent: a lobe of half width 0.02 degrees, below which f32
/// directions are the lobe's grain.
pub const EXPONENT_MAX: f32 = 1e7;
/// kd + ks may exceed 1 by the rounding of decimal fractions.
const ENERGY_SLACK: f32 = 1e-5;

/// f = kd/pi + ks (n + 2)/(2 pi) cos^n of the angle to the mirror direction.
/// Light is conserved (kd + ks <= 1), though the lobe loses what lies below the
/// horizon: the specular albedo of a large n is cos(theta).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phong {
    /// Diffuse coefficient.
    pub kd: Vec3,
    /// Specular coefficient.
    pub ks: Vec3,
    /// n, at least 0.
    pub exponent: f32,
    /// How a direction is drawn.
    pub sampling: LobeSampling,
}

impl Phong {
    /// The material.
    ///
    /// # Errors
    /// [`BsdfError`] if a coefficient leaves [0, 1], kd + ks exceeds 1 in a
    /// channel, or n leaves [0, [`EXPONENT_MAX`]].
    pub fn new(kd: Vec3, ks: Vec3, exponent: f32) -> Result<Self, BsdfError> {
        check_color("kd", kd)?;
        check_color("ks", ks)?;
        check_range("exponent", exponent, 0.0, EXPONENT_MAX)?;
        let sum = (kd + ks).max_element();
        if sum > 1.0 + ENERGY_SLACK {
            return Err(BsdfError::TooBright { sum });
        }
        Ok(Self {
            kd,
            ks,
            exponent,
            sampling: LobeSampling::default(),
        })
    }

    /// The same material, sampled so.
    #[must_use]
    pub fn with_sampling(mut self, sampling: LobeSampling) -> Self {
        self.sampling = sampling;
        self
    }

    #[inline]
    fn specular_probability(&self) -> f32 {
        specular_probability(luminance(self.ks), luminance(self.kd))
    }

    #[inline]
    pub(super) fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Vec3, f32) {
        let [diffuse, shiny] = self.lobes(wo, wi);
        let probability = self.specular_probability();
        let pdf = probability * shiny.1 + (1.0 - probability) * diffuse.1;
        (diffuse.0 + shiny.0, pdf)
    }

    /// f cos and density of each lobe alone: diffuse, shiny.
    #[inline]
    fn lobes(&self, wo: Vec3, wi: Vec3) -> [(Vec3, f32); 2] {
        if self.ks == Vec3::ZERO && self.kd == Vec3::ZERO {
            return [(Vec3::ZERO, 0.0); 2];
        }
        let mirror = Vec3::new(-wo.x, -wo.y, wo.z);
        // 1 - cos of the angle to the mirror direction, from the chord: the
        // cosine itself has no digits left for a narrow lobe.
        let q = 0.5 * (mirror - wi).length_squared();
        let power = if q < 1.0 {
            exp(self.exponent * log1p(-q))
        } else {
            0.0
        };
        let lobe = power * (0.5 * FRAC_1_PI);
        let cosine = FRAC_1_PI * wi.z;
        let shiny = self.ks * ((self.exponent + 2.0) * lobe * wi.z);
        [
            (self.kd * cosine, cosine),
            (shiny, (self.exponent + 1.0) * lobe),
        ]
    }

    #[inline]
    pub(super) fn sample(&self, wo: Vec3, u: [f32; 3]) -> Option<BsdfSample> {
        let probability = self.specular_probability();
        let is_shiny = u[0] < probability;
        let wi = if is_shiny {
            // cos = v^(1/(n+1)), by way of 1 - cos.
            let q = -expm1(ln(1.0 - u[1]) / (self.exponent + 1.0));
            let sin = (q * (2.0 - q)).sqrt();
            let (sin_phi, cos_phi) = azimuth(u[2]);
            let mirror = Frame::from_normal(Vec3::new(-wo.x, -wo.y, wo.z));
            mirror.to_world(Vec3::new(sin * cos_phi, sin * sin_phi, 1.0 - q))
        } else {
            cosine_hemisphere([u[1], u[2]])
        };
        // Part of the lobe lies below the horizon. Drawing again would change
        // the density, so that part is absorbed.
        if !above(wi) {
            return None;
        }
        match self.sampling {
            LobeSampling::Mixture => mixture_sample(wi, self.eval_pdf(wo, wi)),
            LobeSampling::Lobe => lobe_sample(wi, self.lobes(wo, wi), probability, is_shiny),
        }
    }

    #[inline]
    pub(super) fn roughness(&self) -> f32 {
        (2.0 / (self.exponent + 2.0)).sqrt()
    }
}
