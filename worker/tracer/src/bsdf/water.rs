//! A dielectric interface with exact Fresnel over an opaque body colour.

use glam::Vec3;

use super::albedo::AlphaRow;
use super::error::{check_color, check_range};
use super::fresnel::{dielectric, dielectric_f0};
use super::interface::{self, Body, Interface, mirror_or};
use super::tables::Tables;
use super::{BsdfError, BsdfSample};

/// Index of refraction of water for visible light.
pub const WATER_ETA: f32 = 1.333;

/// The roughness alpha of waves too small to be seen one by one, from the
/// variance of their slope along one axis: alpha^2 = 2 sigma^2, as for a
/// Beckmann surface. In [0, 1].
#[inline]
#[must_use]
pub fn alpha_from_slope_variance(variance: f32) -> f32 {
    (2.0 * variance).clamp(0.0, 1.0).sqrt()
}

/// Water: what is not reflected reaches an opaque body (the colour of the deep)
/// through the energy-conserving coupling of [`super::Ggx`], with exact Fresnel
/// instead of Schlick's, which is a few per cent off near grazing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Water {
    body: Body,
    eta: f32,
    alpha: f32,
    row: AlphaRow,
    table: u16,
}

impl Interface for Water {
    #[inline]
    fn fresnel(&self, cos_half: f32) -> Vec3 {
        Vec3::splat(dielectric(self.eta, cos_half))
    }
    #[inline]
    fn directional_albedo(&self, tables: &Tables, cos: f32) -> Vec3 {
        Vec3::splat(tables.dielectric_albedo(self.table, self.row, cos))
    }
}

impl Water {
    /// A surface of roughness `alpha` in [0, 1] (0 is a perfect mirror) and
    /// index `eta` over a body of colour `body_color`.
    ///
    /// # Errors
    /// [`BsdfError`] if a parameter is out of range or `tables` was built
    /// without this `eta`.
    pub fn new(tables: &Tables, eta: f32, body_color: Vec3, alpha: f32) -> Result<Self, BsdfError> {
        let table = tables.dielectric_index(eta)?;
        let body_color = check_color("body_color", body_color)?;
        let alpha = check_range("alpha", alpha, 0.0, 1.0)?;
        let body = Body::new(body_color, Vec3::ZERO);
        let plain = Self {
            body,
            eta,
            alpha,
            row: AlphaRow::new(alpha),
            table,
        };
        Ok(plain.with_alpha(tables, alpha))
    }

    /// The same surface where it is rougher, for example by the slope variance
    /// that the footprint of a distant pixel averages over
    /// ([`alpha_from_slope_variance`]). Clamped to [0, 1].
    #[inline]
    #[must_use]
    pub fn with_alpha(mut self, tables: &Tables, alpha: f32) -> Self {
        self.alpha = mirror_or(alpha);
        self.row = AlphaRow::new(self.alpha);
        let average = tables.dielectric_average(self.table, self.row);
        self.body = Body::new(self.body.color, Vec3::splat(average));
        self
    }

    /// [`Self::with_alpha`] over another body, `body_color` in [0, 1].
    #[inline]
    #[must_use]
    pub fn with_body(mut self, tables: &Tables, body_color: Vec3, alpha: f32) -> Self {
        self.body.color = body_color;
        self.with_alpha(tables, alpha)
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
        let f0 = dielectric_f0(self.eta);
        self.body.color * (1.0 - f0) + f0
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
