//! Values between keys.

/// The values at `t` of keys in the order of their times; those of the first
/// before it, of the last after it, zeros without any.
///
/// Cubic Hermite pieces with the slopes of Steffen 1990 ("A simple method for
/// monotonic interpolation in one dimension", equation 11): a parabola through
/// three neighbours, however unevenly they lie, but flat at a turning point and
/// never so steep that the curve leaves the range of two neighbours. So equal
/// neighbours stay equal between them. Flat at both ends: the speed never jumps.
pub(super) fn interpolate<K, const N: usize>(
    keys: &[K],
    time_s: impl Fn(&K) -> f64,
    values: impl Fn(&K) -> [f64; N],
    t: f64,
) -> [f64; N] {
    let next = keys.partition_point(|key| time_s(key) <= t);
    let Some(before) = next.checked_sub(1) else {
        return keys.first().map_or([0.0; N], values);
    };
    if next == keys.len() {
        return values(&keys[before]);
    }
    let point = |i: usize, axis: usize| (time_s(&keys[i]), values(&keys[i])[axis]);
    std::array::from_fn(|axis| {
        let (t0, v0) = point(before, axis);
        let (t1, v1) = point(next, axis);
        let slope = |i: usize| {
            if i == 0 || i + 1 == keys.len() {
                return 0.0;
            }
            slope(point(i - 1, axis), point(i, axis), point(i + 1, axis))
        };
        let h = t1 - t0;
        let w = (t - t0) / h;
        let rest = 1.0 - w;
        let bend = rest * slope(before) - w * slope(next);
        v0 + (v1 - v0) * (w * w * (3.0 - 2.0 * w)) + h * w * rest * bend
    })
}

fn slope((t0, v0): (f64, f64), (t1, v1): (f64, f64), (t2, v2): (f64, f64)) -> f64 {
    let (h0, h1) = (t1 - t0, t2 - t1);
    let (s0, s1) = ((v1 - v0) / h0, (v2 - v1) / h1);
    // Opposite signs: a turning point.
    if (s0 > 0.0) != (s1 > 0.0) {
        return 0.0;
    }
    let parabola = (s0 * h1 + s1 * h0) / (h0 + h1);
    let least = s0.abs().min(s1.abs()).min(0.5 * parabola.abs());
    if s0 > 0.0 { 2.0 * least } else { -2.0 * least }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEYS: [(f64, f64); 7] = [
        (-1.0, 2.0),
        (0.5, 3.0),
        (0.7, 5.0),
        (3.0, 5.0),
        (4.0, -1.0),
        (4.5, -1.5),
        (6.0, 0.0),
    ];

    fn at(t: f64) -> f64 {
        interpolate(&KEYS, |k| k.0, |k| [k.1], t)[0]
    }

    #[test]
    fn keys_are_met_and_the_ends_rest() {
        for (t, v) in KEYS {
            assert_eq!(at(t), v);
            assert!((at(t - 1e-9) - v).abs() < 1e-7);
        }
        assert_eq!((at(-5.0), at(9.0)), (2.0, 0.0));
        let none: [(f64, f64); 0] = [];
        assert_eq!(interpolate(&none, |k| k.0, |k| [k.1], 1.0), [0.0]);
        assert_eq!(interpolate(&KEYS[..1], |k| k.0, |k| [k.1], 7.0), [2.0]);
    }

    #[test]
    fn the_speed_never_jumps_and_nothing_overshoots() {
        let step = 1e-5;
        let speed = |t: f64| (at(t + step) - at(t)) / step;
        let mut t = -1.5;
        while t < 6.5 {
            // The curvature of these keys stays below 400.
            assert!(
                (speed(t) - speed(t - step)).abs() < 400.0 * 2.0 * step,
                "{t}"
            );
            let around: Vec<_> = KEYS
                .windows(2)
                .filter(|w| w[0].0 <= t && t <= w[1].0)
                .collect();
            for pair in around {
                let (low, high) = (pair[0].1.min(pair[1].1), pair[0].1.max(pair[1].1));
                assert!(low - 1e-12 <= at(t) && at(t) <= high + 1e-12, "{t}");
            }
            t += 0.003;
        }
        assert_eq!(at(1.9), 5.0);
    }

    #[test]
    fn even_keys_on_a_line_make_a_line_between_the_ends() {
        let keys: Vec<_> = (0..6).map(|i| (f64::from(i), 3.0 * f64::from(i))).collect();
        for t in [1.0, 1.3, 2.5, 3.9, 4.0] {
            let v = interpolate(&keys, |k| k.0, |k| [k.1], t)[0];
            assert!((v - 3.0 * t).abs() < 1e-12, "{t}: {v}");
        }
    }
}
