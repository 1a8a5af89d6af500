//! Deterministic integrals over the hemisphere of `wi`, in f64 and independent
//! of the samplers under test.
//!
//! Two maps cover the hemisphere: one follows the narrow lobe, one the cosine.
//! Each point counts f / (p1 + p2), a partition of unity, so that both a narrow
//! lobe and a diffuse floor under it are integrated well.

use core::f64::consts::{PI, TAU};

use glam::DVec3;
use shearwater_tracer::bsdf::{Bsdf, Tables};

/// The narrow map of a model.
#[derive(Clone, Copy)]
pub enum Narrow {
    /// Visible GGX normals of this alpha.
    Ggx(f64),
    /// The Phong lobe of this exponent.
    Phong(f64),
    /// None; the cosine alone.
    Nothing,
}

/// `count` points of a Fibonacci-like lattice (the golden ratio step).
pub fn lattice(count: u32) -> impl Iterator<Item = [f64; 2]> {
    (0..count).map(move |i| {
        let t = f64::from(i) * 0.618_033_988_749_894_9;
        [(f64::from(i) + 0.5) / f64::from(count), t - t.trunc()]
    })
}

pub fn polar(cos: f64, sin: f64, phi: f64) -> DVec3 {
    DVec3::new(sin * libm::cos(phi), sin * libm::sin(phi), cos)
}

/// Density of the cap map at `wi`: G1 D / (4 cos_o), in its own words.
fn ggx_pdf(alpha: f64, wo: DVec3, wi: DVec3) -> f64 {
    let h = (wo + wi).normalize();
    let e = (h.x * h.x + h.y * h.y) / (alpha * alpha) + h.z * h.z;
    let d = 1.0 / (PI * alpha * alpha * e * e);
    let slope2 = alpha * alpha * (wo.x * wo.x + wo.y * wo.y);
    // G1 / (4 cos_o) = 1 / (2 (cos_o + sqrt(cos_o^2 + a^2 sin_o^2))).
    d / (2.0 * (wo.z + (wo.z * wo.z + slope2).sqrt()))
}

/// A visible normal in Heitz's 2018 form (projected half discs), which is not
/// the one under test, and the Jacobian of the grading of u.
pub fn ggx_point(alpha: f64, wo: DVec3, u: [f64; 2]) -> (DVec3, f64) {
    let v = DVec3::new(alpha * wo.x, alpha * wo.y, wo.z).normalize();
    let flat = v.x * v.x + v.y * v.y;
    let t1 = if flat > 0.0 {
        DVec3::new(-v.y, v.x, 0.0) / flat.sqrt()
    } else {
        DVec3::X
    };
    let t2 = v.cross(t1);
    // More points near the rim: 1 - r^2 = w^3.
    let w = 1.0 - u[0];
    let r = (1.0 - w * w * w).sqrt();
    let (p1, p2) = (r * libm::cos(TAU * u[1]), r * libm::sin(TAU * u[1]));
    let s = 0.5 * (1.0 + v.z);
    let p2 = (1.0 - s) * (1.0 - p1 * p1).max(0.0).sqrt() + s * p2;
    let n = t1 * p1 + t2 * p2 + v * (1.0 - p1 * p1 - p2 * p2).max(0.0).sqrt();
    (
        DVec3::new(alpha * n.x, alpha * n.y, n.z.max(0.0)).normalize(),
        3.0 * w * w,
    )
}

impl Narrow {
    fn pdf(self, wo: DVec3, wi: DVec3) -> f64 {
        match self {
            Self::Ggx(alpha) => ggx_pdf(alpha, wo, wi),
            Self::Phong(n) => {
                let q = 0.5 * (DVec3::new(-wo.x, -wo.y, wo.z) - wi).length_squared();
                if q < 1.0 {
                    (n + 1.0) / TAU * libm::exp(n * libm::log1p(-q))
                } else {
                    0.0
                }
            }
            Self::Nothing => 0.0,
        }
    }

    /// A direction and the weight of its lattice point.
    fn point(self, wo: DVec3, u: [f64; 2]) -> Option<(DVec3, f64)> {
        match self {
            Self::Ggx(alpha) => {
                let (h, weight) = ggx_point(alpha, wo, u);
                Some((h * (2.0 * wo.dot(h)) - wo, weight))
            }
            Self::Phong(n) => {
                let q = -libm::expm1(libm::log1p(-u[0]) / (n + 1.0));
                let z = DVec3::new(-wo.x, -wo.y, wo.z);
                let x = z.any_orthonormal_vector();
                let local = polar(1.0 - q, (q * (2.0 - q)).sqrt(), TAU * u[1]);
                Some((x * local.x + z.cross(x) * local.y + z * local.z, 1.0))
            }
            Self::Nothing => None,
        }
    }
}

/// A unit vector at `degrees` from +z, in the plane y = 0.
pub fn direction(degrees: f64) -> DVec3 {
    let t = degrees.to_radians();
    DVec3::new(libm::sin(t), 0.0, libm::cos(t))
}

/// The integral over the hemisphere of `integrand(eval_pdf)`, that is, of
/// f cos or of the pdf.
pub fn integrate(
    bsdf: &Bsdf,
    tables: &Tables,
    wo: DVec3,
    narrow: Narrow,
    count: u32,
    integrand: impl Fn(glam::Vec3, f32) -> f64,
) -> f64 {
    let value = |wi: DVec3| {
        let (f, pdf) = bsdf.eval_pdf(tables, wo.as_vec3(), wi.as_vec3());
        integrand(f, pdf) / (narrow.pdf(wo, wi) + wi.z / PI)
    };
    let mut sum = 0.0;
    for u in lattice(count) {
        let wide = polar((1.0 - u[0]).sqrt(), u[0].sqrt(), TAU * u[1]);
        sum += value(wide);
        if let Some((wi, weight)) = narrow.point(wo, u)
            && wi.z > 0.0
        {
            sum += weight * value(wi);
        }
    }
    sum / f64::from(count)
}
