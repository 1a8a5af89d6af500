//! Leases: kept alive, given back, expired.

use super::error::{Attempt, StoreError};
use super::log::{Event, log};
use super::open::Store;
use super::order::lock_job;
use super::rows::{int, json, text};
use crate::metrics::Transaction as Kind;
use shearwater_shared::api::LogKind;
use shearwater_shared::job::JobId;
use shearwater_shared::plan::Run;
use sqlx::Row;
use std::collections::BTreeSet;

/// Leases that one pass of the reaper ends; the next pass is a second later.
const EXPIRE_MAX: i64 = 256;
/// Open leases that the endgame looks at: more means that it is no endgame.
const OPEN_LEASES_MAX: i64 = 512;

/// A lease as stored.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LeaseRow {
    /// Number.
    pub id: i64,
    /// Job.
    pub job: JobId,
    /// Worker (instance).
    pub worker: String,
    /// What it covers.
    pub runs: Vec<Run>,
    /// When it was given.
    pub created_ms: i64,
    /// When it expires.
    pub until_ms: i64,
    /// No longer waited for.
    pub closed: bool,
}

impl Store {
    /// Give every open lease until `until_ms` at least: after a start, since
    /// nobody could be heard while nobody listened.
    ///
    /// # Errors
    /// The database failed.
    pub async fn prolong_all(&self, until_ms: i64) -> Result<(), StoreError> {
        sqlx::query("UPDATE lease SET until_ms = $1 WHERE closed = 0 AND until_ms < $1")
            .bind(until_ms)
            .execute(&self.write)
            .await
            .attempt("prolong leases")?;
        Ok(())
    }

    /// Cut times that no clock of today can have given: after a clock was set
    /// back, leases, presence and quarantine would last until it catches up.
    /// Leases end by `lease_ms` at the latest, quarantine by `quarantine_ms`.
    ///
    /// # Errors
    /// The database failed.
    pub async fn cut_future_times(
        &self,
        now_ms: i64,
        lease_ms: i64,
        quarantine_ms: i64,
    ) -> Result<(), StoreError> {
        for (statement, latest_ms) in [
            (
                "UPDATE lease SET until_ms = $1 WHERE closed = 0 AND until_ms > $1",
                lease_ms,
            ),
            ("UPDATE worker SET seen_ms = $1 WHERE seen_ms > $1", now_ms),
            (
                "UPDATE worker SET quarantined_until_ms = $1 WHERE quarantined_until_ms > $1",
                quarantine_ms,
            ),
        ] {
            sqlx::query(statement)
                .bind(latest_ms)
                .execute(&self.write)
                .await
                .attempt("cut times")?;
        }
        Ok(())
    }

    /// One lease.
    ///
    /// # Errors
    /// The database failed.
    pub async fn lease(&self, id: i64) -> Result<Option<LeaseRow>, StoreError> {
        sqlx::query(
            "SELECT id, job, worker, runs, created_ms, until_ms, closed FROM lease WHERE id = $1",
        )
        .bind(id)
        .fetch_optional(&self.read)
        .await
        .attempt("read lease")?
        .map(|row| lease_row(&row))
        .transpose()
    }

    /// Open leases of a job, oldest first.
    ///
    /// # Errors
    /// The database failed.
    pub async fn open_leases(&self, job: JobId) -> Result<Vec<LeaseRow>, StoreError> {
        sqlx::query(
            "SELECT id, job, worker, runs, created_ms, until_ms, closed FROM lease \
             WHERE job = $1 AND closed = 0 ORDER BY id LIMIT $2",
        )
        .bind(job.0)
        .bind(OPEN_LEASES_MAX)
        .fetch_all(&self.read)
        .await
        .attempt("read open leases")?
        .iter()
        .map(lease_row)
        .collect()
    }

    /// First units (frame, tile, block) of leased stretches, to see which runs
    /// of open leases are still waited for.
    ///
    /// # Errors
    /// The database failed.
    pub async fn leased_units(
        &self,
        job: JobId,
        limit: u32,
    ) -> Result<BTreeSet<(u32, u32, u32)>, StoreError> {
        let rows = sqlx::query(
            "SELECT frame, tile, block FROM unit WHERE job = $1 AND state = 1 \
             ORDER BY frame, tile, block LIMIT $2",
        )
        .bind(job.0)
        .bind(i64::from(limit))
        .fetch_all(&self.read)
        .await
        .attempt("read leased units")?;
        rows.iter()
            .map(|row| {
                Ok((
                    super::rows::small(row, "frame")?,
                    super::rows::small(row, "tile")?,
                    super::rows::small(row, "block")?,
                ))
            })
            .collect()
    }

    /// End leases whose time has passed: their units are ready again. Returns
    /// how many ended. A result that comes later is still counted.
    ///
    /// # Errors
    /// The database failed.
    pub async fn expire(&self, now_ms: i64) -> Result<usize, StoreError> {
        let rows = sqlx::query(
            "SELECT id FROM lease WHERE closed = 0 AND until_ms < $1 ORDER BY until_ms LIMIT $2",
        )
        .bind(now_ms)
        .bind(EXPIRE_MAX)
        .fetch_all(&self.read)
        .await
        .attempt("find expired leases")?;
        let mut ended = 0;
        for row in &rows {
            ended += usize::from(self.end_lease(int(row, "id")?, None, now_ms).await?);
        }
        Ok(ended)
    }

    /// Give a lease back undone; false when it is not this worker's or ended.
    ///
    /// # Errors
    /// The database failed.
    pub async fn release(&self, worker: &str, id: i64, now_ms: i64) -> Result<bool, StoreError> {
        self.end_lease(id, Some(worker), now_ms).await
    }

    // Close the lease if it is open and either is `worker`'s, if one is named, or ran
    // out before `now_ms`: a heartbeat may have come since it was found.
    async fn end_lease(
        &self,
        id: i64,
        worker: Option<&str>,
        now_ms: i64,
    ) -> Result<bool, StoreError> {
        let _timed = self.measures.transaction(Kind::EndLease);
        let mut tx = self.begin().await?;
        let row = sqlx::query("SELECT job, worker, runs FROM lease WHERE id = $1 AND closed = 0")
            .bind(id)
            .fetch_optional(&mut *tx)
            .await
            .attempt("look at lease")?;
        let Some(row) = row else { return Ok(false) };
        let job = JobId(int(&row, "job")?);
        sqlx::query(
            "UPDATE unit SET state = 0, lease = 0 WHERE job = $1 AND state = 1 AND lease = $2",
        )
        .bind(job.0)
        .bind(id)
        .execute(&mut *tx)
        .await
        .attempt("free units")?;
        lock_job(&mut tx, job).await?;
        let ended = sqlx::query(
            "UPDATE lease SET closed = 1 WHERE id = $1 AND closed = 0 \
             AND (($3 = '' AND until_ms < $2) OR worker = $3)",
        )
        .bind(id)
        .bind(now_ms)
        .bind(worker.unwrap_or(""))
        .execute(&mut *tx)
        .await
        .attempt("close lease")?;
        if ended.rows_affected() != 1 {
            return Ok(false);
        }
        let (kind, tries) = match worker {
            Some(_) => (LogKind::Released, 0i64),
            None => (LogKind::Expired, 1),
        };
        sqlx::query(
            "UPDATE audit SET lease = 0, tries = tries + $2, changed_ms = $3 \
             WHERE lease > 0 AND lease = $1",
        )
        .bind(id)
        .bind(tries)
        .bind(now_ms)
        .execute(&mut *tx)
        .await
        .attempt("free audits")?;
        let (holder, runs) = (text(&row, "worker")?, json::<Vec<Run>>(&row, "runs")?);
        let event = Event {
            worker: Some(&holder),
            lease: Some(id),
            runs: &runs,
            ..Event::new(job, kind, now_ms)
        };
        log(&mut tx, &event).await?;
        tx.commit().await.attempt("commit end of lease")?;
        Ok(true)
    }
}

fn lease_row(row: &sqlx::any::AnyRow) -> Result<LeaseRow, StoreError> {
    Ok(LeaseRow {
        id: int(row, "id")?,
        job: JobId(int(row, "job")?),
        worker: text(row, "worker")?,
        runs: json(row, "runs")?,
        created_ms: int(row, "created_ms")?,
        until_ms: int(row, "until_ms")?,
        closed: row.try_get::<i64, _>("closed").attempt("closed")? != 0,
    })
}
