//! A microfacet interface over an opaque diffuse body, for any Fresnel law.
//!
//! The body gets exactly the light that the interface does not reflect:
//! f_d = rho/pi (1 - E(o)) (1 - E(i)) / (1 - E_avg), with E the interface's
//! directional albedo (Kelemen and Szirmay-Kalos 2001). A white body over a
//! lossless interface then reflects all light at every angle, and reciprocity
//! holds.

use core::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::BsdfSample;
use super::fresnel::luminance;
use super::lobe::{above, mixture_sample, specular_probability};
use super::microfacet::{MIRROR_ALPHA_MAX, reflect, reflection, sample_visible_normal};
use super::tables::Tables;
use crate::math::warp::cosine_hemisphere;

/// Keeps the quotient finite where the interface reflects everything; the body
/// sees nothing there, and gets a factor (1 - E)^2 besides.
const ABSORBED_AVERAGE_MIN: f32 = 1e-6;

/// The Fresnel law of an interface and its directional albedo under the
/// microfacet lobe.
pub(super) trait Interface {
    /// Reflectance at a microfacet.
    fn fresnel(&self, cos_half: f32) -> Vec3;
    /// Share of light from the direction with this cosine that the rough
    /// interface reflects.
    fn directional_albedo(&self, tables: &Tables, cos: f32) -> Vec3;
}

/// The body below an interface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Body {
    /// Albedo rho.
    pub(super) color: Vec3,
    /// rho / (pi (1 - E_avg)).
    scale: Vec3,
}

impl Body {
    /// A body of albedo `color` below an interface of average albedo `average`.
    #[inline]
    pub(super) fn new(color: Vec3, average: Vec3) -> Self {
        let absorbed = (Vec3::ONE - average).max(Vec3::splat(ABSORBED_AVERAGE_MIN));
        Self {
            color,
            scale: color * FRAC_1_PI / absorbed,
        }
    }

    /// Whether there is a body at all.
    #[inline]
    pub(super) fn exists(&self) -> bool {
        self.color != Vec3::ZERO
    }
}

/// alpha, or exactly 0 where the interface counts as a mirror.
#[inline]
pub(super) fn mirror_or(alpha: f32) -> f32 {
    if alpha < MIRROR_ALPHA_MAX {
        0.0
    } else {
        alpha.min(1.0)
    }
}

/// What `wo` alone decides.
struct View {
    /// 1 - E(o); not used without a body.
    passed: Vec3,
    /// Probability of the specular lobe.
    specular: f32,
}

#[inline]
fn view<I: Interface>(interface: &I, body: &Body, tables: &Tables, cos_o: f32) -> View {
    if !body.exists() {
        return View {
            passed: Vec3::ZERO,
            specular: 1.0,
        };
    }
    let reflected = interface.directional_albedo(tables, cos_o);
    // Clamped: a reflectance of 1 may round to a little more.
    let passed = (Vec3::ONE - reflected).max(Vec3::ZERO);
    View {
        passed,
        specular: specular_probability(luminance(reflected), luminance(body.color * passed)),
    }
}

/// f cos and density of everything but a perfect mirror.
#[inline]
fn mixture<I: Interface>(
    interface: &I,
    alpha: f32,
    body: &Body,
    tables: &Tables,
    view: &View,
    wo: Vec3,
    wi: Vec3,
) -> (Vec3, f32) {
    let (mut value, mut pdf) = (Vec3::ZERO, 0.0);
    if alpha > 0.0 {
        let lobe = reflection(alpha, wo, wi);
        value = interface.fresnel(lobe.cos_half) * lobe.value;
        pdf = view.specular * lobe.pdf;
    }
    if body.exists() {
        let passed = (Vec3::ONE - interface.directional_albedo(tables, wi.z)).max(Vec3::ZERO);
        value += body.scale * view.passed * passed * wi.z;
        pdf += (1.0 - view.specular) * FRAC_1_PI * wi.z;
    }
    (value, pdf)
}

/// See [`super::Bsdf::eval_pdf`].
#[inline]
pub(super) fn eval_pdf<I: Interface>(
    interface: &I,
    alpha: f32,
    body: &Body,
    tables: &Tables,
    wo: Vec3,
    wi: Vec3,
) -> (Vec3, f32) {
    let view = view(interface, body, tables, wo.z);
    mixture(interface, alpha, body, tables, &view, wo, wi)
}

/// See [`super::Bsdf::sample`].
#[inline]
pub(super) fn sample<I: Interface>(
    interface: &I,
    alpha: f32,
    body: &Body,
    tables: &Tables,
    wo: Vec3,
    u: [f32; 3],
) -> Option<BsdfSample> {
    let view = view(interface, body, tables, wo.z);
    let wi = if u[0] >= view.specular {
        cosine_hemisphere([u[1], u[2]])
    } else if alpha > 0.0 {
        reflect(wo, sample_visible_normal(alpha, wo, [u[1], u[2]]))
    } else {
        return mirror(interface.fresnel(wo.z), view.specular, wo);
    };
    if !above(wi) {
        return None;
    }
    mixture_sample(wi, mixture(interface, alpha, body, tables, &view, wo, wi))
}

/// The mirror direction, chosen with `probability`.
#[inline]
pub(super) fn mirror(reflectance: Vec3, probability: f32, wo: Vec3) -> Option<BsdfSample> {
    if wo.z > 0.0 && reflectance != Vec3::ZERO {
        let wi = Vec3::new(-wo.x, -wo.y, wo.z);
        Some(BsdfSample {
            wi,
            weight: reflectance / probability,
            pdf: probability,
            delta: true,
        })
    } else {
        None
    }
}
