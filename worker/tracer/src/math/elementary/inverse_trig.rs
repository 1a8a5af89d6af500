//! Inverse trigonometry, all from one arctangent in f64.

use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

const TAN_PI_8: f64 = 0.41421356237309503;
/// atan(t)/t in s = t^2 over |t| <= tan(pi/8) (Chebyshev fit), error 2.2e-11.
const ATAN_POLY: [f64; 7] = [
    0.999999999978393,
    -0.3333333209732565,
    0.19999883834670074,
    -0.1428158816410649,
    0.11040481662468073,
    -0.08456149941251835,
    0.04707257411522469,
];
/// Stands in for infinity, so that the quotient of two infinities is 1.
const HUGE: f64 = 1e300;

/// |v|, with [`HUGE`] for infinity; NaN stays.
#[inline]
fn finite_magnitude(v: f64) -> f64 {
    let v = v.abs();
    if v > HUGE { HUGE } else { v }
}

/// The angle of (x, y) in f64, good to about 3e-11.
#[inline]
fn atan2_wide(y: f64, x: f64) -> f64 {
    let (ay, ax) = (finite_magnitude(y), finite_magnitude(x));
    let steep = ay > ax;
    let (small, large) = if steep { (ax, ay) } else { (ay, ax) };
    // Octant to half-octant: atan(t) = pi/4 + atan((t - 1)/(t + 1)).
    let far = small > TAN_PI_8 * large;
    let numerator = if far { small - large } else { small };
    let denominator = if far { small + large } else { large };
    let t = if denominator == 0.0 {
        0.0
    } else {
        numerator / denominator
    };
    let s = t * t;
    let s2 = s * s;
    let low = (ATAN_POLY[0] + s * ATAN_POLY[1]) + s2 * (ATAN_POLY[2] + s * ATAN_POLY[3]);
    let high = (ATAN_POLY[4] + s * ATAN_POLY[5]) + s2 * ATAN_POLY[6];
    let angle = t * (low + s2 * s2 * high);
    let angle = if far { FRAC_PI_4 + angle } else { angle };
    let angle = if steep { FRAC_PI_2 - angle } else { angle };
    let angle = if x.is_sign_negative() {
        PI - angle
    } else {
        angle
    };
    angle.copysign(y)
}

/// The angle in radians of the point (x, y), in [-pi, pi]; 0 or +-pi at the
/// origin by the sign of x, as in IEEE 754.
#[inline]
#[must_use]
pub fn atan2(y: f32, x: f32) -> f32 {
    if y.is_nan() || x.is_nan() {
        return f32::NAN;
    }
    atan2_wide(f64::from(y), f64::from(x)) as f32
}

/// Arc cosine in radians, in [0, pi]. Arguments outside [-1, 1] are taken as
/// the nearer end: unit vectors round that far.
#[inline]
#[must_use]
pub fn acos(x: f32) -> f32 {
    if x.is_nan() {
        return x;
    }
    let (x, opposite) = unit_leg(x);
    atan2_wide(opposite, x) as f32
}

/// Arc sine in radians, in [-pi/2, pi/2]; arguments clamp as in [`acos`].
#[inline]
#[must_use]
pub fn asin(x: f32) -> f32 {
    if x.is_nan() {
        return x;
    }
    let (x, opposite) = unit_leg(x);
    atan2_wide(x, opposite) as f32
}

/// x clamped to [-1, 1] and sqrt(1 - x^2); the product of the two factors is
/// exact in f64, so nothing cancels.
#[inline]
fn unit_leg(x: f32) -> (f64, f64) {
    let x = f64::from(x).clamp(-1.0, 1.0);
    (x, ((1.0 - x) * (1.0 + x)).sqrt())
}
