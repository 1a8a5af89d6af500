//! Chance by a seed: what a simulated worker does depends on nothing else.

/// What is drawn.
#[derive(Clone, Copy, Debug)]
pub(super) enum Draw {
    /// Whether a worker is one of the slow ones.
    Slow = 1,
    /// How long a run takes.
    Time = 2,
    /// Whether a run fails.
    Failure = 3,
    /// Whether a worker vanishes at the end of a run.
    Vanish = 4,
    /// Light of a block.
    Light = 5,
}

/// 64 bits for `what` and three numbers, by the finaliser of `SplitMix64` (Steele,
/// Lea and Flood 2014).
pub(super) fn bits(seed: u64, what: Draw, numbers: [u64; 3]) -> u64 {
    [what as u64, numbers[0], numbers[1], numbers[2]]
        .iter()
        .fold(seed, |state, number| {
            let mut z = (state ^ number).wrapping_add(0x9E37_79B9_7F4A_7C15);
            z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
            z ^ (z >> 31)
        })
}

/// A number from 0 to 1, 1 excluded.
pub(super) fn share(seed: u64, what: Draw, numbers: [u64; 3]) -> f64 {
    (bits(seed, what, numbers) >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_are_even_and_repeat() {
        let draws = (0..10_000).map(|n| share(7, Draw::Time, [n / 100, n % 100, 0]));
        let (mut mean, mut below) = (0.0, 0);
        for draw in draws {
            assert!((0.0..1.0).contains(&draw));
            mean += draw / 10_000.0;
            below += u32::from(draw < 0.1);
        }
        assert!((0.48..0.52).contains(&mean), "{mean}");
        assert!((900..1100).contains(&below), "{below}");
        let one = |seed, what| bits(seed, what, [1, 2, 3]);
        assert_eq!(one(7, Draw::Time), one(7, Draw::Time));
        assert_ne!(one(7, Draw::Time), one(8, Draw::Time));
        assert_ne!(one(7, Draw::Time), one(7, Draw::Vanish));
    }
}
