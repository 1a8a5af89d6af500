//! Leases that this process gave and ended.

use super::timer::Seconds;
use prometheus_client::encoding::EncodeLabelSet;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::{Family, MetricConstructor};
use prometheus_client::metrics::histogram::Histogram;
use prometheus_client::registry::{Registry, Unit};
use std::time::Duration;

#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
struct Kind {
    kind: &'static str,
}

/// Counters of leases; each may be counted up where it happens.
#[derive(Debug)]
pub(crate) struct Leases {
    /// Of units that nobody held.
    pub(crate) fresh: Counter,
    /// Of units that another worker holds, at the end of a job.
    pub(crate) reissued: Counter,
    /// Of counted units, to be compared.
    pub(crate) audit: Counter,
    /// Whose worker was not heard of in time.
    pub(crate) expired: Counter,
    /// That a worker gave back undone.
    pub(crate) released: Counter,
    /// Reports of workers that something of a lease cannot be rendered.
    pub(crate) failed: Counter,
    wait: Histogram,
}

impl Leases {
    pub(super) fn new(registry: &mut Registry) -> Self {
        let granted = Family::<Kind, Counter>::default();
        let of = |kind| granted.get_or_create_owned(&Kind { kind });
        let leases = Self {
            fresh: of("fresh"),
            reissued: of("reissued"),
            audit: of("audit"),
            expired: Counter::default(),
            released: Counter::default(),
            failed: Counter::default(),
            wait: Seconds.new_metric(),
        };
        registry.register("leases_granted", "Leases that workers got", granted);
        registry.register(
            "leases_expired",
            "Leases whose worker was not heard of in time",
            leases.expired.clone(),
        );
        registry.register(
            "leases_released",
            "Leases that workers gave back undone",
            leases.released.clone(),
        );
        registry.register(
            "worker_failures",
            "Reports of workers that something cannot be rendered",
            leases.failed.clone(),
        );
        registry.register_with_unit(
            "lease_wait",
            "From a worker's question to its lease; questions that brought none are left out",
            Unit::Seconds,
            leases.wait.clone(),
        );
        leases
    }

    /// A worker got a lease so long after it had asked.
    pub(crate) fn waited(&self, wait: Duration) {
        self.wait.observe(wait.as_secs_f64());
    }
}
