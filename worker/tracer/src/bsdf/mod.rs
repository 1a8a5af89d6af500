//! How surfaces reflect: a closed set of models in local coordinates.
//!
//! z is the shading normal, both directions are unit vectors that leave the
//! surface, and `wo.z >= 0` is the caller's promise ([`shading_frame`] keeps
//! it); a `wo` below the surface reflects nothing. Every value already contains
//! the cosine of `wi`. Colours are linear RGB.
//!
//! All models are one-sided: nothing passes through.

mod albedo;
mod error;
pub mod fresnel;
pub mod ggx;
pub mod ggx_report;
mod interface;
pub mod layer;
pub mod layered;
pub mod leaning;
mod lobe;
pub mod microfacet;
pub mod phong;
pub mod shading_frame;
pub mod tables;
pub mod water;

use glam::Vec3;

pub use error::BsdfError;
pub use ggx::Ggx;
pub use ggx_report::GgxReport;
pub use layer::{CoatParameters, LayerParameters, MetalLaw};
pub use layered::Layered;
pub use phong::Phong;
pub use tables::{TableNeeds, Tables};
pub use water::Water;

/// Above this roughness, in terms of GGX alpha, a lobe is wide enough for
/// samples of the whole sky to find it better than its own directions find the
/// sky's bright places.
const LIGHT_SAMPLING_ALPHA_MIN: f32 = 0.3;

/// One sampled direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// The direction the light comes from, unit, `z > 0`.
    pub wi: Vec3,
    /// f cos / pdf, at least 0 and finite.
    pub weight: Vec3,
    /// The density of `wi` per steradian over all lobes; if `delta`, the
    /// probability with which the mirror was chosen.
    pub pdf: f32,
    /// Whether `wi` is the one direction of a perfect mirror, which no light
    /// sampling can find and no multiple importance weight applies to.
    pub delta: bool,
}

/// Which formulas a GGX material follows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GgxModel {
    /// Exact Smith, visible normals, energy-conserving diffuse: [`Ggx`].
    #[default]
    Corrected,
    /// The formulas of the report this renderer began with, with their energy
    /// errors, for comparison: [`GgxReport`].
    Report,
}

/// How a model of two lobes draws a direction; both are right in the mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LobeSampling {
    /// From one lobe, weighed by the density of both: the one-sample balance
    /// heuristic (Veach and Guibas 1995), which has less variance.
    #[default]
    Mixture,
    /// From one lobe, whose value is weighed by its own density: the report's.
    Lobe,
}

/// A GGX material as described, before a model is chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GgxParameters {
    /// Albedo of the body, or F0 of the metal, in [0, 1].
    pub base_color: Vec3,
    /// 0 is a dielectric, 1 a metal.
    pub metalness: f32,
    /// GGX roughness alpha in [0, 1] (not its square root).
    pub alpha: f32,
    /// Reflectance of the dielectric at normal incidence; 0.04 for an index of
    /// 1.5.
    pub dielectric_f0: f32,
}

impl Default for GgxParameters {
    fn default() -> Self {
        Self {
            base_color: Vec3::splat(0.5),
            metalness: 0.0,
            alpha: 0.25,
            dielectric_f0: 0.04,
        }
    }
}

/// A surface's reflection, ready at the hit. Small plain data; `match` decides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bsdf {
    /// Perfectly diffuse.
    Lambert {
        /// Reflected share per channel, in [0, 1].
        albedo: Vec3,
    },
    /// Modified Phong (Lafortune and Willems 1994).
    Phong(Phong),
    /// Cook-Torrance over an energy-conserving diffuse body.
    Ggx(Ggx),
    /// The report's Cook-Torrance.
    GgxReport(GgxReport),
    /// Dielectric interface with exact Fresnel over an opaque body.
    #[cfg(feature = "effects")]
    Water(Water),
    /// Exact or edge-tinted metal, maybe under a clear coat.
    Layered(Layered),
}

impl Bsdf {
    /// A GGX material under either model.
    ///
    /// # Errors
    /// [`BsdfError`] if a parameter is out of range or, for
    /// [`GgxModel::Corrected`], `tables` was built without Schlick's table.
    pub fn ggx(
        tables: &Tables,
        model: GgxModel,
        parameters: &GgxParameters,
    ) -> Result<Self, BsdfError> {
        Ok(match model {
            GgxModel::Corrected => Self::Ggx(Ggx::new(tables, parameters)?),
            GgxModel::Report => Self::GgxReport(GgxReport::new(parameters)?),
        })
    }

    /// f cos(wi) and the density per steradian with which [`Bsdf::sample`]
    /// makes `wi`, perfect mirrors left out of both. Zero if either direction
    /// lies below the surface.
    #[inline]
    #[must_use]
    pub fn eval_pdf(&self, tables: &Tables, wo: Vec3, wi: Vec3) -> (Vec3, f32) {
        if !(wo.z >= 0.0 && wi.z > 0.0) {
            return (Vec3::ZERO, 0.0);
        }
        match self {
            Self::Lambert { albedo } => lobe::lambert(*albedo, wi),
            Self::Phong(phong) => phong.eval_pdf(wo, wi),
            Self::Ggx(ggx) => ggx.eval_pdf(tables, wo, wi),
            Self::GgxReport(ggx) => ggx.eval_pdf(wo, wi),
            #[cfg(feature = "effects")]
            Self::Water(water) => water.eval_pdf(tables, wo, wi),
            Self::Layered(metal) => metal.eval_pdf(tables, wo, wi),
        }
    }

    /// A direction drawn in proportion to the model as well as it can be;
    /// `None` if the sample is absorbed (drawn below the surface, or the
    /// surface is black). `u` are uniform in [0, 1); the first chooses a lobe.
    #[inline]
    #[must_use]
    pub fn sample(&self, tables: &Tables, wo: Vec3, u: [f32; 3]) -> Option<BsdfSample> {
        if wo.z.is_nan() || wo.z < 0.0 {
            return None;
        }
        match self {
            Self::Lambert { albedo } => lobe::sample_lambert(*albedo, [u[1], u[2]]),
            Self::Phong(phong) => phong.sample(wo, u),
            Self::Ggx(ggx) => ggx.sample(tables, wo, u),
            Self::GgxReport(ggx) => ggx.sample(wo, u),
            #[cfg(feature = "effects")]
            Self::Water(water) => water.sample(tables, wo, u),
            Self::Layered(metal) => metal.sample(tables, wo, u),
        }
    }

    /// A colour for the albedo image: what the surface reflects at normal
    /// incidence, roughly.
    #[must_use]
    pub fn albedo(&self) -> Vec3 {
        match self {
            Self::Lambert { albedo } => *albedo,
            Self::Phong(phong) => phong.kd + phong.ks,
            Self::Ggx(ggx) => ggx.albedo(),
            Self::GgxReport(ggx) => ggx.albedo(),
            #[cfg(feature = "effects")]
            Self::Water(water) => water.albedo(),
            Self::Layered(metal) => metal.albedo(),
        }
    }

    /// Whether the surface is nothing but a perfect mirror: [`Bsdf::eval_pdf`]
    /// is 0 everywhere.
    #[inline]
    #[must_use]
    pub fn is_delta(&self) -> bool {
        match self {
            Self::Lambert { .. } | Self::Phong(_) => false,
            Self::Ggx(ggx) => ggx.is_delta(),
            Self::GgxReport(ggx) => ggx.is_delta(),
            #[cfg(feature = "effects")]
            Self::Water(water) => water.is_delta(),
            Self::Layered(metal) => metal.is_delta(),
        }
    }

    /// Roughness of the shiny lobe as a GGX alpha: 0 for a mirror, 1 for
    /// Lambert; Phong by alpha^2 = 2/(n + 2) (Walter et al. 2007).
    #[inline]
    #[must_use]
    pub fn roughness(&self) -> f32 {
        match self {
            Self::Lambert { .. } => 1.0,
            Self::Phong(phong) => phong.roughness(),
            Self::Ggx(ggx) => ggx.alpha(),
            Self::GgxReport(ggx) => ggx.alpha(),
            #[cfg(feature = "effects")]
            Self::Water(water) => water.alpha(),
            Self::Layered(metal) => metal.alpha(),
        }
    }

    /// Whether the model has a diffuse part.
    #[inline]
    #[must_use]
    pub fn has_diffuse(&self) -> bool {
        match self {
            Self::Lambert { albedo } => *albedo != Vec3::ZERO,
            Self::Phong(phong) => phong.kd != Vec3::ZERO,
            Self::Ggx(ggx) => ggx.has_body(),
            Self::GgxReport(ggx) => ggx.has_body(),
            #[cfg(feature = "effects")]
            Self::Water(water) => water.has_body(),
            Self::Layered(metal) => metal.has_body(),
        }
    }

    /// Whether sampling a wide light (the sky) from here finds more than the
    /// model's own directions do: there is a diffuse part worth the name, or a
    /// wide lobe. Water's body is too dark to count.
    #[inline]
    #[must_use]
    pub fn light_sampling_pays(&self) -> bool {
        match self {
            #[cfg(feature = "effects")]
            Self::Water(water) => water.alpha() > LIGHT_SAMPLING_ALPHA_MIN,
            _ => self.has_diffuse() || self.roughness() > LIGHT_SAMPLING_ALPHA_MIN,
        }
    }
}
