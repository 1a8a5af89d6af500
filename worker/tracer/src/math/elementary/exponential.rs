//! Exponential, logarithm and power: table of powers or reciprocals, then a
//! short polynomial (Tang 1989, 1990), in f64 throughout.

/// 1.5 * 2^52: see `trig`.
const ROUND_SHIFT: f64 = 6755399441055744.0;
const LN_2: f64 = core::f64::consts::LN_2;
/// Steps per octave of `EXP2_TABLE`.
const EXP2_STEPS: f64 = 32.0;
const STEPS_OVER_LN_2: f64 = EXP2_STEPS * core::f64::consts::LOG2_E;
/// Beyond this an f32 result is 0 or infinite in any case; inside, the f64
/// exponent arithmetic cannot overflow.
const EXP2_LIMIT: f64 = 200.0 * EXP2_STEPS;

/// bits(2^(i/32)) - i * 2^47: adding `n * 2^47` for any n with n % 32 == i
/// gives 2^(n/32).
const EXP2_TABLE: [u64; 32] = [
    0x3ff0000000000000,
    0x3fefd9b0d3158574,
    0x3fefb5586cf9890f,
    0x3fef9301d0125b51,
    0x3fef72b83c7d517b,
    0x3fef54873168b9aa,
    0x3fef387a6e756238,
    0x3fef1e9df51fdee1,
    0x3fef06fe0a31b715,
    0x3feef1a7373aa9cb,
    0x3feedea64c123422,
    0x3feece086061892d,
    0x3feebfdad5362a27,
    0x3feeb42b569d4f82,
    0x3feeab07dd485429,
    0x3feea47eb03a5585,
    0x3feea09e667f3bcd,
    0x3fee9f75e8ec5f74,
    0x3feea11473eb0187,
    0x3feea589994cce13,
    0x3feeace5422aa0db,
    0x3feeb737b0cdc5e5,
    0x3feec49182a3f090,
    0x3feed503b23e255d,
    0x3feee89f995ad3ad,
    0x3feeff76f2fb5e47,
    0x3fef199bdd85529c,
    0x3fef3720dcef9069,
    0x3fef5818dcfba487,
    0x3fef7c97337b9b5f,
    0x3fefa4afa2a490da,
    0x3fefd0765b6e4540,
];
/// (2^r - 1)/r over |r| <= 1/64 (Chebyshev fit), relative error 3e-12.
const EXP2_POLY: [f64; 4] = [
    0.693147180550007,
    0.24022650695795258,
    0.05550443425704785,
    0.009618166721494435,
];

/// Bits of 0.69921875: mantissas are taken from [0.699, 1.398), so that 1 lies
/// inside one cell and log2 is accurate on both sides of it.
const LOG2_ORIGIN: u64 = 0x3fe6600000000000;
/// (1/c, log2 c) with c the middle of each 1/16 of that range; the cell of 1
/// has c = 1.
const LOG2_TABLE: [(f64, f64); 16] = [
    (1.3989071038251366, -0.4843001617159575),
    (1.3403141361256545, -0.4225711719642514),
    (1.2864321608040201, -0.3633753794563512),
    (1.2367149758454106, -0.3065130425006747),
    (1.1906976744186046, -0.2518071504105397),
    (1.147982062780269, -0.19910010007969525),
    (1.1082251082251082, -0.14825095858394247),
    (1.0711297071129706, -0.09913319201925132),
    (1.0364372469635628, -0.05163276841532236),
    (1.0, 0.0),
    (0.9481481481481482, 0.07681559705083084),
    (0.8951048951048951, 0.1598713367783894),
    (0.847682119205298, 0.2384047393250789),
    (0.8050314465408805, 0.3128829552843553),
    (0.7664670658682635, 0.38370429247405213),
    (0.7314285714285714, 0.4512111118323288),
];
/// log2(1 + r)/r over |r| <= 0.0316 (Chebyshev fit), relative error 4e-12.
const LOG2_POLY: [f64; 6] = [
    1.4426950408953838,
    -0.7213475204500996,
    0.4808982312359775,
    -0.3606736589578599,
    0.2888479818921158,
    -0.2407195322340592,
];
/// Below this |x| the polynomial of `log1p` takes x itself: 1 + x would lose
/// its low bits. It lies inside the cell of 1.
const LOG1P_DIRECT: f64 = 0.0190;

/// (s, p) with 2^(steps/32) = s (1 + p); NaN gives NaN.
#[inline]
fn exp2_parts(steps: f64) -> (f64, f64) {
    let steps = steps.clamp(-EXP2_LIMIT, EXP2_LIMIT);
    let shifted = steps + ROUND_SHIFT;
    let n = shifted.to_bits();
    let r = (steps - (shifted - ROUND_SHIFT)) * (1.0 / EXP2_STEPS);
    let s = f64::from_bits(EXP2_TABLE[(n & 31) as usize].wrapping_add(n << 47));
    let r2 = r * r;
    let p = r * ((EXP2_POLY[0] + r * EXP2_POLY[1]) + r2 * (EXP2_POLY[2] + r * EXP2_POLY[3]));
    (s, p)
}

/// log2(1 + r), |r| <= 0.0316.
#[inline]
fn log2_near_one(r: f64) -> f64 {
    let r2 = r * r;
    let low = LOG2_POLY[0] + r * LOG2_POLY[1];
    let middle = LOG2_POLY[2] + r * LOG2_POLY[3];
    let high = LOG2_POLY[4] + r * LOG2_POLY[5];
    r * (low + r2 * (middle + r2 * high))
}

/// log2 of a positive, normal, finite f64.
#[inline]
fn log2_wide(x: f64) -> f64 {
    let bits = x.to_bits();
    let offset = bits.wrapping_sub(LOG2_ORIGIN);
    let (inv_c, log2_c) = LOG2_TABLE[((offset >> 48) & 15) as usize];
    let exponent = (offset as i64) >> 52;
    let z = f64::from_bits(bits.wrapping_sub(offset & (0xfff << 52)));
    (exponent as f64 + log2_c) + log2_near_one(z * inv_c - 1.0)
}

/// The logarithm of what is not positive and finite: -inf for 0, inf for inf,
/// NaN otherwise.
#[cold]
fn log_of_special(x: f64) -> f64 {
    if x == 0.0 {
        f64::NEG_INFINITY
    } else if x > 0.0 {
        f64::INFINITY
    } else {
        f64::NAN
    }
}

/// e^x. 0 below about -104, infinite above 88.72.
#[inline]
#[must_use]
pub fn exp(x: f32) -> f32 {
    let (s, p) = exp2_parts(f64::from(x) * STEPS_OVER_LN_2);
    (s + s * p) as f32
}

/// e^x - 1 without cancellation near 0.
#[inline]
#[must_use]
pub fn expm1(x: f32) -> f32 {
    let (s, p) = exp2_parts(f64::from(x) * STEPS_OVER_LN_2);
    ((s - 1.0) + s * p) as f32
}

/// Natural logarithm. -inf at 0, NaN below.
#[inline]
#[must_use]
pub fn ln(x: f32) -> f32 {
    let wide = f64::from(x);
    if x > 0.0 && x < f32::INFINITY {
        (log2_wide(wide) * LN_2) as f32
    } else {
        log_of_special(wide) as f32
    }
}

/// ln(1 + x) without cancellation near 0. -inf at -1, NaN below.
#[inline]
#[must_use]
pub fn log1p(x: f32) -> f32 {
    let wide = f64::from(x);
    if wide.abs() < LOG1P_DIRECT {
        return (log2_near_one(wide) * LN_2) as f32;
    }
    let sum = 1.0 + wide;
    if sum > 0.0 && sum < f64::INFINITY {
        (log2_wide(sum) * LN_2) as f32
    } else {
        log_of_special(sum) as f32
    }
}

/// x^y for `x >= 0`; NaN for negative x. x^0 = 1 and 1^y = 1 also for NaN, as
/// in IEEE 754.
#[inline]
#[must_use]
pub fn powf(x: f32, y: f32) -> f32 {
    if y == 0.0 || x == 1.0 {
        return 1.0;
    }
    let wide = f64::from(x);
    let log2 = if x > 0.0 && x < f32::INFINITY {
        log2_wide(wide)
    } else {
        log_of_special(wide)
    };
    let (s, p) = exp2_parts(f64::from(y) * log2 * EXP2_STEPS);
    (s + s * p) as f32
}
