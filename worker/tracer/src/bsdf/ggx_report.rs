//! Cook-Torrance as the report had it, errors included, to be shown beside
//! [`super::Ggx`].
//!
//! Its shadowing takes k = (alpha + 1)^2/8, which was fitted for point lights
//! and darkens grazing angles (a perfectly smooth white mirror reflects 79 % at
//! 60 degrees); its diffuse weight 1 - F(h) adds up to 10 % of light at others.

use core::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::error::{check_color, check_range};
use super::fresnel::{luminance, schlick};
use super::interface::{mirror, mirror_or};
use super::lobe::{above, lobe_sample, mixture_sample, specular_probability};
use super::microfacet::{ggx_d, reflect};
use super::{BsdfError, BsdfSample, GgxParameters, LobeSampling};
use crate::math::warp::{azimuth, cosine_hemisphere};

/// Least weight of the shiny lobe when a lobe is chosen.
const SHINE_MIN: f32 = 1e-3;

/// f = (1 - F(h)) kd/pi + D F G / (4 cos_o cos_i), sampled by D cos_h.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GgxReport {
    kd: Vec3,
    f0: Vec3,
    alpha: f32,
    specular_probability: f32,
    sampling: LobeSampling,
}

impl GgxReport {
    /// The material, from the same description as [`super::Ggx`].
    ///
    /// # Errors
    /// [`BsdfError`] if a parameter leaves [0, 1].
    pub fn new(parameters: &GgxParameters) -> Result<Self, BsdfError> {
        let plain = Self {
            kd: Vec3::ZERO,
            f0: Vec3::ZERO,
            alpha: mirror_or(check_range("alpha", parameters.alpha, 0.0, 1.0)?),
            specular_probability: 1.0,
            sampling: LobeSampling::default(),
        };
        let metalness = check_range("metalness", parameters.metalness, 0.0, 1.0)?;
        let dielectric = check_range("dielectric_f0", parameters.dielectric_f0, 0.0, 1.0)?;
        Ok(plain.with_base_color(
            check_color("base_color", parameters.base_color)?,
            metalness,
            dielectric,
        ))
    }

    /// The same material in the colour of a texel.
    #[inline]
    #[must_use]
    pub fn with_base_color(mut self, base_color: Vec3, metalness: f32, dielectric_f0: f32) -> Self {
        let dielectric = Vec3::splat(dielectric_f0);
        self.kd = base_color * (1.0 - metalness);
        self.f0 = dielectric + (base_color - dielectric) * metalness;
        // Schlick reflects at grazing angles even where F0 is 0.
        let shine = luminance(self.f0).max(SHINE_MIN);
        self.specular_probability = specular_probability(shine, luminance(self.kd));
        self
    }

    /// The same material where a texture gives it another alpha in [0, 1].
    #[inline]
    #[must_use]
    pub fn with_alpha(mut self, alpha: f32) -> Self {
        self.alpha = mirror_or(alpha);
        self
    }

    /// The same material, sampled so.
    #[must_use]
    pub fn with_sampling(mut self, sampling: LobeSampling) -> Self {
        self.sampling = sampling;
        self
    }

    /// cos / (cos (1 - k) + k) without its numerator.
    #[inline]
    fn shadowing_denominator(&self, cos: f32) -> f32 {
        let k = (self.alpha + 1.0) * (self.alpha + 1.0) / 8.0;
        cos * (1.0 - k) + k
    }

    #[inline]
    pub(super) fn eval_pdf(&self, wo: Vec3, wi: Vec3) -> (Vec3, f32) {
        let [diffuse, shiny] = self.lobes(wo, wi);
        let pdf =
            (1.0 - self.specular_probability) * diffuse.1 + shiny.1 * self.specular_probability;
        (diffuse.0 + shiny.0, pdf)
    }

    /// f cos and density of each lobe alone: diffuse, shiny.
    #[inline]
    fn lobes(&self, wo: Vec3, wi: Vec3) -> [(Vec3, f32); 2] {
        let half = wo + wi;
        let length = half.length_squared().sqrt();
        if length <= 0.0 {
            return [(Vec3::ZERO, 0.0); 2];
        }
        let cos_half = (0.5 * length).min(1.0);
        let fresnel = schlick(self.f0, cos_half);
        let cosine = FRAC_1_PI * wi.z;
        let diffuse = ((Vec3::ONE - fresnel) * self.kd * cosine, cosine);
        if self.alpha == 0.0 {
            return [diffuse, (Vec3::ZERO, 0.0)];
        }
        let d = ggx_d(self.alpha, half);
        let shadowing = 4.0 * self.shadowing_denominator(wo.z) * self.shadowing_denominator(wi.z);
        let density = d * half.z / (length * 4.0 * cos_half);
        [diffuse, (fresnel * (d * wi.z / shadowing), density)]
    }

    #[inline]
    pub(super) fn sample(&self, wo: Vec3, u: [f32; 3]) -> Option<BsdfSample> {
        let is_shiny = u[0] < self.specular_probability;
        let wi = if !is_shiny {
            cosine_hemisphere([u[1], u[2]])
        } else if self.alpha > 0.0 {
            let half = sample_normal(self.alpha, [u[1], u[2]]);
            if wo.dot(half) <= 0.0 {
                return None;
            }
            reflect(wo, half)
        } else {
            let g1 = wo.z / self.shadowing_denominator(wo.z);
            return mirror(
                schlick(self.f0, wo.z) * (g1 * g1),
                self.specular_probability,
                wo,
            );
        };
        if !above(wi) {
            return None;
        }
        match self.sampling {
            LobeSampling::Mixture => mixture_sample(wi, self.eval_pdf(wo, wi)),
            LobeSampling::Lobe => {
                let lobes = self.lobes(wo, wi);
                lobe_sample(wi, lobes, self.specular_probability, is_shiny)
            }
        }
    }

    pub(super) fn albedo(&self) -> Vec3 {
        self.f0 + self.kd * (Vec3::ONE - self.f0)
    }
    pub(super) fn alpha(&self) -> f32 {
        self.alpha
    }
    pub(super) fn has_body(&self) -> bool {
        self.kd != Vec3::ZERO
    }
    pub(super) fn is_delta(&self) -> bool {
        self.alpha == 0.0 && !self.has_body()
    }
}

/// A half vector with density D cos: tan^2 = alpha^2 u/(1 - u) (Walter et al.
/// 2007, eq. 35).
#[inline]
fn sample_normal(alpha: f32, u: [f32; 2]) -> Vec3 {
    let tan = alpha * (u[0] / (1.0 - u[0])).sqrt();
    let cos = 1.0 / (1.0 + tan * tan).sqrt();
    let sin = tan * cos;
    let (sin_phi, cos_phi) = azimuth(u[1]);
    Vec3::new(sin * cos_phi, sin * sin_phi, cos)
}
