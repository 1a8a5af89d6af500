//! Is a picture right on average?

use serde::Serialize;

/// Chance that any unbiased variant of a report is called biased.
pub const FALSE_ALARM_RATE: f64 = 0.01;

/// What the test of one variant says.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bias {
    /// Mean over pixels and channels of picture - reference.
    pub mean_difference: f64,
    /// Half of the interval in which it lies for an unbiased variant, at the level that
    /// makes [`FALSE_ALARM_RATE`] hold over all tests together (Sidak 1967).
    pub interval: f64,
    /// Deviations from zero.
    pub z: f64,
    /// Whether it lies in the interval.
    pub passed: bool,
}

/// Test a mean difference of standard deviation `sigma` as one of `tests` tests. Takes
/// the mean over many thousand pixels for normal.
#[must_use]
pub fn test_bias(mean_difference: f64, sigma: f64, tests: usize) -> Bias {
    // 1 - (1 - rate)^(1/n), without loss of digits.
    let level = -libm::expm1(libm::log1p(-FALSE_ALARM_RATE) / tests.max(1) as f64);
    let interval = deviations(level) * sigma;
    Bias {
        mean_difference,
        interval,
        z: if mean_difference == 0.0 {
            0.0
        } else {
            mean_difference / sigma
        },
        passed: mean_difference.abs() <= interval,
    }
}

/// The number of deviations that a normal variable exceeds, on either side, with
/// probability `level`; by bisection of erfc.
fn deviations(level: f64) -> f64 {
    let (mut low, mut high) = (0.0, 40.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if libm::erfc(middle * std::f64::consts::FRAC_1_SQRT_2) > level {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_normal_distribution() {
        for (level, expected) in [(0.05, 1.959_964), (0.01, 2.575_829), (1e-6, 4.891_638)] {
            assert!((deviations(level) - expected).abs() < 1e-5, "{level}");
        }
    }

    #[test]
    fn more_tests_allow_each_more() {
        let one = test_bias(2.7, 1.0, 1);
        let many = test_bias(2.7, 1.0, 20);
        assert!(!one.passed && many.passed, "{one:?} {many:?}");
        assert!((one.interval - 2.575_829).abs() < 1e-5);
        assert!(test_bias(0.0, 0.0, 3).passed);
        assert!(!test_bias(1e-9, 0.0, 3).passed);
    }
}
