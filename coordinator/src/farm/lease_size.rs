//! How many units one lease holds.

/// Most units of one lease: bounds the claim's transaction. At half a second a
/// unit this is a worker of 400 cores.
const LEASE_UNITS_MAX: u64 = 8192;
/// Near the end a worker takes this part of its fair share of what is pending:
/// half, so that the lease sizes shrink and all end at nearly the same time
/// (guided self-scheduling, Polychronopoulos and Kuck 1987, with factor 2).
const SHARE_DIVISOR: f64 = 2.0;

/// What decides the size of a lease.
#[derive(Clone, Copy, Debug)]
pub struct Sizing {
    /// How long a lease should take.
    pub target_ms: u64,
    /// Samples of an average unit, at least 1.
    pub unit_samples: u64,
    /// The worker's samples per second; 0 when not known.
    pub samples_per_s: f64,
    /// The worker's threads.
    pub threads: u32,
    /// Units of the job that nobody holds.
    pub pending: u64,
    /// Other workers heard of lately.
    pub others: u64,
    /// Their samples per second together; those unknown count 0.
    pub others_samples_per_s: f64,
}

/// Units for the next lease, at least 1. A worker of unknown speed gets one
/// unit per thread: about a second, enough to measure it.
#[must_use]
pub fn lease_units(sizing: &Sizing) -> u64 {
    let speed = if sizing.samples_per_s.is_finite() && sizing.samples_per_s > 0.0 {
        sizing.samples_per_s
    } else {
        0.0
    };
    let by_time = if speed > 0.0 {
        let samples = speed * sizing.target_ms as f64 / 1000.0;
        (samples / sizing.unit_samples.max(1) as f64) as u64
    } else {
        u64::from(sizing.threads)
    };
    let by_share = if sizing.others == 0 {
        sizing.pending
    } else {
        fair_share(sizing, speed)
    };
    by_time.min(by_share).clamp(1, LEASE_UNITS_MAX)
}

fn fair_share(sizing: &Sizing, speed: f64) -> u64 {
    let others = sizing.others_samples_per_s;
    let share = if speed > 0.0 && others.is_finite() && others > 0.0 {
        speed / (speed + others)
    } else {
        1.0 / (sizing.others as f64 + 1.0)
    };
    (sizing.pending as f64 * share / SHARE_DIVISOR) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALONE: Sizing = Sizing {
        target_ms: 10_000,
        unit_samples: 500_000,
        samples_per_s: 1e6,
        threads: 2,
        pending: 1000,
        others: 0,
        others_samples_per_s: 0.0,
    };

    #[test]
    fn a_known_worker_gets_its_target_time() {
        assert_eq!(lease_units(&ALONE), 20);
        let short = Sizing {
            target_ms: 1000,
            ..ALONE
        };
        assert_eq!(lease_units(&short), 2);
        let slow = Sizing {
            samples_per_s: 10.0,
            ..ALONE
        };
        assert_eq!(lease_units(&slow), 1);
    }

    #[test]
    fn an_unknown_or_lying_worker_gets_little() {
        for samples_per_s in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let unknown = Sizing {
                samples_per_s,
                ..ALONE
            };
            assert_eq!(lease_units(&unknown), 2);
        }
        let boaster = Sizing {
            samples_per_s: 1e300,
            pending: u64::MAX,
            ..ALONE
        };
        assert_eq!(lease_units(&boaster), LEASE_UNITS_MAX);
    }

    #[test]
    fn near_the_end_others_find_work_too() {
        let shared = Sizing {
            pending: 16,
            others: 3,
            others_samples_per_s: 3e6,
            ..ALONE
        };
        assert_eq!(lease_units(&shared), 2);
        let fast_among_slow = Sizing {
            others_samples_per_s: 1e6,
            ..shared
        };
        assert_eq!(lease_units(&fast_among_slow), 4);
        assert_eq!(
            lease_units(&Sizing {
                pending: 1,
                ..shared
            }),
            1
        );
        assert_eq!(
            lease_units(&Sizing {
                pending: 16,
                ..ALONE
            }),
            16
        );
    }
}
