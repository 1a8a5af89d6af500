//! What went over the line: for whoever measures it.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

/// Calls and the bytes of their bodies. Heads are not in it: some 200 bytes each way.
#[derive(Debug, Default)]
pub(crate) struct Traffic {
    calls: AtomicU64,
    sent_bytes: AtomicU64,
    received_bytes: AtomicU64,
    /// By status or what else came instead of an answer: a few hundred keys at most.
    failures: Mutex<BTreeMap<String, u64>>,
}

/// What was counted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TrafficSum {
    /// Calls.
    pub calls: u64,
    /// Bytes of their bodies.
    pub sent_bytes: u64,
    /// Bytes of the answers' bodies.
    pub received_bytes: u64,
    /// Calls without success: by HTTP status, `timeout`, or `connection`.
    pub failures: BTreeMap<String, u64>,
}

impl Traffic {
    pub(crate) fn sends(&self, bytes: usize) {
        self.calls.fetch_add(1, Ordering::Relaxed);
        self.sent_bytes.fetch_add(bytes as u64, Ordering::Relaxed);
    }

    pub(crate) fn receives(&self, bytes: usize) {
        self.received_bytes
            .fetch_add(bytes as u64, Ordering::Relaxed);
    }

    pub(crate) fn fails(&self, how: &str) {
        let mut failures = self.failures.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(count) = failures.get_mut(how) {
            *count += 1;
        } else {
            failures.insert(how.to_owned(), 1);
        }
    }

    /// So far.
    #[must_use]
    pub(crate) fn sum(&self) -> TrafficSum {
        let failures = self.failures.lock().unwrap_or_else(PoisonError::into_inner);
        TrafficSum {
            calls: self.calls.load(Ordering::Relaxed),
            sent_bytes: self.sent_bytes.load(Ordering::Relaxed),
            received_bytes: self.received_bytes.load(Ordering::Relaxed),
            failures: failures.clone(),
        }
    }
}
