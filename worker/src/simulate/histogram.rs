//! Durations, counted in classes of equal ratio.

use std::time::Duration;

/// Classes of each octave: a class is at most 1.6 % wide.
const PER_OCTAVE: u64 = 64;
/// Bits of [`PER_OCTAVE`].
const BITS: u32 = PER_OCTAVE.trailing_zeros();
/// Octaves beyond the exact first [`PER_OCTAVE`] microseconds: up to 2^41 us, 25 days.
const OCTAVES: u64 = 35;

/// A histogram of durations, in microseconds, of bounded size.
#[derive(Clone, Debug)]
pub struct Histogram {
    classes: Vec<u64>,
    count: u64,
    max_us: u64,
}

impl Default for Histogram {
    fn default() -> Self {
        Self {
            classes: vec![0; (PER_OCTAVE * (OCTAVES + 1)) as usize],
            count: 0,
            max_us: 0,
        }
    }
}

impl Histogram {
    /// Count one.
    pub fn record(&mut self, time: Duration) {
        let us = u64::try_from(time.as_micros()).unwrap_or(u64::MAX);
        let last = self.classes.len() - 1;
        if let Some(class) = self.classes.get_mut(class(us).min(last)) {
            *class += 1;
        }
        self.count += 1;
        self.max_us = self.max_us.max(us);
    }

    /// How many were counted.
    #[must_use]
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// The longest, exactly.
    #[must_use]
    pub const fn max(&self) -> Duration {
        Duration::from_micros(self.max_us)
    }

    /// The duration that a share `share` (0 to 1) of all does not exceed: the upper
    /// end of its class, so at most 1.6 % too much. Zero of none.
    #[must_use]
    pub fn quantile(&self, share: f64) -> Duration {
        let wanted = (self.count as f64 * share).ceil().max(1.0) as u64;
        let mut seen = 0;
        for (index, count) in self.classes.iter().enumerate() {
            seen += count;
            if seen >= wanted {
                let end = class_start(index as u64 + 1) - 1;
                return Duration::from_micros(end.min(self.max_us));
            }
        }
        self.max()
    }
}

/// The class of a duration: exact below [`PER_OCTAVE`], then by the highest bits.
fn class(us: u64) -> usize {
    if us < PER_OCTAVE {
        return us as usize;
    }
    let octave = us.ilog2() - BITS;
    let within = (us >> octave) - PER_OCTAVE;
    (PER_OCTAVE * u64::from(octave + 1) + within) as usize
}

/// The shortest duration of a class.
fn class_start(class: u64) -> u64 {
    let (octave, within) = (class / PER_OCTAVE, class % PER_OCTAVE);
    match octave {
        0 => within,
        _ => (PER_OCTAVE + within) << (octave - 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_follow_each_other_without_gap() {
        for us in (0..100_000).chain([1 << 30, (1 << 30) + 12_345, 1 << 40]) {
            let class = class(us) as u64;
            assert!(
                class_start(class) <= us && us < class_start(class + 1),
                "{us}"
            );
        }
    }

    #[test]
    fn quantiles_are_within_a_class() {
        let mut histogram = Histogram::default();
        assert_eq!(histogram.quantile(0.5), Duration::ZERO);
        for us in 1..=100_000 {
            histogram.record(Duration::from_micros(us));
        }
        for share in [0.01, 0.5, 0.9, 0.99, 1.0] {
            let exact = share * 100_000.0;
            let found = histogram.quantile(share).as_micros() as f64;
            assert!(
                (exact..=exact * 1.016 + 1.0).contains(&found),
                "{share}: {found}"
            );
        }
        assert_eq!(histogram.max(), Duration::from_millis(100));
        histogram.record(Duration::from_secs(1 << 40));
        assert_eq!(histogram.count(), 100_001);
        assert_eq!(histogram.max(), Duration::from_micros(1_000_000 << 40));
    }
}
