//! Sine and cosine.

/// 2/pi.
const TWO_OVER_PI: f64 = core::f64::consts::FRAC_2_PI;
/// The top 33 bits of pi/2: `n * PI_2_HIGH` is exact for `|n| < 2^20`.
const PI_2_HIGH: f64 = 1.5707963267341256;
/// pi/2 - `PI_2_HIGH`.
const PI_2_LOW: f64 = 6.077100506506192e-11;
/// 1.5 * 2^52: adding it rounds to the nearest integer, which then stands in
/// the low bits in two's complement.
const ROUND_SHIFT: f64 = 6755399441055744.0;
/// Above this the argument's own spacing exceeds a full turn; the functions
/// then answer as for 0 rather than with noise.
const ARGUMENT_LIMIT: f32 = 1073741824.0;

// Near-minimax over [-pi/4, pi/4] (Chebyshev fit of the quotient, so that the
// relative error is small): sin r = r + r^3 S(r^2), cos r = 1 - r^2/2 + r^4 C(r^2).
// Four terms in f64 leave 3e-11, three in f32 2e-8.
const SIN: [f64; 4] = [
    -0.16666666663853044,
    0.008333331873837089,
    -0.00019840086263755443,
    2.7249864655139585e-06,
];
const COS: [f64; 4] = [
    0.04166666666431933,
    -0.0013888887671288108,
    2.480059998353171e-05,
    -2.7300908167996537e-07,
];
const SIN_SHORT: [f32; 3] = [
    -0.16666664661114838,
    0.008332748037517147,
    -0.00019587840521305324,
];
const COS_SHORT: [f32; 3] = [
    0.04166666465830042,
    -0.0013888302802309161,
    2.454789161981386e-05,
];

/// Sine and cosine of `x` radians, `|x| <= pi/4` (not checked). Cheaper than
/// [`sin_cos`]: no reduction, all in f32, within 1.5 ulp.
#[inline]
#[must_use]
pub fn sin_cos_quarter(x: f32) -> (f32, f32) {
    let s = x * x;
    let sin = x + x * s * (SIN_SHORT[0] + s * (SIN_SHORT[1] + s * SIN_SHORT[2]));
    let cos = (1.0 - 0.5 * s) + s * s * (COS_SHORT[0] + s * (COS_SHORT[1] + s * COS_SHORT[2]));
    (sin, cos)
}

/// An angle of `quarters` quarter turns (1 is 90 degrees), below 2^50, as what
/// [`sin_cos_reduced`] takes: radians within pi/4, and the quadrant. In f64 and
/// exact but for the last step, so that thousands of turns keep their digits.
#[inline]
#[must_use]
pub fn reduce_quarters(quarters: f64) -> (f32, u32) {
    let shifted = quarters + ROUND_SHIFT;
    let rest = (quarters - (shifted - ROUND_SHIFT)) as f32;
    (
        rest * core::f32::consts::FRAC_PI_2,
        shifted.to_bits() as u32,
    )
}

/// Sine and cosine of what [`reduce_quarters`] left: as [`sin_cos_quarter`], then
/// the quadrant by bits, so that loops of it become vector code.
#[inline]
#[must_use]
pub fn sin_cos_reduced(angle: f32, quadrant: u32) -> (f32, f32) {
    let (sin, cos) = sin_cos_quarter(angle);
    let (sin, cos) = (sin.to_bits(), cos.to_bits());
    // All ones where sine and cosine change places.
    let swapped = (sin ^ cos) & 0_u32.wrapping_sub(quadrant & 1);
    let sin_sign = (quadrant & 2) << 30;
    let cos_sign = (quadrant.wrapping_add(1) & 2) << 30;
    (
        f32::from_bits(sin ^ swapped ^ sin_sign),
        f32::from_bits(cos ^ swapped ^ cos_sign),
    )
}

/// Sine and cosine of `x` radians. `(0, 1)` beyond `2^30`, NaN for NaN and
/// infinities.
///
/// Reduction by multiples of pi/2 in two parts (Cody and Waite 1980), in f64.
#[inline]
#[must_use]
pub fn sin_cos(x: f32) -> (f32, f32) {
    let wide = f64::from(x);
    // Times zero keeps NaN and makes NaN of an infinity.
    let wide = if x.abs() < ARGUMENT_LIMIT {
        wide
    } else {
        wide * 0.0
    };
    let shifted = wide * TWO_OVER_PI + ROUND_SHIFT;
    let quadrant = shifted.to_bits() as u32;
    let turns = shifted - ROUND_SHIFT;
    let r = (wide - turns * PI_2_HIGH) - turns * PI_2_LOW;
    let r2 = r * r;
    let r4 = r2 * r2;
    let sin = r + r * r2 * ((SIN[0] + r2 * SIN[1]) + r4 * (SIN[2] + r2 * SIN[3]));
    let cos = (1.0 - 0.5 * r2) + r4 * ((COS[0] + r2 * COS[1]) + r4 * (COS[2] + r2 * COS[3]));
    let (s, c) = (sin as f32, cos as f32);
    let swap = quadrant & 1 == 1;
    let sin = if swap { c } else { s };
    let cos = if swap { s } else { c };
    let sin_sign = (quadrant & 2) << 30;
    let cos_sign = (quadrant.wrapping_add(1) & 2) << 30;
    (
        f32::from_bits(sin.to_bits() ^ sin_sign),
        f32::from_bits(cos.to_bits() ^ cos_sign),
    )
}

/// Sine and cosine of a number of full turns, `|turns| < 2^40`, within 3e-11.
///
/// The reduction is exact, so a wheel that has turned for a day is as true as a
/// new one. For transforms that must be undone: in f32 the matrix of a rotation
/// and its transpose are no inverses to the last digits.
#[inline]
#[must_use]
pub fn sin_cos_turns(turns: f64) -> (f64, f64) {
    let quarters = turns * 4.0;
    let shifted = quarters + ROUND_SHIFT;
    let quadrant = shifted.to_bits() as u32;
    let r = (quarters - (shifted - ROUND_SHIFT)) * core::f64::consts::FRAC_PI_2;
    let r2 = r * r;
    let r4 = r2 * r2;
    let s = r + r * r2 * ((SIN[0] + r2 * SIN[1]) + r4 * (SIN[2] + r2 * SIN[3]));
    let c = (1.0 - 0.5 * r2) + r4 * ((COS[0] + r2 * COS[1]) + r4 * (COS[2] + r2 * COS[3]));
    // Onto the circle again, by one step of Newton's for the length: a rotation must
    // not stretch, or the way back from a far point would miss the way there.
    let length = 1.5 - 0.5 * (s * s + c * c);
    let (s, c) = (s * length, c * length);
    let swap = quadrant & 1 == 1;
    let sin = if swap { c } else { s };
    let cos = if swap { s } else { c };
    (
        if quadrant & 2 == 2 { -sin } else { sin },
        if quadrant.wrapping_add(1) & 2 == 2 {
            -cos
        } else {
            cos
        },
    )
}

/// Sine of `x` radians; see [`sin_cos`].
#[inline]
#[must_use]
pub fn sin(x: f32) -> f32 {
    sin_cos(x).0
}

/// Cosine of `x` radians; see [`sin_cos`].
#[inline]
#[must_use]
pub fn cos(x: f32) -> f32 {
    sin_cos(x).1
}
