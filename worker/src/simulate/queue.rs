//! The runs that a simulated worker has yet to begin.

use crate::held::HeldLease;
use shearwater_shared::plan::Run;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::Notify;

/// A run and the lease it is of.
pub(super) type Task = (Arc<HeldLease>, Run);

/// Runs in the order to render. Bounded by the lease loop, which asks for the next
/// lease only when the queue is nearly empty.
#[derive(Debug, Default)]
pub(super) struct Queue {
    runs: Mutex<VecDeque<Task>>,
    came: Notify,
    went: Notify,
}

impl Queue {
    fn runs(&self) -> MutexGuard<'_, VecDeque<Task>> {
        // Nothing that holds the lock can panic half-way through a change.
        self.runs.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Add runs at the end.
    pub(super) fn extend(&self, runs: impl Iterator<Item = Task>) {
        self.runs().extend(runs);
        self.came.notify_waiters();
    }

    /// The next run, once there is one.
    pub(super) async fn next(&self) -> Task {
        loop {
            let came = self.came.notified();
            tokio::pin!(came);
            // Registered before the look: what comes in between is not missed.
            came.as_mut().enable();
            let next = self.runs().pop_front();
            if let Some(run) = next {
                self.went.notify_waiters();
                return run;
            }
            came.await;
        }
    }

    /// Wait until at most `most` runs are left.
    pub(super) async fn at_most(&self, most: usize) {
        loop {
            let went = self.went.notified();
            tokio::pin!(went);
            went.as_mut().enable();
            if self.runs().len() <= most {
                return;
            }
            went.await;
        }
    }
}
