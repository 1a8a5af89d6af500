//! Is a picture right on average?
//!
//! The mean of picture - reference would be ruled by the few brightest pixels: one that
//! the sun's disc touches weighs as much as the rest of a sunset. So each pixel is
//! weighed by 1 / (reference + 0.1). A weight that knows the error of what it weighs
//! would be a bias itself; therefore one half of the reference gives the weights and the
//! other is compared with.

use crate::measure::FrameSums;
use crate::metrics::RELATIVE_EPSILON;
use crate::student::student;
use serde::{Deserialize, Serialize};

/// Chance that any unbiased variant of a report is called biased.
pub const FALSE_ALARM_RATE: f64 = 0.01;

/// A weighted mean difference with its scatter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Difference {
    /// Mean over pixels and channels of (x - r) / (r + 0.1).
    pub mean: f64,
    /// Variance of `mean` that comes from the picture.
    pub variance: f64,
    /// Sum of the squares of what each pixel adds to `variance`: tells how many pixels
    /// it comes from.
    pub fourth: f64,
}

/// The reference's side of the test.
#[derive(Clone, Debug)]
pub(super) struct Held {
    /// Weight of each pixel, over the number of pixels and channels.
    weights: Vec<f64>,
    /// What is compared with: sums over channels.
    sums: Vec<f64>,
    /// As in [`Difference`].
    pub(super) variance: f64,
    /// As in [`Difference`].
    pub(super) fourth: f64,
}

impl Held {
    /// Half A of a reference gives the weights, half B is compared with.
    pub(super) fn halves(reference: &FrameSums) -> Self {
        let (a, b) = (reference.half_mean(0), reference.half_mean(1));
        let mut held = Self::weighed(&a, &b);
        for ((w, a), b) in held.weights.iter().zip(&a).zip(&b) {
            // The variance of one half is half of that of the difference of both.
            let d = w * (sum(a) - sum(b));
            held.variance += 0.5 * d * d;
            held.fourth += 0.25 * d * d * d * d;
        }
        held
    }

    /// A picture without halves, taken for exact.
    pub(super) fn exact(rgb: &[[f32; 3]]) -> Self {
        let rgb: Vec<[f64; 3]> = rgb.iter().map(|rgb| rgb.map(f64::from)).collect();
        Self::weighed(&rgb, &rgb)
    }

    fn weighed(weights: &[[f64; 3]], compared: &[[f64; 3]]) -> Self {
        let values = 3.0 * weights.len().max(1) as f64;
        let epsilon = RELATIVE_EPSILON.sqrt();
        let weight = |rgb: &[f64; 3]| 1.0 / (values * (sum(rgb).max(0.0) / 3.0 + epsilon));
        Self {
            weights: weights.iter().map(weight).collect(),
            sums: compared.iter().map(sum).collect(),
            variance: 0.0,
            fourth: 0.0,
        }
    }

    /// The weighted mean difference of a picture.
    pub(super) fn difference(&self, picture: &FrameSums) -> Difference {
        let mut found = Difference::default();
        let (a, b) = (picture.half_mean(0), picture.half_mean(1));
        for ((w, r), (a, b)) in self.weights.iter().zip(&self.sums).zip(a.iter().zip(&b)) {
            let (a, b) = (sum(a), sum(b));
            found.mean += w * (0.5 * (a + b) - r);
            let d = w * 0.5 * (a - b);
            found.variance += d * d;
            found.fourth += d * d * d * d;
        }
        found
    }
}

fn sum(rgb: &[f64; 3]) -> f64 {
    rgb[0] + rgb[1] + rgb[2]
}

/// What the test of one variant says.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bias {
    /// The weighted mean difference.
    pub mean: f64,
    /// Half of the interval in which it lies for an unbiased variant, at the level that
    /// makes [`FALSE_ALARM_RATE`] hold over all tests together (Sidak 1967).
    pub interval: f64,
    /// Standard deviations from zero.
    pub t: f64,
    /// Pixels that the deviation effectively comes from: with few, the deviation is
    /// itself uncertain, and the interval wider (Student's t).
    pub effective_pixels: f64,
    /// Whether it lies in the interval.
    pub passed: bool,
}

/// Test a difference whose `variance` and `fourth` hold the reference's share too, as one
/// of `tests` tests.
#[must_use]
pub fn test_bias(difference: &Difference, tests: usize) -> Bias {
    // 1 - (1 - rate)^(1/n), without loss of digits.
    let level = -libm::expm1(libm::log1p(-FALSE_ALARM_RATE) / tests.max(1) as f64);
    let sigma = difference.variance.sqrt();
    // Satterthwaite (1946) with the squares for their expectations: one for a single
    // pixel, a third of the pixels for many equal ones, so rather too few.
    let degrees = if difference.fourth > 0.0 {
        (difference.variance * difference.variance / difference.fourth).max(1.0)
    } else {
        f64::INFINITY
    };
    let interval = student(deviations(level), degrees) * sigma;
    let mean = difference.mean;
    Bias {
        mean,
        interval,
        t: if mean == 0.0 { 0.0 } else { mean / sigma },
        effective_pixels: degrees,
        passed: mean.abs() <= interval,
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
    fn more_tests_and_fewer_pixels_allow_more() {
        let difference = Difference {
            mean: 2.7,
            variance: 1.0,
            fourth: 1e-9,
        };
        let one = test_bias(&difference, 1);
        assert!(!one.passed && test_bias(&difference, 20).passed, "{one:?}");
        assert!((one.interval - 2.575_829).abs() < 1e-5);
        let few = Difference {
            fourth: 0.2,
            ..difference
        };
        assert!(test_bias(&few, 1).passed);
        let none = Difference::default();
        assert!(test_bias(&none, 3).passed);
        assert!(!test_bias(&Difference { mean: 1e-9, ..none }, 3).passed);
    }
}
