//! Which workers are there: heard of here, or by another coordinator.
//!
//! A farm of thousands is heard of thousands of times a second. What is heard is kept
//! here and written once a second, and what all coordinators heard is read as often:
//! times of presence may be a second or two old, which changes when something is
//! handed out, never what is counted.

use crate::app::App;
use crate::gather::{Gathered, Gatherer};
use crate::store::{Store, StoreError, WorkerRow};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A worker counts as present when it was heard of within this time: longer
/// than the longest poll ([`shearwater_shared::limits::LEASE_WAIT_MS_MAX`]).
pub(crate) const PRESENT_MS: i64 = 30_000;
/// Workers written by one statement: some ten milliseconds.
const CHUNK: usize = 1000;

/// Workers present, by instance.
pub(crate) type Present = BTreeMap<String, WorkerRow>;

/// Who is there, and what of it is not yet written.
#[derive(Debug)]
pub(crate) struct Presence {
    inner: Mutex<Inner>,
    newcomers: Gatherer<WorkerRow, Answer>,
}

/// Whether a new worker's row is written.
pub(crate) type Answer = Result<(), StoreError>;

#[derive(Debug, Default)]
struct Inner {
    present: Arc<Present>,
    /// Asked for work since the last writing.
    asked: BTreeMap<String, WorkerRow>,
    /// Heard of otherwise.
    seen_ms: BTreeMap<String, i64>,
}

/// Write rows of new workers, all that come at once by one statement.
pub(crate) async fn welcome_all(app: Arc<App>, mut newcomers: Gathered<WorkerRow, Answer>) {
    while let Some(batch) = newcomers.batch(CHUNK).await {
        let rows = batch.iter().map(|asked| asked.item.clone());
        // One that asks twice counts once.
        let rows: Present = rows.map(|row| (row.instance.clone(), row)).collect();
        let written: Vec<WorkerRow> = rows.values().cloned().collect();
        let written = app.store.workers_asked(&written).await.map_err(Arc::new);
        if written.is_ok() {
            Arc::make_mut(&mut app.presence.inner().present).extend(rows);
        }
        for asked in batch {
            let answer = written.clone().map_err(StoreError::Shared);
            let _ = asked.answer.send(answer);
        }
    }
}

impl Presence {
    /// Nobody yet.
    pub(crate) fn new(newcomers: Gatherer<WorkerRow, Answer>) -> Self {
        Self {
            inner: Mutex::default(),
            newcomers,
        }
    }

    fn inner(&self) -> MutexGuard<'_, Inner> {
        // A panic elsewhere leaves the values whole.
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Who is there.
    pub(crate) fn present(&self) -> Arc<Present> {
        Arc::clone(&self.inner().present)
    }

    /// A worker asks for work. One that is new is written at once: what follows may
    /// need its row.
    pub(crate) async fn asked(&self, row: WorkerRow) -> Result<(), StoreError> {
        {
            let mut inner = self.inner();
            if inner.present.contains_key(&row.instance) {
                inner.asked.insert(row.instance.clone(), row);
                return Ok(());
            }
        }
        // Nobody answers once the process ends.
        self.newcomers.ask(row).await.unwrap_or(Ok(()))
    }

    /// A worker is heard of.
    pub(crate) fn seen(&self, instance: &str, now_ms: i64) {
        self.inner().seen_ms.insert(instance.to_owned(), now_ms);
    }

    /// Write what was heard and read who is there.
    ///
    /// # Errors
    /// The database failed; what was not written is lost, and heard again soon.
    pub(crate) async fn refresh(&self, store: &Store, now_ms: i64) -> Result<(), StoreError> {
        let (asked, seen) = {
            let mut inner = self.inner();
            let asked = std::mem::take(&mut inner.asked);
            (asked, std::mem::take(&mut inner.seen_ms))
        };
        let asked: Vec<WorkerRow> = asked.into_values().collect();
        for rows in asked.chunks(CHUNK) {
            store.workers_asked(rows).await?;
        }
        let seen: Vec<(String, i64)> = seen.into_iter().collect();
        for rows in seen.chunks(CHUNK) {
            store.workers_seen(rows).await?;
        }
        let rows = store.workers(now_ms - PRESENT_MS).await?;
        let rows = rows.into_iter().map(|row| (row.instance.clone(), row));
        let mut present: Present = rows.collect();
        let mut inner = self.inner();
        // Who came while this was read stays.
        for (instance, row) in inner.present.iter() {
            if row.seen_ms >= now_ms && !present.contains_key(instance) {
                present.insert(instance.clone(), row.clone());
            }
        }
        inner.present = Arc::new(present);
        Ok(())
    }
}
