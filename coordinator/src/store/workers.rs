//! Workers, as they last said they were.

use super::error::{Attempt, StoreError};
use super::open::Store;
use super::rows::{count, int, optional_text, small, text};
use std::collections::BTreeMap;

/// Workers shown or considered at once; the most lately seen ones.
const WORKERS_MAX: i64 = 16_384;

/// A worker.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WorkerRow {
    /// Random, per process.
    pub instance: String,
    /// Name for people.
    pub name: String,
    /// Threads that render.
    pub threads: u32,
    /// Thousandths of samples per second; 0 when not known.
    pub milli_samples_per_s: u64,
    /// When it was last heard of.
    pub seen_ms: i64,
    /// Its sums were found to be wrong: it gets nothing any more.
    pub distrusted: bool,
    /// Gets nothing before this time.
    pub quarantined_until_ms: i64,
    /// Why.
    pub quarantine_reason: Option<String>,
}

impl Store {
    /// Workers heard of since `since_ms`, by name.
    ///
    /// # Errors
    /// The database failed.
    pub async fn workers(&self, since_ms: i64) -> Result<Vec<WorkerRow>, StoreError> {
        sqlx::query(
            "SELECT instance, name, threads, milli_samples_per_s, seen_ms, quarantined_until_ms, \
             coalesce(d.reason, quarantine_reason) AS reason, \
             CAST(CASE WHEN d.worker IS NULL THEN 0 ELSE 1 END AS BIGINT) AS distrusted \
             FROM worker LEFT JOIN distrust d ON d.worker = instance \
             WHERE seen_ms >= $1 ORDER BY name, instance LIMIT $2",
        )
        .bind(since_ms)
        .bind(WORKERS_MAX)
        .fetch_all(&self.read)
        .await
        .attempt("read workers")?
        .iter()
        .map(|row| {
            Ok(WorkerRow {
                instance: text(row, "instance")?,
                name: text(row, "name")?,
                threads: small(row, "threads")?,
                milli_samples_per_s: count(row, "milli_samples_per_s")?,
                seen_ms: int(row, "seen_ms")?,
                distrusted: int(row, "distrusted")? != 0,
                quarantined_until_ms: int(row, "quarantined_until_ms")?,
                quarantine_reason: optional_text(row, "reason")?,
            })
        })
        .collect()
    }

    /// Tiles of live jobs of which a worker holds units, by worker.
    ///
    /// # Errors
    /// The database failed.
    pub async fn runs_held(&self) -> Result<BTreeMap<String, u64>, StoreError> {
        sqlx::query(
            "SELECT worker, count(*) AS held FROM (SELECT DISTINCT l.worker AS worker, u.job, \
             u.frame, u.tile FROM unit u JOIN lease l ON l.id = u.lease WHERE u.state = 1 \
             AND u.job IN (SELECT id FROM job WHERE finished_ms IS NULL)) held GROUP BY worker",
        )
        .fetch_all(&self.read)
        .await
        .attempt("read held runs")?
        .iter()
        .map(|row| Ok((text(row, "worker")?, count(row, "held")?)))
        .collect()
    }
}
