//! Warps from the unit square to the shapes that are sampled, each with its
//! density. Inputs are in [0, 1), multiples of 2^-24 or finer.

use core::f32::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, PI};

use glam::{Vec2, Vec3};

use super::elementary::sin_cos_quarter;

/// Half the spacing of a random number, doubled for [-1, 1]: puts samples in
/// the middle of their cells, so that neither the rim nor the centre is hit
/// exactly.
const CELL_CENTRE: f32 = 1.0 / 16_777_216.0;

/// A uniform point of the unit disc (Shirley and Chiu 1997), and 1 - r^2.
#[inline]
fn concentric_disc(u: [f32; 2]) -> (Vec2, f32) {
    let a = 2.0 * u[0] - 1.0 + CELL_CENTRE;
    let b = 2.0 * u[1] - 1.0 + CELL_CENTRE;
    let wide = a.abs() > b.abs();
    let (r, other) = if wide { (a, b) } else { (b, a) };
    // Only inputs finer than 2^-24 can meet in the centre.
    let angle = if r == 0.0 {
        0.0
    } else {
        FRAC_PI_4 * (other / r)
    };
    let (sin, cos) = sin_cos_quarter(angle);
    // The angle counts from the nearer axis.
    let point = if wide {
        Vec2::new(r * cos, r * sin)
    } else {
        Vec2::new(r * sin, r * cos)
    };
    (point, (1.0 - r) * (1.0 + r))
}

/// A point uniform on the unit disc.
#[inline]
#[must_use]
pub fn uniform_disc(u: [f32; 2]) -> Vec2 {
    concentric_disc(u).0
}

/// A direction with density cos/pi about +z; its z is above 0.
#[inline]
#[must_use]
pub fn cosine_hemisphere(u: [f32; 2]) -> Vec3 {
    let (disc, rest) = concentric_disc(u);
    Vec3::new(disc.x, disc.y, rest.sqrt())
}

/// The density of [`cosine_hemisphere`] per steradian.
#[inline]
#[must_use]
pub fn cosine_hemisphere_pdf(cos_theta: f32) -> f32 {
    if cos_theta > 0.0 {
        cos_theta * FRAC_1_PI
    } else {
        0.0
    }
}

/// 1 - cos of an angle from sin^2 of it, without cancellation; `sin2` in [0, 1],
/// the angle at most pi/2.
#[inline]
#[must_use]
pub fn one_minus_cos(sin2: f32) -> f32 {
    sin2 / (1.0 + (1.0 - sin2).max(0.0).sqrt())
}

/// A direction uniform in the cone about +z whose `1 - cos` of the half angle
/// is `one_minus_cos_max` (in (0, 2]; [`one_minus_cos`] gives it from the
/// apparent size). The cosine is never formed before the sine, so that a cone
/// of 0.05 degrees still has all its distinct directions.
#[inline]
#[must_use]
pub fn uniform_cone(u: [f32; 2], one_minus_cos_max: f32) -> Vec3 {
    let q = u[0] * one_minus_cos_max;
    let sin_theta = (q * (2.0 - q)).sqrt();
    let (sin_phi, cos_phi) = azimuth(u[1]);
    Vec3::new(sin_theta * cos_phi, sin_theta * sin_phi, 1.0 - q)
}

/// The density per steradian of [`uniform_cone`] inside its cone.
#[inline]
#[must_use]
pub fn uniform_cone_pdf(one_minus_cos_max: f32) -> f32 {
    1.0 / (2.0 * PI * one_minus_cos_max)
}

/// Barycentric weights (of the second and third vertex) of a point uniform on
/// a triangle; the first vertex has the rest. Heitz 2019, "A Low-Distortion Map
/// Between Triangle and Square": stratification survives. The density per area
/// is [`uniform_triangle_pdf`].
#[inline]
#[must_use]
pub fn uniform_triangle(u: [f32; 2]) -> Vec2 {
    let half = 0.5 * u[0].min(u[1]);
    Vec2::new(u[0] - half, u[1] - half)
}

/// The density of [`uniform_triangle`] per unit of area; 0 for a degenerate
/// triangle.
#[inline]
#[must_use]
pub fn uniform_triangle_pdf(area: f32) -> f32 {
    if area > 0.0 { 1.0 / area } else { 0.0 }
}

/// The azimuth of a uniform number, as (sin, cos).
#[inline]
#[must_use]
pub fn azimuth(u: f32) -> (f32, f32) {
    // Four quarter turns about their centres: the polynomial alone is enough.
    let turns = 4.0 * u;
    let quarter = turns as i32;
    let (s, c) = sin_cos_quarter((turns - quarter as f32) * FRAC_PI_2 - FRAC_PI_4);
    let swap = quarter & 1 == 1;
    let (s, c) = if swap { (c, -s) } else { (s, c) };
    let sign = ((quarter as u32) & 2) << 30;
    (
        f32::from_bits(s.to_bits() ^ sign),
        f32::from_bits(c.to_bits() ^ sign),
    )
}
