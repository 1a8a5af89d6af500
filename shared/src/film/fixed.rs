//! Rounding of one sample to fixed point.

use super::BadCause;

/// Binary digits after the point.
pub const FIXED_SHIFT: u32 = 24;
/// 1.0 in fixed point.
pub const FIXED_ONE: f64 = (1u64 << FIXED_SHIFT) as f64;
/// Largest radiance one sample may carry: 2^26, so that 2^12 samples of a run
/// stay below 2^62. A sun of 0.27 degrees reaches 10^6.
pub const SAMPLE_MAX: f32 = 67_108_864.0;
/// [`SAMPLE_MAX`] in fixed point.
pub(super) const FIXED_SAMPLE_MAX: i64 = 1 << (26 + FIXED_SHIFT);

// Adding 1.5 * 2^52 to a double of at most 2^51 leaves the rounded integer
// (ties to even) in its low mantissa bits: one addition instead of a call, and
// the same bits on every CPU.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// `value` to the nearest multiple of 2^-24, ties to even. `value` must be
/// finite with a magnitude of at most [`SAMPLE_MAX`]; anything else is clamped
/// (NaN becomes 0), so that the function is total.
#[inline]
#[must_use]
pub fn fixed_from_f32(value: f32) -> i64 {
    let clamped = if value > -SAMPLE_MAX {
        value
    } else if value < 0.0 {
        -SAMPLE_MAX
    } else {
        0.0
    };
    let clamped = if clamped < SAMPLE_MAX {
        clamped
    } else {
        SAMPLE_MAX
    };
    let bits = (f64::from(clamped) * FIXED_ONE + ROUND).to_bits();
    bits.wrapping_sub(ROUND.to_bits()) as i64
}

/// One sample's radiance in fixed point, or why it is no radiance.
///
/// # Errors
/// NaN, infinity, a negative channel, or a channel above [`SAMPLE_MAX`].
#[inline]
pub fn rgb_to_fixed(rgb: [f32; 3]) -> Result<[i64; 3], BadCause> {
    // One comparison each decides the common case; NaN fails it too.
    if rgb.iter().all(|&v| (0.0..=SAMPLE_MAX).contains(&v)) {
        return Ok(rgb.map(fixed_from_f32));
    }
    Err(BadCause::of(rgb))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_to_nearest_even() {
        let ulp = 1.0 / 16_777_216.0_f32;
        assert_eq!(fixed_from_f32(1.0), 1 << 24);
        assert_eq!(fixed_from_f32(-1.0), -(1 << 24));
        assert_eq!(fixed_from_f32(ulp * 0.5), 0);
        assert_eq!(fixed_from_f32(ulp * 1.5), 2);
        assert_eq!(fixed_from_f32(ulp * 0.75), 1);
        assert_eq!(fixed_from_f32(SAMPLE_MAX), FIXED_SAMPLE_MAX);
        assert_eq!(fixed_from_f32(f32::INFINITY), FIXED_SAMPLE_MAX);
        assert_eq!(fixed_from_f32(f32::NEG_INFINITY), -FIXED_SAMPLE_MAX);
        assert_eq!(fixed_from_f32(f32::NAN), 0);
    }

    // accuracy: ten million times 0.1 in running f32 is 8.8 % too large.
    #[test]
    fn ten_million_tenths_make_a_million() {
        let sum: i64 = (0..10_000_000).map(|_| fixed_from_f32(0.1)).sum();
        let relative = (sum as f64 / FIXED_ONE / 1e6 - 1.0).abs();
        assert!(relative < 5e-7, "{relative}");
    }

    #[test]
    fn a_firefly_does_not_swallow_dark_samples() {
        let bright = fixed_from_f32(1e6);
        let dark = fixed_from_f32(0.001);
        assert_eq!(bright + dark - bright, dark);
        assert!(dark > 0);
    }

    #[test]
    fn bad_values_are_named() {
        assert_eq!(
            rgb_to_fixed([0.0, f32::NAN, 0.0]),
            Err(BadCause::NotANumber)
        );
        assert_eq!(
            rgb_to_fixed([f32::INFINITY, 0.0, 0.0]),
            Err(BadCause::Infinite)
        );
        assert_eq!(rgb_to_fixed([0.0, 0.0, -1e-9]), Err(BadCause::Negative));
        assert_eq!(rgb_to_fixed([0.0, 1e8, 0.0]), Err(BadCause::Overflow));
        assert_eq!(rgb_to_fixed([0.0, -0.0, 1.0]), Ok([0, 0, 1 << 24]));
    }
}
