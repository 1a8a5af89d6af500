//! Accuracy of `math::elementary` against libm in f64, and a hash of its bits.

use shearwater_tracer::math::elementary as own;
use shearwater_tracer::math::hash::mix64;

/// Random arguments per function; the worst error settles well before.
const SAMPLES: u64 = 1_000_000;

/// The spacing of f32 around `exact`, subnormals included.
fn ulp(exact: f64) -> f64 {
    let magnitude = exact.abs().max(f64::from(f32::MIN_POSITIVE));
    let exponent = ((magnitude.to_bits() >> 52) as i64) - 1023;
    f64::from_bits(((exponent - 23 + 1023) as u64) << 52)
}

fn error_ulp(got: f32, exact: f64) -> f64 {
    if f64::from(exact as f32) == f64::from(got) {
        // Covers overflow to infinity, which has no spacing.
        return if exact.abs() > f64::from(f32::MAX) {
            0.0
        } else {
            (f64::from(got) - exact).abs() / ulp(exact)
        };
    }
    (f64::from(got) - exact).abs() / ulp(exact)
}

fn random_bits(seed: u64, i: u64) -> u32 {
    (mix64(mix64(seed) ^ i.wrapping_mul(0x9e37_79b9_7f4a_7c15)) >> 32) as u32
}

/// Uniform in [low, high).
fn ranged(seed: u64, i: u64, low: f64, high: f64) -> f32 {
    (low + (high - low) * f64::from(random_bits(seed, i)) / 4294967296.0) as f32
}

/// The largest error over random arguments made by `argument`.
fn worst(
    argument: impl Fn(u64) -> f32,
    f: impl Fn(f32) -> f32,
    exact: impl Fn(f64) -> f64,
) -> (f64, f32) {
    let mut worst = (0.0, 0.0);
    for i in 0..SAMPLES {
        let x = argument(i);
        let e = error_ulp(f(x), exact(f64::from(x)));
        assert!(
            !e.is_nan(),
            "NaN at {x:e}: {} for {}",
            f(x),
            exact(f64::from(x))
        );
        if e > worst.0 {
            worst = (e, x);
        }
    }
    worst
}

fn check(name: &str, bound: f64, found: (f64, f32)) {
    println!("{name}: {:.4} ulp at {:e}", found.0, found.1);
    assert!(found.0 <= bound, "{name}: {} ulp at {:e}", found.0, found.1);
}

/// Any finite f32 of the given sign rule, every exponent equally likely.
fn any_finite(seed: u64, i: u64) -> f32 {
    let v = f32::from_bits(random_bits(seed, i));
    if v.is_finite() { v } else { 0.25 }
}

#[test]
fn sine_and_cosine() {
    for limit in [0.8, 7.0, 1000.0] {
        check(
            "sin",
            0.51,
            worst(|i| ranged(1, i, -limit, limit), own::sin, libm::sin),
        );
        check(
            "cos",
            0.51,
            worst(|i| ranged(2, i, -limit, limit), own::cos, libm::cos),
        );
    }
    check(
        "sin small",
        0.51,
        worst(|i| any_finite(3, i) % 1.0, own::sin, libm::sin),
    );
    for (limit, bound) in [(1.0e6, 6.1e-8), (1.0e9, 3e-7)] {
        for i in 0..SAMPLES / 2 {
            let x = ranged(4, i, -limit, limit);
            let (s, c) = own::sin_cos(x);
            assert!(
                (f64::from(s) - libm::sin(f64::from(x))).abs() <= bound,
                "sin {x}"
            );
            assert!(
                (f64::from(c) - libm::cos(f64::from(x))).abs() <= bound,
                "cos {x}"
            );
        }
    }
    let quarter = |i| ranged(27, i, -0.785, 0.785);
    check(
        "sin quarter",
        1.5,
        worst(quarter, |x| own::sin_cos_quarter(x).0, libm::sin),
    );
    check(
        "cos quarter",
        1.5,
        worst(quarter, |x| own::sin_cos_quarter(x).1, libm::cos),
    );
    assert_eq!(own::sin_cos(f32::MAX), (0.0, 1.0));
    assert!(own::sin(f32::INFINITY).is_nan() && own::cos(f32::NAN).is_nan());
}

#[test]
fn turns_keep_their_accuracy_for_ever() {
    for i in 0..SAMPLES {
        let part = f64::from(ranged(8, i, -0.5, 0.5));
        // Exact sums: 2^-24 steps below 2^28 whole turns.
        let whole = f64::from(random_bits(9, i) as i32 >> 4);
        let part = (part * 16_777_216.0).round() / 16_777_216.0;
        let (s, c) = own::sin_cos_turns(whole + part);
        assert!(
            (s * s + c * c - 1.0).abs() < 1e-15,
            "a rotation must not stretch"
        );
        let angle = part * std::f64::consts::TAU;
        assert!((s - libm::sin(angle)).abs() < 1e-10, "{whole} + {part}");
        assert!((c - libm::cos(angle)).abs() < 1e-10, "{whole} + {part}");
        assert!((s * s + c * c - 1.0).abs() < 1e-10);
    }
    assert_eq!(
        [0.0, 0.25, 0.5, 0.75, -1.0].map(own::sin_cos_turns),
        [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0), (0.0, 1.0)]
    );
}

#[test]
fn exponentials() {
    check(
        "exp",
        0.51,
        worst(|i| ranged(5, i, -103.0, 88.7), own::exp, libm::exp),
    );
    check(
        "exp any",
        0.51,
        worst(|i| any_finite(6, i), own::exp, libm::exp),
    );
    check(
        "expm1",
        0.51,
        worst(|i| ranged(7, i, -20.0, 88.7), own::expm1, libm::expm1),
    );
    check(
        "expm1 any",
        0.51,
        worst(|i| any_finite(8, i), own::expm1, libm::expm1),
    );
    assert_eq!(own::exp(f32::INFINITY), f32::INFINITY);
    assert_eq!(own::exp(f32::NEG_INFINITY), 0.0);
    assert_eq!(own::expm1(f32::NEG_INFINITY), -1.0);
    assert_eq!(own::exp(0.0), 1.0);
    assert!(own::exp(f32::NAN).is_nan() && own::expm1(f32::NAN).is_nan());
}

#[test]
fn logarithms() {
    check(
        "ln any",
        0.51,
        worst(|i| any_finite(9, i).abs().max(1e-45), own::ln, libm::log),
    );
    check(
        "ln near 1",
        0.51,
        worst(|i| ranged(10, i, 0.6, 1.5), own::ln, libm::log),
    );
    check(
        "log1p",
        0.51,
        worst(|i| ranged(11, i, -0.999_999, 3.0), own::log1p, libm::log1p),
    );
    check(
        "log1p near 0",
        0.51,
        worst(|i| ranged(12, i, -0.03, 0.03), own::log1p, libm::log1p),
    );
    check(
        "log1p any",
        0.51,
        worst(|i| any_finite(13, i).abs(), own::log1p, libm::log1p),
    );
    check(
        "log1p tiny",
        0.51,
        worst(|i| any_finite(14, i) % 0.5, own::log1p, libm::log1p),
    );
    assert_eq!(own::ln(0.0), f32::NEG_INFINITY);
    assert_eq!(own::ln(f32::INFINITY), f32::INFINITY);
    assert_eq!(own::ln(1.0), 0.0);
    assert_eq!(own::log1p(-1.0), f32::NEG_INFINITY);
    assert!(own::ln(-1.0).is_nan() && own::log1p(-2.0).is_nan() && own::ln(f32::NAN).is_nan());
}

#[test]
fn power() {
    let mut largest = (0.0, 0.0, 0.0);
    for i in 0..2 * SAMPLES {
        let x = if i % 2 == 0 {
            any_finite(15, i).abs().max(1e-45)
        } else {
            ranged(16, i, 0.9, 1.1)
        };
        let y = if i % 3 == 0 {
            ranged(17, i, -3000.0, 3000.0)
        } else {
            ranged(18, i, -8.0, 8.0)
        };
        let exact = libm::pow(f64::from(x), f64::from(y));
        let e = error_ulp(own::powf(x, y), exact);
        if e > largest.0 {
            largest = (e, x, y);
        }
    }
    println!("powf: {largest:?}");
    assert!(largest.0 <= 0.52, "{largest:?}");
    assert_eq!(own::powf(0.0, 2.0), 0.0);
    assert_eq!(own::powf(0.0, 0.0), 1.0);
    assert_eq!(own::powf(0.0, -1.0), f32::INFINITY);
    assert_eq!(own::powf(f32::INFINITY, -1.0), 0.0);
    assert_eq!(own::powf(f32::INFINITY, 0.5), f32::INFINITY);
    assert!(own::powf(-1.0, 0.5).is_nan());
}

#[test]
fn inverse_trigonometry() {
    check(
        "acos",
        0.51,
        worst(|i| ranged(19, i, -1.0, 1.0), own::acos, libm::acos),
    );
    check(
        "acos near 1",
        0.51,
        worst(|i| 1.0 - ranged(20, i, 0.0, 1e-4), own::acos, libm::acos),
    );
    check(
        "asin",
        0.51,
        worst(|i| ranged(21, i, -1.0, 1.0), own::asin, libm::asin),
    );
    check(
        "asin tiny",
        0.51,
        worst(|i| any_finite(22, i) % 1.0, own::asin, libm::asin),
    );
    let mut largest = (0.0, 0.0, 0.0);
    for i in 0..2 * SAMPLES {
        let (y, x) = if i % 2 == 0 {
            (any_finite(23, i), any_finite(24, i))
        } else {
            (ranged(25, i, -1.0, 1.0), ranged(26, i, -1.0, 1.0))
        };
        let e = error_ulp(own::atan2(y, x), libm::atan2(f64::from(y), f64::from(x)));
        if e > largest.0 {
            largest = (e, y, x);
        }
    }
    println!("atan2: {largest:?}");
    assert!(largest.0 <= 0.51, "{largest:?}");
    let edges = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        f32::INFINITY,
        f32::NEG_INFINITY,
        1e-45,
        f32::MAX,
    ];
    for y in edges {
        for x in edges {
            let exact = libm::atan2(f64::from(y), f64::from(x));
            assert!(
                (f64::from(own::atan2(y, x)) - exact).abs() <= 2e-7,
                "atan2({y}, {x})"
            );
        }
    }
    assert_eq!(own::acos(1.000_001), 0.0);
    assert!(own::acos(f32::NAN).is_nan() && own::atan2(f32::NAN, 1.0).is_nan());
}

/// The same bits everywhere: if this hash differs on some machine, the
/// functions there are not these functions.
#[test]
fn output_bits_are_fixed() {
    let mut hash = 0u64;
    let mut fold =
        |v: f32| hash = mix64(hash ^ u64::from(v.to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    for i in 0..200_000 {
        let x = ranged(31, i, -40.0, 40.0);
        let u = ranged(32, i, 0.0, 1.0);
        let (s, c) = own::sin_cos(x);
        for v in [
            s,
            c,
            own::exp(x),
            own::expm1(x * 0.01),
            own::ln(u + 1e-6),
            own::log1p(u * 0.1),
            own::powf(u + 1e-3, x),
            own::atan2(x, u - 0.5),
            own::acos(2.0 * u - 1.0),
            own::asin(2.0 * u - 1.0),
        ] {
            fold(v);
        }
    }
    assert_eq!(hash, 0x0e14_dfc9_0dcb_8f41, "{hash:#018x}");
}
