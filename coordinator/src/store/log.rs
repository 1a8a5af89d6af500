//! What happened to a job's units: a ring of events beside each job.
//!
//! An event is written by the transaction that it tells of, after that has counted up
//! the job's `rev`: the log never says what did not happen, and needs no trimming.

use super::error::{Attempt, StoreError, corrupt};
use super::lists::{Listed, list, listed};
use super::open::{Engine, Store};
use super::rows::{int, json, optional_text, runs_text};
use shearwater_shared::api::{LogEvent, LogKind};
use shearwater_shared::job::JobId;
use shearwater_shared::limits::LOG_CHANGES_MAX;
use shearwater_shared::plan::Run;
use sqlx::any::AnyRow;
use sqlx::{Any, Row, Transaction};

/// An event to be written.
#[derive(Clone, Copy, Debug)]
pub(super) struct Event<'a> {
    pub(super) job: JobId,
    pub(super) kind: LogKind,
    pub(super) at_ms: i64,
    pub(super) worker: Option<&'a str>,
    pub(super) lease: Option<i64>,
    pub(super) runs: &'a [Run],
    pub(super) ms: Option<i64>,
    pub(super) text: Option<&'a str>,
}

impl Event<'_> {
    /// An event that concerns no worker and no unit.
    pub(super) const fn new(job: JobId, kind: LogKind, at_ms: i64) -> Self {
        Self {
            job,
            kind,
            at_ms,
            worker: None,
            lease: None,
            runs: &[],
            ms: None,
            text: None,
        }
    }
}

/// Write an event; its place is the job's present `rev`.
pub(super) async fn log(
    tx: &mut Transaction<'static, Any>,
    event: &Event<'_>,
) -> Result<(), StoreError> {
    let kind = serde_json::to_string(&event.kind).map_err(|e| corrupt("event", e))?;
    sqlx::query(
        "INSERT INTO job_log (job, slot, seq, at_ms, kind, worker, lease, runs, ms, text) \
         SELECT id, rev % $2, rev, $3, $4, $5, $6, $7, $8, $9 FROM job WHERE id = $1 \
         ON CONFLICT (job, slot) DO UPDATE SET seq = excluded.seq, at_ms = excluded.at_ms, \
         kind = excluded.kind, worker = excluded.worker, lease = excluded.lease, \
         runs = excluded.runs, ms = excluded.ms, text = excluded.text",
    )
    .bind(event.job.0)
    .bind(LOG_CHANGES_MAX)
    .bind(event.at_ms)
    .bind(kind)
    .bind(event.worker.map(str::to_owned))
    .bind(event.lease)
    .bind(runs_text(event.runs)?)
    .bind(event.ms)
    .bind(event.text.map(str::to_owned))
    .execute(&mut **tx)
    .await
    .attempt("write log")?;
    Ok(())
}

const LOG_ALL: Listed = listed!(
    "INSERT INTO job_log (job, slot, seq, at_ms, kind, worker, lease, runs, ms, text) \
     SELECT $2, CAST(value ->> 0 AS BIGINT) % $3, CAST(value ->> 0 AS BIGINT), $4, \
     value ->> 1, value ->> 2, CAST(value ->> 3 AS BIGINT), value ->> 4, \
     CAST(value ->> 5 AS BIGINT), value ->> 6 FROM ",
    " WHERE true ON CONFLICT (job, slot) DO UPDATE SET seq = excluded.seq, \
     at_ms = excluded.at_ms, kind = excluded.kind, worker = excluded.worker, \
     lease = excluded.lease, runs = excluded.runs, ms = excluded.ms, text = excluded.text"
);

/// Write events of one job and one moment, which counted it up to `rev`: one change for
/// each of them. Fewer than the ring is long.
pub(super) async fn log_all(
    tx: &mut Transaction<'static, Any>,
    engine: Engine,
    job: JobId,
    rev: i64,
    events: &[Event<'_>],
) -> Result<(), StoreError> {
    let Some(at_ms) = events.first().map(|event| event.at_ms) else {
        return Ok(());
    };
    let mut rows = Vec::with_capacity(events.len());
    for (event, seq) in events.iter().rev().zip((0..=rev).rev()) {
        let kind = serde_json::to_string(&event.kind).map_err(|e| corrupt("event", e))?;
        let runs = runs_text(event.runs)?;
        rows.push((
            seq,
            kind,
            event.worker,
            event.lease,
            runs,
            event.ms,
            event.text,
        ));
    }
    sqlx::query(LOG_ALL.of(engine))
        .bind(list(&rows)?)
        .bind(job.0)
        .bind(LOG_CHANGES_MAX)
        .bind(at_ms)
        .execute(&mut **tx)
        .await
        .attempt("write log")?;
    Ok(())
}

/// Count a change of the job and write its event.
pub(super) async fn log_change(
    tx: &mut Transaction<'static, Any>,
    event: &Event<'_>,
) -> Result<(), StoreError> {
    sqlx::query("UPDATE job SET rev = rev + 1 WHERE id = $1")
        .bind(event.job.0)
        .execute(&mut **tx)
        .await
        .attempt("count change")?;
    log(tx, event).await
}

impl Store {
    /// At most `limit` events of a job with smaller numbers than `below`, newest
    /// first.
    ///
    /// # Errors
    /// The database failed.
    pub async fn log(
        &self,
        job: JobId,
        below: i64,
        limit: u32,
    ) -> Result<Vec<LogEvent>, StoreError> {
        sqlx::query(
            "SELECT seq, at_ms, kind, worker, lease, runs, ms, text FROM job_log \
             WHERE job = $1 AND seq < $2 ORDER BY seq DESC LIMIT $3",
        )
        .bind(job.0)
        .bind(below)
        .bind(i64::from(limit))
        .fetch_all(&self.read)
        .await
        .attempt("read log")?
        .iter()
        .map(event_row)
        .collect()
    }
}

fn event_row(row: &AnyRow) -> Result<LogEvent, StoreError> {
    let number = |column: &'static str| row.try_get::<Option<i64>, _>(column).attempt(column);
    Ok(LogEvent {
        seq: int(row, "seq")?,
        at_ms: int(row, "at_ms")?,
        kind: json(row, "kind")?,
        worker: optional_text(row, "worker")?,
        lease: number("lease")?,
        runs: json(row, "runs")?,
        ms: number("ms")?,
        text: optional_text(row, "text")?,
    })
}
