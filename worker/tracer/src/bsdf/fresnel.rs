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

/// Exact reflectance of unpolarised light at a smooth metal of complex index
/// n + ik seen from air; `cos` is clamped to [0, 1]. (a + ib)^2 = (n + ik)^2 -
/// sin^2 is known by its real part and its modulus a^2 + b^2 (Born and Wolf,
/// section 14.2; Lagarde 2013). k = 0 is [`dielectric`], also below n = 1.
#[inline]
#[must_use]
pub fn conductor(n: f32, k: f32, cos: f32) -> f32 {
    let c = cos.clamp(0.0, 1.0);
    let sin2 = (1.0 - c) * (1.0 + c);
    // n^2 - k^2 - sin^2, exact also where n is 1 and k is 0.
    let real = (n - 1.0) * (n + 1.0) - k * k + c * c;
    let modulus = (real * real + 4.0 * (n * k) * (n * k)).sqrt();
    // a^2 = (modulus + real)/2, without cancellation where real < 0, as in metals.
    let a2 = if real >= 0.0 {
        0.5 * (modulus + real)
    } else {
        2.0 * (n * k) * (n * k) / (modulus - real)
    };
    let twice = 2.0 * c * a2.sqrt();
    let square = modulus + c * c;
    let across = share(square - twice, square + twice);
    let (p, q) = (c * c * modulus + sin2 * sin2, twice * sin2);
    0.5 * across * (1.0 + share(p - q, p + q))
}

/// a / b in [0, 1]; 0 where nothing is divided by nothing.
#[inline]
fn share(a: f32, b: f32) -> f32 {
    if b > 0.0 {
        (a / b).clamp(0.0, 1.0)
    } else {
        0.0
    }
}

/// Reflectance of [`conductor`] at normal incidence:
/// ((n - 1)^2 + k^2) / ((n + 1)^2 + k^2).
#[inline]
#[must_use]
pub fn conductor_f0(n: f32, k: f32) -> f32 {
    let (less, more) = (n - 1.0, n + 1.0);
    (less * less + k * k) / (more * more + k * k)
}

/// The cosine of 81.8 degrees, where [`f82_dip`] is largest and the edge tint is
/// given.
pub const F82_COS: f32 = 1.0 / 7.0;

/// mu (1 - mu)^6: where metals lie below Schlick's curve (Lazanyi and
/// Szirmay-Kalos 2005), 0 at normal incidence and at grazing.
#[inline]
#[must_use]
pub fn f82_dip(cos: f32) -> f32 {
    let c = cos.clamp(0.0, 1.0);
    let m = 1.0 - c;
    let m2 = m * m;
    c * (m2 * m2 * m2)
}

/// How much of [`f82_dip`] Schlick's reflectance loses so that at
/// [`F82_COS`] `tint` of it is left (Kutz et al. 2021, "Novel aspects of the
/// Adobe Standard Material"). Less where the reflectance would turn negative at
/// another angle, as it would for dark metals with an edge darker still: there
/// (1 - mu)^5 / f82_dip is at least 4, and 1 / f82_dip at least its peak.
#[inline]
#[must_use]
pub fn f82_depth(f0: Vec3, tint: Vec3) -> Vec3 {
    let peak = 1.0 / f82_dip(F82_COS);
    let wanted = schlick(f0, F82_COS) * (Vec3::ONE - tint) * peak;
    let most = f0 * peak + (Vec3::ONE - f0) * 4.0;
    wanted.min(most).max(Vec3::ZERO)
}

/// Rec. 709 luminance: weighs colours when a lobe is chosen.
#[inline]
#[must_use]
pub fn luminance(c: Vec3) -> f32 {
    0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z
}
