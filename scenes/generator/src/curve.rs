//! Curves through tabled values, and the small scalar helpers around them.

/// Monotone cubic through the knots (t, value): no overshoot between them.
///
/// `knots` must ascend in t; outside, the end values hold. Slopes after
/// Fritsch & Butland, "A method for constructing local monotone piecewise
/// cubic interpolants" (1984): the weighted harmonic mean of the neighbouring
/// secants, zero at an extremum.
#[must_use]
pub fn pchip(knots: &[(f64, f64)], t: f64) -> f64 {
    let last = knots.len().saturating_sub(1);
    let (Some(first), Some(end)) = (knots.first(), knots.last()) else {
        return 0.0;
    };
    if t <= first.0 || last == 0 {
        return first.1;
    }
    if t >= end.0 {
        return end.1;
    }
    let mut i = 0;
    while i + 2 < knots.len() && t > knots[i + 1].0 {
        i += 1;
    }
    let step = knots[i + 1].0 - knots[i].0;
    let x = (t - knots[i].0) / step;
    let (d0, d1) = (slope(knots, i), slope(knots, i + 1));
    let (x2, x3) = (x * x, x * x * x);
    (2.0 * x3 - 3.0 * x2 + 1.0) * knots[i].1
        + (x3 - 2.0 * x2 + x) * step * d0
        + (3.0 * x2 - 2.0 * x3) * knots[i + 1].1
        + (x3 - x2) * step * d1
}

/// Derivative of the interpolant at knot `i`.
fn slope(knots: &[(f64, f64)], i: usize) -> f64 {
    let secant = |k: usize| (knots[k + 1].1 - knots[k].1) / (knots[k + 1].0 - knots[k].0);
    if i == 0 {
        return secant(0);
    }
    if i + 1 == knots.len() {
        return secant(i - 1);
    }
    let (before, after) = (secant(i - 1), secant(i));
    if before * after <= 0.0 {
        return 0.0;
    }
    let (h0, h1) = (knots[i].0 - knots[i - 1].0, knots[i + 1].0 - knots[i].0);
    let (w0, w1) = (2.0 * h1 + h0, h1 + 2.0 * h0);
    (w0 + w1) / (w0 / before + w1 / after)
}

/// 0 below `from`, 1 above `to`, a cubic between (Perlin's smoothstep).
#[must_use]
pub fn smoothstep(from: f64, to: f64, value: f64) -> f64 {
    let x = ((value - from) / (to - from)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Value at `amount` of the way from `a` to `b`.
#[must_use]
pub fn mix(a: f64, b: f64, amount: f64) -> f64 {
    a + (b - a) * amount
}

/// Sign-keeping power, the building stone of superellipses.
#[must_use]
pub fn signed_pow(base: f64, exponent: f64) -> f64 {
    let size = libm::pow(base.abs(), exponent);
    if base < 0.0 { -size } else { size }
}
