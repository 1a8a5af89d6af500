//! Workers are heard: their leases live on, their rows are kept up.

use super::commit::with_open_runs;
use super::error::{Attempt, StoreError};
use super::lists::{Listed, list, listed};
use super::open::Store;
use super::rows::{big, int, json};
use super::workers::WorkerRow;
use crate::metrics::Transaction as Kind;
use shearwater_shared::job::JobId;
use shearwater_shared::plan::Run;
use std::collections::BTreeSet;

/// A worker says that it works on a lease.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Beat {
    /// Number of the lease.
    pub lease: i64,
    /// Worker (instance).
    pub worker: String,
}

// `+` and CROSS JOIN: SQLite begins with the list instead of an index of all that is open.
const PROLONG: Listed = listed!(
    "UPDATE lease SET until_ms = $2 FROM (SELECT CAST(value ->> 0 AS BIGINT) AS l, \
     value ->> 1 AS w FROM ",
    ") v WHERE lease.id = v.l AND lease.worker = v.w AND +lease.closed = 0 \
     AND lease.until_ms < $2"
);
const LIVE_LEASES: Listed = listed!(
    "SELECT lease.id AS id, lease.job AS job, lease.runs AS runs FROM \
     (SELECT CAST(value ->> 0 AS BIGINT) AS l, value ->> 1 AS w FROM ",
    ") v CROSS JOIN lease CROSS JOIN job WHERE lease.id = v.l AND lease.worker = v.w \
     AND job.id = lease.job AND +job.finished_ms IS NULL"
);
const AUDIT_LEASES: Listed = listed!(
    "SELECT DISTINCT lease AS id FROM audit WHERE lease > 0 \
     AND lease IN (SELECT CAST(value ->> 0 AS BIGINT) FROM ",
    ")"
);
const NOTE_WORKERS: Listed = listed!(
    "INSERT INTO worker (instance, name, threads, milli_samples_per_s, seen_ms) \
     SELECT value ->> 0, value ->> 1, CAST(value ->> 2 AS BIGINT), \
     CAST(value ->> 3 AS BIGINT), CAST(value ->> 4 AS BIGINT) FROM ",
    " WHERE true ON CONFLICT (instance) DO UPDATE SET name = excluded.name, \
     threads = excluded.threads, milli_samples_per_s = excluded.milli_samples_per_s, \
     seen_ms = excluded.seen_ms"
);
const NOTE_SEEN: Listed = listed!(
    "UPDATE worker SET seen_ms = v.seen FROM (SELECT value ->> 0 AS w, \
     CAST(value ->> 1 AS BIGINT) AS seen FROM ",
    ") v WHERE worker.instance = v.w AND worker.seen_ms < v.seen"
);

impl Store {
    /// Prolong the open ones of these leases. Returns those that are still wanted,
    /// open or not: their job is live and some unit is not yet counted, or is to be
    /// compared.
    ///
    /// # Errors
    /// The database failed.
    pub async fn hear(&self, beats: &[Beat], until_ms: i64) -> Result<BTreeSet<i64>, StoreError> {
        if beats.is_empty() {
            return Ok(BTreeSet::new());
        }
        let _timed = self.measures.transaction(Kind::Heartbeat);
        // In one order: rows are locked in it.
        let beats: BTreeSet<(i64, &str)> =
            beats.iter().map(|b| (b.lease, b.worker.as_str())).collect();
        let beats = list(&beats.into_iter().collect::<Vec<_>>())?;
        sqlx::query(PROLONG.of(self.engine))
            .bind(&beats)
            .bind(until_ms)
            .execute(&self.write)
            .await
            .attempt("prolong leases")?;
        let rows = sqlx::query(LIVE_LEASES.of(self.engine))
            .bind(&beats)
            .fetch_all(&self.read)
            .await
            .attempt("read leases")?;
        let mut live = BTreeSet::new();
        let mut runs = Vec::new();
        for row in &rows {
            let (id, job) = (int(row, "id")?, JobId(int(row, "job")?));
            live.insert(id);
            let of_lease = json::<Vec<Run>>(row, "runs")?;
            runs.extend(of_lease.into_iter().map(|run| (id, job, run)));
        }
        let mut wanted = with_open_runs(&self.read, self.engine, &runs).await?;
        let closed: Vec<[i64; 1]> = live.difference(&wanted).map(|id| [*id]).collect();
        if !closed.is_empty() {
            let audits = sqlx::query(AUDIT_LEASES.of(self.engine))
                .bind(list(&closed)?)
                .fetch_all(&self.read)
                .await
                .attempt("look at audits")?;
            for row in &audits {
                wanted.insert(int(row, "id")?);
            }
        }
        Ok(wanted)
    }

    /// Note that workers asked for work; each once, in one order.
    ///
    /// # Errors
    /// The database failed.
    pub async fn workers_asked(&self, workers: &[WorkerRow]) -> Result<(), StoreError> {
        let rows: Vec<_> = workers
            .iter()
            .map(|w| {
                let speed = big(w.milli_samples_per_s);
                (&w.instance, &w.name, w.threads, speed, w.seen_ms)
            })
            .collect();
        sqlx::query(NOTE_WORKERS.of(self.engine))
            .bind(list(&rows)?)
            .execute(&self.write)
            .await
            .attempt("note workers")?;
        Ok(())
    }

    /// Note when workers (instances) were heard of; each once, in one order.
    ///
    /// # Errors
    /// The database failed.
    pub async fn workers_seen(&self, seen_ms: &[(String, i64)]) -> Result<(), StoreError> {
        sqlx::query(NOTE_SEEN.of(self.engine))
            .bind(list(seen_ms)?)
            .execute(&self.write)
            .await
            .attempt("note workers")?;
        Ok(())
    }
}
