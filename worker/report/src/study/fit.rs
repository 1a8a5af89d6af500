//! A line through points of error against time, both logarithmic.

use serde::Serialize;

/// `ln error = intercept + slope x ln seconds`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Fit {
    /// -1 for a mean squared error of independent samples; flatter means a bias, or rare
    /// bright samples that have not come yet.
    pub slope: f64,
    /// At one second.
    pub intercept: f64,
}

/// When an error is reached.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Reached {
    /// Seconds along the fitted line.
    pub seconds: f64,
    /// The error lies outside of what was measured.
    pub extrapolated: bool,
}

/// Steepest line that does not count as going down: whoever follows it waits for ever.
const SLOPE_LEAST: f64 = -0.05;

/// Least squares through (seconds, error); `None` with fewer than two usable points.
#[must_use]
pub fn fit(points: &[(f64, f64)]) -> Option<Fit> {
    let usable: Vec<(f64, f64)> = points
        .iter()
        .filter(|(x, y)| *x > 0.0 && *y > 0.0)
        .map(|&(x, y)| (libm::log(x), libm::log(y)))
        .collect();
    let n = usable.len() as f64;
    if usable.len() < 2 {
        return None;
    }
    let mean = |value: fn(&(f64, f64)) -> f64| usable.iter().map(value).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let spread: f64 = usable.iter().map(|p| (p.0 - x) * (p.0 - x)).sum();
    let both: f64 = usable.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    (spread > 0.0).then(|| Fit {
        slope: both / spread,
        intercept: y - both / spread * x,
    })
}

/// Seconds until `error` along the line of `points`; `None` when the line is flat or the
/// number is beyond any use.
#[must_use]
pub fn seconds_to(error: f64, points: &[(f64, f64)]) -> Option<Reached> {
    let line = fit(points).filter(|line| line.slope < SLOPE_LEAST)?;
    let seconds = libm::exp((libm::log(error) - line.intercept) / line.slope);
    let within = points.iter().any(|p| p.1 >= error) && points.iter().any(|p| p.1 <= error);
    (seconds.is_finite() && seconds > 0.0).then_some(Reached {
        seconds,
        extrapolated: !within,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_is_found_again() {
        let points: Vec<(f64, f64)> = [0.5, 1.0, 2.0, 8.0]
            .map(|x: f64| (x, 0.3 / x / x.sqrt()))
            .to_vec();
        let line = fit(&points).expect("line");
        assert!((line.slope + 1.5).abs() < 1e-12, "{line:?}");
        let reached = seconds_to(0.3 / 8.0, &points).expect("reached");
        assert!((reached.seconds - 4.0).abs() < 1e-9 && !reached.extrapolated);
        assert!(seconds_to(1e-6, &points).expect("reached").extrapolated);
    }

    #[test]
    fn flat_or_lonely_points_reach_nothing() {
        assert_eq!(fit(&[(1.0, 0.1)]), None);
        assert_eq!(fit(&[(1.0, 0.1), (1.0, 0.2)]), None);
        assert_eq!(fit(&[(1.0, 0.0), (2.0, 0.0)]), None);
        assert_eq!(seconds_to(0.01, &[(1.0, 0.1), (4.0, 0.1)]), None);
    }
}
