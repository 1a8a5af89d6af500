//! Metals by exact or edge-tinted Fresnel, mixed with dielectrics, under a clear
//! coat.
//!
//! With w E_c(mu) the share that the coat reflects at cosine mu, the base below it
//! counts (1 - w E_c(o)) (1 - w E_c(i)): what gets in times what gets out again.
//! That is reciprocal and never reflects more than arrives; light thrown back
//! into the base by the coat's underside is left out (it is what a white base
//! lacks in a furnace).

use glam::Vec3;

use super::albedo::AlphaRow;
use super::error::{check_color, check_range};
use super::fresnel::{f82_depth, luminance};
use super::interface::{self, Body, Interface, mirror, mirror_or};
use super::layer::{Coat, Layer, LayerParameters, MetalLaw, Mixed};
use super::lobe::{above, mixture_sample, specular_probability};
use super::microfacet::{reflect, reflection, sample_visible_normal};
use super::tables::Tables;
use super::{BsdfError, BsdfSample, GgxParameters};

/// The largest float below 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// A layered metal at a hit: what the texel says and the number of the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layered {
    base_color: Vec3,
    /// Reflectance of the base at normal incidence.
    f0: Vec3,
    metalness: f32,
    dielectric_f0: f32,
    alpha: f32,
    layer: u16,
    /// The coat is missing or a mirror.
    smooth_coat: bool,
}

/// The base below the coat, unpacked for one evaluation.
struct Base {
    curve: Mixed,
    row: AlphaRow,
    conductor: u16,
    body: Body,
}

impl Interface for Base {
    #[inline]
    fn fresnel(&self, cos_half: f32) -> Vec3 {
        self.curve.fresnel(cos_half)
    }
    #[inline]
    fn directional_albedo(&self, tables: &Tables, cos: f32) -> Vec3 {
        self.albedo(
            || tables.schlick_albedo(self.row, cos),
            || tables.dip_albedo(self.row, cos),
            || tables.conductor_albedo(self.conductor, self.row, cos),
        )
    }
}

impl Base {
    /// The albedo of the interface from those of its parts, in which it is
    /// linear.
    #[inline]
    fn albedo(
        &self,
        schlick: impl Fn() -> [f32; 2],
        dip: impl Fn() -> f32,
        conductor: impl Fn() -> Vec3,
    ) -> Vec3 {
        match self.curve {
            Mixed::Schlick { f0, depth } => {
                let [scale, bias] = schlick();
                let albedo = f0 * scale + bias;
                if depth == Vec3::ZERO {
                    albedo
                } else {
                    albedo - depth * dip()
                }
            }
            Mixed::Conductor {
                dielectric_f0,
                metalness,
                tint,
                ..
            } => {
                let metal = tint * conductor() * metalness;
                if metalness >= 1.0 {
                    return metal;
                }
                let [scale, bias] = schlick();
                metal + (dielectric_f0 * scale + bias) * (1.0 - metalness)
            }
        }
    }

    fn average(&self, tables: &Tables) -> Vec3 {
        self.albedo(
            || tables.schlick_average(self.row),
            || tables.dip_average(self.row),
            || tables.conductor_average(self.conductor, self.row),
        )
    }
}

impl Layered {
    /// The material.
    ///
    /// # Errors
    /// [`BsdfError`] if a parameter leaves [0, 1] or `tables` was built without
    /// `layer`.
    pub fn new(
        tables: &Tables,
        parameters: &GgxParameters,
        layer: &LayerParameters,
    ) -> Result<Self, BsdfError> {
        let number = tables.layer_number(layer)?;
        let plain = Self {
            base_color: Vec3::ZERO,
            f0: Vec3::ZERO,
            metalness: 0.0,
            dielectric_f0: check_range("dielectric_f0", parameters.dielectric_f0, 0.0, 1.0)?,
            alpha: 0.0,
            layer: number,
            smooth_coat: layer.coat.is_none_or(|coat| mirror_or(coat.alpha) == 0.0),
        };
        let alpha = check_range("alpha", parameters.alpha, 0.0, 1.0)?;
        let metalness = check_range("metalness", parameters.metalness, 0.0, 1.0)?;
        let base_color = check_color("base_color", parameters.base_color)?;
        Ok(plain.with_texel(tables, base_color, metalness, alpha))
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
        self.base_color = base_color;
        self.metalness = metalness;
        self.alpha = mirror_or(alpha);
        let dielectric = Vec3::splat(self.dielectric_f0);
        let metal = tables
            .layer(self.layer)
            .map_or(base_color, |layer| layer.metal_f0(base_color));
        self.f0 = dielectric + (metal - dielectric) * metalness;
        self
    }

    #[inline]
    fn base(&self, tables: &Tables, layer: &Layer) -> Base {
        let curve = match layer.metal {
            MetalLaw::Schlick => Mixed::Schlick {
                f0: self.f0,
                depth: Vec3::ZERO,
            },
            MetalLaw::F82 { tint } => Mixed::Schlick {
                f0: self.f0,
                depth: f82_depth(self.base_color, tint) * self.metalness,
            },
            MetalLaw::Conductor { n, k } => Mixed::Conductor {
                dielectric_f0: self.dielectric_f0,
                metalness: self.metalness,
                tint: self.base_color,
                n,
                k,
            },
        };
        let mut base = Base {
            curve,
            row: AlphaRow::new(self.alpha),
            conductor: layer.conductor,
            body: Body::new(Vec3::ZERO, Vec3::ZERO),
        };
        if self.has_body() {
            let color = self.base_color * (1.0 - self.metalness);
            base.body = Body::new(color, base.average(tables));
        }
        base
    }

    #[inline]
    pub(super) fn eval_pdf(&self, tables: &Tables, wo: Vec3, wi: Vec3) -> (Vec3, f32) {
        let Some(layer) = tables.layer(self.layer) else {
            return (Vec3::ZERO, 0.0);
        };
        let base = self.base(tables, layer);
        let below = interface::eval_pdf(&base, self.alpha, &base.body, tables, wo, wi);
        match &layer.coat {
            None => below,
            Some(coat) => {
                let view = CoatView::new(coat, &base, tables, wo.z);
                coated(coat, &view, tables, below, wo, wi)
            }
        }
    }

    #[inline]
    pub(super) fn sample(&self, tables: &Tables, wo: Vec3, u: [f32; 3]) -> Option<BsdfSample> {
        let layer = tables.layer(self.layer)?;
        let base = self.base(tables, layer);
        let below = |u| interface::sample(&base, self.alpha, &base.body, tables, wo, u);
        let Some(coat) = &layer.coat else {
            return below(u);
        };
        let view = CoatView::new(coat, &base, tables, wo.z);
        let wi = if u[0] < view.probability {
            if coat.alpha == 0.0 {
                return mirror(Vec3::splat(coat.fresnel(wo.z)), view.probability, wo);
            }
            reflect(wo, sample_visible_normal(coat.alpha, wo, [u[1], u[2]]))
        } else {
            let others = 1.0 - view.probability;
            let again = ((u[0] - view.probability) / others).min(BELOW_ONE);
            let mut sample = below([again, u[1], u[2]])?;
            if sample.delta {
                // Both cosines are the same.
                sample.weight *= view.passed * view.passed / others;
                sample.pdf *= others;
                return Some(sample);
            }
            sample.wi
        };
        if !above(wi) {
            return None;
        }
        let value = interface::eval_pdf(&base, self.alpha, &base.body, tables, wo, wi);
        mixture_sample(wi, coated(coat, &view, tables, value, wo, wi))
    }

    pub(super) fn albedo(&self) -> Vec3 {
        let body = self.base_color * (1.0 - self.metalness);
        self.f0 + body * (Vec3::ONE - self.f0)
    }
    pub(super) fn alpha(&self) -> f32 {
        self.alpha
    }
    pub(super) fn has_body(&self) -> bool {
        self.metalness < 1.0 && self.base_color != Vec3::ZERO
    }
    pub(super) fn is_delta(&self) -> bool {
        self.alpha == 0.0 && self.smooth_coat && !self.has_body()
    }
}

/// What `wo` alone decides about a coat.
struct CoatView {
    /// 1 - w E_c(o).
    passed: f32,
    /// Probability of the coat's lobe.
    probability: f32,
}

impl CoatView {
    #[inline]
    fn new(coat: &Coat, base: &Base, tables: &Tables, cos_o: f32) -> Self {
        let reflected = coat.reflected(tables, cos_o).min(1.0);
        let passed = 1.0 - reflected;
        let interface = base.directional_albedo(tables, cos_o);
        let below = interface + base.body.color * (Vec3::ONE - interface).max(Vec3::ZERO);
        // A layer of which nothing shows is never drawn: its value is 0 too.
        let below = if coat.weight > 0.0 {
            passed * luminance(below)
        } else {
            1.0
        };
        Self {
            passed,
            probability: specular_probability(reflected, below),
        }
    }
}

/// f cos and density of coat and base together, perfect mirrors left out;
/// `below` are those of the base alone.
#[inline]
fn coated(
    coat: &Coat,
    view: &CoatView,
    tables: &Tables,
    below: (Vec3, f32),
    wo: Vec3,
    wi: Vec3,
) -> (Vec3, f32) {
    let passed = view.passed * (1.0 - coat.reflected(tables, wi.z).min(1.0));
    let mut value = below.0 * passed;
    let mut pdf = below.1 * (1.0 - view.probability);
    if coat.alpha > 0.0 {
        let lobe = reflection(coat.alpha, wo, wi);
        value += coat.fresnel(lobe.cos_half) * lobe.value;
        pdf += view.probability * lobe.pdf;
    }
    (value, pdf)
}
