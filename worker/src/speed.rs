//! How fast this worker renders, and what it has done in all.

use std::sync::{Mutex, PoisonError};

/// Core seconds over which the speed forgets: a few units, so that it follows
/// a change of scene within one lease.
const MEMORY_S: f64 = 5.0;

/// What a worker has done.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Summary {
    /// Runs delivered and acknowledged.
    pub runs: u64,
    /// Of these, runs that were counted already.
    pub duplicates: u64,
    /// Runs that the coordinator no longer wanted.
    pub refused: u64,
    /// Failures reported.
    pub failures: u64,
    /// Samples rendered, delivered or not.
    pub samples: u64,
    /// Seconds that render threads spent on them.
    pub core_s: f64,
    /// Seconds that render threads waited for their next run.
    pub idle_s: f64,
}

#[derive(Debug, Default)]
struct Inner {
    summary: Summary,
    per_thread: f64,
}

/// Counters that render threads and uploads share.
#[derive(Debug, Default)]
pub(crate) struct Meter(Mutex<Inner>);

impl Meter {
    fn inner(&self) -> std::sync::MutexGuard<'_, Inner> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A thread rendered `samples` in `seconds`. The average forgets by render
    /// time, so that idle hours do not weigh and short runs weigh little.
    pub(crate) fn rendered(&self, samples: u64, seconds: f64) {
        let inner = &mut *self.inner();
        inner.summary.samples += samples;
        inner.summary.core_s += seconds;
        let rate = samples as f64 / seconds.max(1e-6);
        if inner.per_thread == 0.0 {
            inner.per_thread = rate;
        } else {
            let share = seconds / (seconds + MEMORY_S);
            inner.per_thread += share * (rate - inner.per_thread);
        }
    }

    /// Change the counters.
    pub(crate) fn count(&self, change: impl FnOnce(&mut Summary)) {
        change(&mut self.inner().summary);
    }

    /// Samples per second over `threads` threads; 0 when not yet known.
    pub(crate) fn samples_per_s(&self, threads: usize) -> f64 {
        self.inner().per_thread * threads as f64
    }

    /// What has been done so far.
    pub(crate) fn summary(&self) -> Summary {
        self.inner().summary
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speed_follows_render_time() {
        let meter = Meter::default();
        assert_eq!(meter.samples_per_s(2), 0.0);
        meter.rendered(1_000, 1.0);
        assert_eq!(meter.samples_per_s(2), 2_000.0);
        for _ in 0..60 {
            meter.rendered(4_000, 1.0);
        }
        assert!((meter.samples_per_s(1) - 4_000.0).abs() < 10.0);
        assert_eq!(meter.summary().samples, 241_000);
    }
}
