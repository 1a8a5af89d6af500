//! The GGX (Trowbridge-Reitz) microfacet distribution with Smith shadowing, in
//! local coordinates (z is the shading normal, both directions leave the
//! surface).

use core::f32::consts::FRAC_1_PI;

use glam::Vec3;

use crate::math::warp::azimuth;

/// Below this alpha a surface reflects as a perfect mirror: its lobe (0.11
/// degrees wide) is narrower than the sun, and f32 directions would begin to
/// show their grain in it.
pub const MIRROR_ALPHA_MAX: f32 = 1e-3;

/// One pair of directions seen by the distribution.
#[derive(Clone, Copy, Debug)]
pub struct Reflection {
    /// D G2 / (4 cos_o cos_i) * cos_i: the lobe without Fresnel.
    pub value: f32,
    /// The density of `wi` per steradian when visible normals are sampled.
    pub pdf: f32,
    /// The cosine between a direction and the half vector.
    pub cos_half: f32,
}

/// D(h) per steradian for a half vector of any length. At h = n it is exactly
/// 1/(pi alpha^2) also for tiny alpha: nothing is formed as 1 - cos^2
/// (Trowbridge and Reitz 1975; Walter et al. 2007, eq. 33).
#[inline]
#[must_use]
pub fn ggx_d(alpha: f32, half: Vec3) -> f32 {
    let a2 = alpha * alpha;
    let length2 = half.length_squared();
    let spread = half.x * half.x + half.y * half.y + a2 * half.z * half.z;
    // length^4 / spread^2, divided first: spread^2 alone can underflow.
    let ratio = length2 / spread;
    FRAC_1_PI * a2 * ratio * ratio
}

/// sqrt(z^2 + alpha^2 (x^2 + y^2)), the common part of Smith's functions:
/// G1 = 2z / (z + this).
#[inline]
#[must_use]
pub fn smith_length(alpha: f32, w: Vec3) -> f32 {
    (w.z * w.z + alpha * alpha * (w.x * w.x + w.y * w.y)).sqrt()
}

/// The lobe with height-correlated Smith masking (Heitz 2014, eq. 99) for
/// `wo.z >= 0`, `wi.z > 0`, `alpha >= MIRROR_ALPHA_MAX`. Written so that
/// `wo.z = 0` is an ordinary value: neither term divides by a cosine.
#[inline]
#[must_use]
pub fn reflection(alpha: f32, wo: Vec3, wi: Vec3) -> Reflection {
    let half = wo + wi;
    let half_d = 0.5 * ggx_d(alpha, half);
    let (length_o, length_i) = (smith_length(alpha, wo), smith_length(alpha, wi));
    // G2 / (4 zo zi) = 1 / (2 (zo Li + zi Lo)); G1(o) / (4 zo) = 1 / (2 (zo + Lo)).
    let both = wo.z * length_i + wi.z * length_o;
    let one = wo.z + length_o;
    let scaled = half_d / (both * one);
    Reflection {
        value: scaled * one * wi.z,
        pdf: scaled * both,
        // |wo + wi| = 2 cos.
        cos_half: (0.5 * half.length_squared().sqrt()).min(1.0),
    }
}

/// A half vector, not normalised, with the density of the normals visible from
/// `wo`: in the stretched space they are a spherical cap (Dupuy and Benyoub
/// 2023).
#[inline]
#[must_use]
pub fn sample_visible_normal(alpha: f32, wo: Vec3, u: [f32; 2]) -> Vec3 {
    let stretched = Vec3::new(alpha * wo.x, alpha * wo.y, wo.z);
    let view = stretched * (1.0 / stretched.length_squared().sqrt());
    let z = (1.0 - u[0]) * (1.0 + view.z) - view.z;
    let sin = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
    let (sin_phi, cos_phi) = azimuth(u[1]);
    let cap = Vec3::new(sin * cos_phi, sin * sin_phi, z) + view;
    let normal = Vec3::new(alpha * cap.x, alpha * cap.y, cap.z.max(0.0));
    if normal == Vec3::ZERO {
        // Only the cap's very rim, opposite to the view.
        return Vec3::Z;
    }
    normal
}

/// The mirror image of `w` about a vector `h` of any length but 0.
#[inline]
#[must_use]
pub fn reflect(w: Vec3, h: Vec3) -> Vec3 {
    h * (2.0 * w.dot(h) / h.length_squared()) - w
}
