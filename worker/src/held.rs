//! The leases that this worker holds.

use shearwater_shared::job::JobId;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// One lease and what is left of it.
#[derive(Debug)]
pub(crate) struct HeldLease {
    /// Number of the lease.
    pub(crate) id: i64,
    /// Its job.
    pub(crate) job: JobId,
    /// How often the coordinator wants to hear of it.
    pub(crate) heartbeat: Duration,
    /// Set once nobody wants its results any more; render threads look at it.
    pub(crate) cancel: AtomicBool,
    open_runs: AtomicUsize,
}

impl HeldLease {
    /// A lease of `runs` runs.
    pub(crate) fn new(id: i64, job: JobId, heartbeat: Duration, runs: usize) -> Self {
        Self {
            id,
            job,
            heartbeat,
            cancel: AtomicBool::new(false),
            open_runs: AtomicUsize::new(runs),
        }
    }

    /// Whether its results are still wanted.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }
}

/// All leases held. Bounded by the lease loop, which asks for the next one
/// only when the queue of runs is nearly empty.
#[derive(Debug, Default)]
pub(crate) struct Held(Mutex<BTreeMap<i64, Arc<HeldLease>>>);

impl Held {
    fn map(&self) -> std::sync::MutexGuard<'_, BTreeMap<i64, Arc<HeldLease>>> {
        // Nothing that holds the lock can panic half-way through a change.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Begin to hold a lease.
    pub(crate) fn insert(&self, lease: Arc<HeldLease>) {
        self.map().insert(lease.id, lease);
    }

    /// One run of `lease` is settled: delivered, refused or reported.
    pub(crate) fn settle_run(&self, lease: &HeldLease) {
        if lease.open_runs.fetch_sub(1, Ordering::Relaxed) <= 1 {
            self.map().remove(&lease.id);
        }
    }

    /// Let a lease go and stop what renders for it.
    pub(crate) fn abandon(&self, id: i64) {
        if let Some(lease) = self.map().remove(&id) {
            lease.cancel.store(true, Ordering::Relaxed);
        }
    }

    /// Stop what renders, but go on holding the leases: they are to be released.
    pub(crate) fn cancel_all(&self) {
        for lease in self.map().values() {
            lease.cancel.store(true, Ordering::Relaxed);
        }
    }

    /// Let everything go; the numbers of the leases.
    pub(crate) fn abandon_all(&self) -> Vec<i64> {
        let all = std::mem::take(&mut *self.map());
        for lease in all.values() {
            lease.cancel.store(true, Ordering::Relaxed);
        }
        all.into_keys().collect()
    }

    /// Numbers of the leases held.
    pub(crate) fn ids(&self) -> Vec<i64> {
        self.map().keys().copied().collect()
    }

    /// The shortest heartbeat that any lease asks for.
    pub(crate) fn heartbeat(&self) -> Option<Duration> {
        self.map().values().map(|lease| lease.heartbeat).min()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lease_is_held_until_its_last_run_is_settled() {
        let held = Held::default();
        let lease = Arc::new(HeldLease::new(7, JobId(1), Duration::from_secs(1), 2));
        held.insert(lease.clone());
        held.settle_run(&lease);
        assert_eq!(held.ids(), [7]);
        held.settle_run(&lease);
        assert!(held.ids().is_empty() && !lease.is_cancelled());
    }

    #[test]
    fn an_abandoned_lease_is_cancelled() {
        let held = Held::default();
        let lease = Arc::new(HeldLease::new(7, JobId(1), Duration::from_secs(1), 2));
        held.insert(lease.clone());
        held.abandon(7);
        assert!(lease.is_cancelled() && held.heartbeat().is_none());
        held.settle_run(&lease);
        held.abandon(7);
    }
}
