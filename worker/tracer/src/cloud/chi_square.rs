//! Pearson's test, for the tests of this folder.

/// Counts against the shares they should have (which add up to 1). Fails beyond
/// 4.5 sigma, once in 300,000, by Wilson and Hilferty 1931: (chi^2 / n)^(1/3) is
/// nearly normal with mean 1 - 2/(9n) and variance 2/(9n).
pub(super) fn assert_counts(what: &str, counts: &[u32], shares: &[f64]) {
    let total: f64 = counts.iter().map(|&c| f64::from(c)).sum();
    let (mut chi_square, mut cells) = (0.0, 0.0);
    for (&count, &share) in counts.iter().zip(shares) {
        let expected = share * total;
        if share <= 0.0 {
            assert_eq!(count, 0, "{what}: a cell that cannot be");
            continue;
        }
        assert!(expected >= 5.0, "{what}: cells too small to test");
        let off = f64::from(count) - expected;
        chi_square += off * off / expected;
        cells += 1.0;
    }
    let freedom = cells - 1.0;
    let spread = 2.0 / (9.0 * freedom);
    let sigma = (libm::cbrt(chi_square / freedom) - (1.0 - spread)) / spread.sqrt();
    assert!(
        sigma.abs() < 4.5,
        "{what}: chi^2 {chi_square} of {freedom} degrees of freedom, {sigma} sigma"
    );
}
