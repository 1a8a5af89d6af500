//! Runs that could not be rendered, and workers that fail too often.

use super::error::{Attempt, StoreError};
use super::log::{Event, log};
use super::open::Store;
use super::order::lock_job;
use super::rows::{count, optional_text};
use crate::farm::{UnitFailures, WorkerStreak};
use shearwater_shared::api::LogKind;
use shearwater_shared::job::JobId;
use shearwater_shared::plan::Run;
use sqlx::{Any, Transaction};

impl Store {
    /// Record that `worker` failed on `runs` (one event) and free what `lease`
    /// holds of them.
    ///
    /// # Errors
    /// The database failed; nothing was recorded.
    pub async fn record_failure(
        &self,
        job: JobId,
        lease: i64,
        runs: &[Run],
        worker: &str,
        reason: &str,
        now_ms: i64,
    ) -> Result<(UnitFailures, WorkerStreak), StoreError> {
        let mut tx = self.begin().await?;
        let mut failures = UnitFailures::default();
        for run in runs {
            let of_run = fail_run(&mut tx, job, lease, run, worker, reason).await?;
            failures.workers = failures.workers.max(of_run.workers);
            failures.times = failures.times.max(of_run.times);
        }
        lock_job(&mut tx, job).await?;
        for run in runs {
            free_audit(&mut tx, job, lease, run).await?;
        }
        let event = Event {
            worker: Some(worker),
            lease: Some(lease),
            runs,
            text: Some(reason),
            ..Event::new(job, LogKind::Failed, now_ms)
        };
        log(&mut tx, &event).await?;
        let first = runs.first().map(|r| (r.frame, r.tile, r.block0));
        let streak = sqlx::query(
            "UPDATE worker SET failed_in_row = failed_in_row \
             + CASE WHEN failed_last = $2 THEN 0 ELSE 1 END, failed_last = $2 \
             WHERE instance = $1 RETURNING failed_in_row",
        )
        .bind(worker)
        .bind(format!("{job} {first:?}"))
        .fetch_optional(&mut *tx)
        .await
        .attempt("count worker's failures")?;
        tx.commit().await.attempt("commit failure")?;
        let streak = streak.map_or(Ok(0), |row| count(&row, "failed_in_row"))?;
        Ok((failures, WorkerStreak(streak)))
    }

    /// What was last said about a failing unit of the job.
    ///
    /// # Errors
    /// The database failed.
    pub async fn failure_reason(&self, job: JobId) -> Result<Option<String>, StoreError> {
        let row = sqlx::query(
            "SELECT reason FROM failure WHERE job = $1 ORDER BY times DESC, frame, tile, block \
             LIMIT 1",
        )
        .bind(job.0)
        .fetch_optional(&self.read)
        .await
        .attempt("read failure")?;
        row.map_or(Ok(None), |row| optional_text(&row, "reason"))
    }

    /// Give a worker nothing until `until_ms`, for this reason.
    ///
    /// # Errors
    /// The database failed.
    pub async fn quarantine(
        &self,
        worker: &str,
        until_ms: i64,
        reason: &str,
    ) -> Result<(), StoreError> {
        sqlx::query(
            "UPDATE worker SET quarantined_until_ms = $2, quarantine_reason = $3, \
             failed_in_row = 0, failed_last = '' WHERE instance = $1",
        )
        .bind(worker)
        .bind(until_ms)
        .bind(reason)
        .execute(&self.write)
        .await
        .attempt("quarantine worker")?;
        Ok(())
    }
}

/// An audit that the lease holds goes to another worker.
async fn free_audit(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
    lease: i64,
    run: &Run,
) -> Result<(), StoreError> {
    sqlx::query(
        "UPDATE audit SET lease = 0, tries = tries + 1 WHERE job = $1 AND frame = $2 AND tile = $3 \
         AND block0 = $4 AND block1 = $5 AND lease = $6",
    )
    .bind(job.0)
    .bind(i64::from(run.frame))
    .bind(i64::from(run.tile))
    .bind(i64::from(run.block0))
    .bind(i64::from(run.block1))
    .bind(lease)
    .execute(&mut **tx)
    .await
    .attempt("free audit")?;
    Ok(())
}

async fn fail_run(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
    lease: i64,
    run: &Run,
    worker: &str,
    reason: &str,
) -> Result<UnitFailures, StoreError> {
    let bound = |sql: &'static str| {
        sqlx::query(sql)
            .bind(job.0)
            .bind(i64::from(run.frame))
            .bind(i64::from(run.tile))
            .bind(i64::from(run.block0))
            .bind(i64::from(run.block1))
    };
    bound(
        "INSERT INTO failure (job, frame, tile, block, worker, times, reason) \
         SELECT job, frame, tile, block, $6, 1, $7 FROM unit WHERE job = $1 AND frame = $2 \
         AND tile = $3 AND block >= $4 AND block < $5 AND state < 2 \
         ON CONFLICT (job, frame, tile, block, worker) \
         DO UPDATE SET times = failure.times + 1, reason = excluded.reason",
    )
    .bind(worker.to_owned())
    .bind(reason.to_owned())
    .execute(&mut **tx)
    .await
    .attempt("record failure")?;
    bound(
        "UPDATE unit SET state = 0, lease = 0 WHERE job = $1 AND frame = $2 AND tile = $3 \
         AND block >= $4 AND block < $5 AND state = 1 AND lease = $6",
    )
    .bind(lease)
    .execute(&mut **tx)
    .await
    .attempt("free units")?;
    let worst = bound(
        "SELECT count(*) AS workers, CAST(coalesce(sum(times), 0) AS BIGINT) AS times \
         FROM failure WHERE job = $1 AND frame = $2 AND tile = $3 AND block >= $4 \
         AND block < $5 GROUP BY block ORDER BY workers DESC, times DESC LIMIT 1",
    )
    .fetch_optional(&mut **tx)
    .await
    .attempt("count unit's failures")?;
    Ok(match worst {
        Some(row) => UnitFailures {
            workers: count(&row, "workers")?,
            times: count(&row, "times")?,
        },
        None => UnitFailures::default(),
    })
}
