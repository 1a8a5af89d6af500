//! Student's distribution.

/// Student's quantile for a normal one (Wallace 1959): a little large for few degrees of
/// freedom, exact for many.
#[must_use]
pub(crate) fn student(z: f64, degrees: f64) -> f64 {
    if degrees > 1e6 {
        return z;
    }
    let scaled = z * (8.0 * degrees + 3.0) / (8.0 * degrees + 1.0);
    (degrees * libm::expm1(scaled * scaled / degrees)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    // Tables of Student's t at 0.27 % on two sides (3 deviations).
    #[test]
    fn students_distribution() {
        for (degrees, exact) in [(5.0, 5.507), (10.0, 3.957), (30.0, 3.270), (1e7, 3.0)] {
            let found = student(3.0, degrees);
            assert!(
                found >= exact - 2e-3 && found < 1.03 * exact,
                "{degrees}: {found}"
            );
        }
    }
}
