//! Fresnel reflectance.

use glam::Vec3;

/// (1 - cos)^5, the rise towards grazing in Schlick's approximation (1994);
/// `cos` is clamped to [0, 1].
#[inline]
#[must_use]
pub fn schlick_weight(cos: f32) -> f32 {
    let m = (1.0 - cos).clamp(0.0, 1.0);
    let m2 = m * m;
    m2 * m2 * m
}

/// Schlick's reflectance: `f0` at normal incidence, 1 at grazing.
#[inline]
#[must_use]
pub fn schlick(f0: Vec3, cos: f32) -> Vec3 {
    f0 + (Vec3::ONE - f0) * schlick_weight(cos)
}

/// Exact reflectance of unpolarised light at a smooth dielectric, from the
/// outside; `eta` is the ratio of indices inside/outside, at least 1, and
/// `cos` the cosine outside, clamped to [0, 1]. In the form of Cook and
/// Torrance 1982 with g^2 = eta^2 - 1 + c^2.
#[inline]
#[must_use]
pub fn dielectric(eta: f32, cos: f32) -> f32 {
    let c = cos.clamp(0.0, 1.0);
    let g = (eta * eta - 1.0 + c * c).max(0.0).sqrt();
    let sum = g + c;
    if sum <= 0.0 {
        return 0.0;
    }
    let ratio = (g - c) / sum;
    let tilt = (c * sum - 1.0) / (c * (g - c) + 1.0);
    0.5 * ratio * ratio * (1.0 + tilt * tilt)
}

/// Reflectance of [`dielectric`] at normal incidence.
#[inline]
#[must_use]
pub fn dielectric_f0(eta: f32) -> f32 {
    let r = (eta - 1.0) / (eta + 1.0);
    r * r
}

/// Rec. 709 luminance: weighs colours when a lobe is chosen.
#[inline]
#[must_use]
pub fn luminance(c: Vec3) -> f32 {
    0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z
}
