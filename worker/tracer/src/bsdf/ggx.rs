//! Cook-Torrance with GGX normals: metals and coated dielectrics.

use glam::Vec3;

use super::albedo::AlphaRow;
use super::error::{check_color, check_range};
use super::fresnel::schlick;
use super::interface::{self, Body, Interface, mirror_or};
use super::tables::Tables;
use super::{BsdfError, BsdfSample, GgxParameters};

/// GGX reflection (visible normals, exact height-correlated Smith) with
/// Schlick's Fresnel, over an energy-conserving diffuse body. Metals have a
/// coloured F0 and no body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    f0: Vec3,
    body: Body,
    metalness: f32,
    dielectric_f0: f32,
    alpha: f32,
    row: AlphaRow,
}

impl Interface for Ggx {
    #[inline]
    fn fresnel(&self, cos_half: f32) -> Vec3 {
        schlick(self.f0, cos_half)
    }
    #[inline]
    fn directional_albedo(&self, tables: &Tables, cos: f32) -> Vec3 {
        let [scale, bias] = tables.schlick_albedo(self.row, cos);
        self.f0 * scale + bias
    }
}

impl Ggx {
    /// The material; alpha below
    /// [`MIRROR_ALPHA_MAX`](super::microfacet::MIRROR_ALPHA_MAX) is a perfect
    /// mirror.
    ///
    /// # Errors
    /// [`BsdfError`] if a parameter leaves [0, 1] or `tables` lacks Schlick's.
    pub fn new(tables: &Tables, parameters: &GgxParameters) -> Result<Self, BsdfError> {
        tables.require_schlick()?;
        let base_color = check_color("base_color", parameters.base_color)?;
        let alpha = mirror_or(check_range("alpha", parameters.alpha, 0.0, 1.0)?);
        let plain = Self {
            f0: Vec3::ZERO,
            body: Body::new(Vec3::ZERO, Vec3::ZERO),
            metalness: check_range("metalness", parameters.metalness, 0.0, 1.0)?,
            dielectric_f0: check_range("dielectric_f0", parameters.dielectric_f0, 0.0, 1.0)?,
            alpha,
            row: AlphaRow::new(alpha),
        };
        Ok(plain.with_base_color(tables, base_color))
    }

    /// The same material in the colour of a texel, each channel in [0, 1].
    #[inline]
    #[must_use]
    pub fn with_base_color(mut self, tables: &Tables, base_color: Vec3) -> Self {
        let dielectric = Vec3::splat(self.dielectric_f0);
        self.f0 = dielectric + (base_color - dielectric) * self.metalness;
        let [scale, bias] = tables.schlick_average(self.row);
        self.body = Body::new(base_color * (1.0 - self.metalness), self.f0 * scale + bias);
        self
    }

    /// The same material where its textures say this, everything in [0, 1].
    #[inline]
    #[must_use]
    pub fn with_texel(
        mut self,
        tables: &Tables,
        base_color: Vec3,
        metalness: f32,
        alpha: f32,
    ) -> Self {
        self.metalness = metalness;
        self.alpha = mirror_or(alpha);
        self.row = AlphaRow::new(self.alpha);
        self.with_base_color(tables, base_color)
    }

    #[inline]
    pub(super) fn eval_pdf(&self, tables: &Tables, wo: Vec3, wi: Vec3) -> (Vec3, f32) {
        interface::eval_pdf(self, self.alpha, &self.body, tables, wo, wi)
    }

    #[inline]
    pub(super) fn sample(&self, tables: &Tables, wo: Vec3, u: [f32; 3]) -> Option<BsdfSample> {
        interface::sample(self, self.alpha, &self.body, tables, wo, u)
    }

    pub(super) fn albedo(&self) -> Vec3 {
        self.f0 + self.body.color * (Vec3::ONE - self.f0)
    }
    pub(super) fn alpha(&self) -> f32 {
        self.alpha
    }
    pub(super) fn has_body(&self) -> bool {
        self.body.exists()
    }
    pub(super) fn is_delta(&self) -> bool {
        self.alpha == 0.0 && !self.body.exists()
    }
}
