//! Numbers for people.

/// Three digits: `1.23`, `12.3`, `123`, `1.23e-4`.
pub(super) fn short(value: f64) -> String {
    match value.abs() {
        a if !value.is_finite() || a == 0.0 => format!("{value}"),
        a if !(0.0995..99_950.0).contains(&a) => format!("{value:.2e}"),
        a if a >= 99.95 => format!("{value:.0}"),
        a if a >= 9.995 => format!("{value:.1}"),
        a if a >= 0.9995 => format!("{value:.2}"),
        _ => format!("{value:.3}"),
    }
}

/// The same, with a sign.
pub(super) fn signed(value: f64) -> String {
    let plus = if value > 0.0 { "+" } else { "" };
    format!("{plus}{}", short(value))
}

/// A number of samples with a decimal prefix: `1.23 M`.
pub(super) fn scaled(value: f64) -> String {
    match value {
        v if v >= 1e9 => format!("{:.2} G", v / 1e9),
        v if v >= 1e6 => format!("{:.2} M", v / 1e6),
        v if v >= 1e3 => format!("{:.1} k", v / 1e3),
        v => format!("{v:.0}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_digits() {
        let cases = [
            (0.0, "0"),
            (0.012_345, "1.23e-2"),
            (0.5, "0.500"),
            (1.0, "1.00"),
            (12.345, "12.3"),
            (123.45, "123"),
            (1e6, "1.00e6"),
        ];
        for (value, text) in cases {
            assert_eq!(short(value), text);
        }
        assert_eq!(
            (signed(2.0), signed(-2.0)),
            ("+2.00".into(), "-2.00".into())
        );
        assert_eq!(scaled(2_340_000.0), "2.34 M");
    }
}
