//! How long something takes, however it ends.

use prometheus_client::metrics::family::MetricConstructor;
use prometheus_client::metrics::histogram::Histogram;
use std::time::Instant;

/// Upper bounds in seconds for what takes a moment: from what a fast disk needs to what no
/// request may last.
const BOUNDS_S: [f64; 12] = [
    0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 1.0, 5.0, 25.0,
];

/// Makes histograms of seconds.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Seconds;

impl MetricConstructor<Histogram> for Seconds {
    fn new_metric(&self) -> Histogram {
        Histogram::new(BOUNDS_S)
    }
}

/// Observes the time since it was made when it is dropped.
#[derive(Debug)]
#[must_use = "the time ends when it is dropped"]
pub(crate) struct Timer {
    histogram: Histogram,
    began: Instant,
}

impl Timer {
    /// Begin.
    pub(super) fn of(histogram: Histogram) -> Self {
        Self {
            histogram,
            began: Instant::now(),
        }
    }
}

impl Drop for Timer {
    fn drop(&mut self) {
        self.histogram.observe(self.began.elapsed().as_secs_f64());
    }
}
