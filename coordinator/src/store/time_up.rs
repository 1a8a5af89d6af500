//! A job's time is up: what nobody has begun is withheld.

use super::error::{Attempt, StoreError};
use super::open::Store;
use super::order::lock_job;
use super::rows::{int, small};
use crate::farm::frames_out_of_time;
use shearwater_shared::job::JobId;
use sqlx::{Any, Row, Transaction};

impl Store {
    /// Withhold what is out of time in every job with a time stop; how many units.
    ///
    /// # Errors
    /// The database failed.
    pub async fn withhold_all(&self, now_ms: i64) -> Result<u64, StoreError> {
        let jobs = sqlx::query(
            "SELECT id, frames, stop_s, timed_from_ms FROM job WHERE finished_ms IS NULL \
             AND paused_ms IS NULL AND stop_s IS NOT NULL AND timed_from_ms IS NOT NULL",
        )
        .fetch_all(&self.read)
        .await
        .attempt("find jobs with a time stop")?;
        let mut withheld = 0;
        for row in &jobs {
            let (from_ms, seconds) = (int(row, "timed_from_ms")?, small(row, "stop_s")?);
            let over = frames_out_of_time(from_ms, seconds, small(row, "frames")?, now_ms);
            if over == 0 {
                continue;
            }
            let mut tx = self.begin().await?;
            let units = withhold(&mut tx, JobId(int(row, "id")?), over).await?;
            if units > 0 {
                tx.commit().await.attempt("commit end of time")?;
                withheld += units;
            }
        }
        Ok(withheld)
    }

    /// Units of a frame that are withheld.
    ///
    /// # Errors
    /// The database failed.
    pub async fn withheld_units(&self, job: JobId, frame: u32) -> Result<u64, StoreError> {
        let row = sqlx::query(
            "SELECT count(*) AS units FROM unit WHERE job = $1 AND frame = $2 AND state = 3",
        )
        .bind(job.0)
        .bind(i64::from(frame))
        .fetch_one(&self.read)
        .await
        .attempt("count withheld units")?;
        let units: i64 = row.try_get("units").attempt("units")?;
        Ok(u64::try_from(units).unwrap_or(0))
    }
}

/// Withhold the ready units of the job's first `over` frames, but for the first
/// block of each tile: every pixel gets samples. What is leased may still come.
pub(super) async fn withhold(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
    over: u32,
) -> Result<u64, StoreError> {
    let bound = |sql: &'static str| sqlx::query(sql).bind(job.0).bind(i64::from(over));
    let gone = bound(
        "UPDATE unit SET state = 3 WHERE job = $1 AND frame < $2 AND state = 0 AND block > 0",
    )
    .execute(&mut **tx)
    .await
    .attempt("withhold units")?
    .rows_affected();
    if gone == 0 {
        return Ok(0);
    }
    lock_job(tx, job).await?;
    for count_again in [
        "UPDATE frame SET units_due = (SELECT count(*) FROM unit u WHERE u.job = frame.job \
         AND u.frame = frame.frame AND u.state < 3) \
         WHERE job = $1 AND frame < $2 AND film_hash IS NULL",
        "UPDATE tilefold SET due = (SELECT count(*) FROM unit u WHERE u.job = tilefold.job \
         AND u.frame = tilefold.frame AND u.tile = tilefold.tile AND u.state < 3) \
         WHERE job = $1 AND frame IN (SELECT frame FROM frame f WHERE f.job = $1 \
         AND f.frame < $2 AND f.film_hash IS NULL)",
    ] {
        let counted = bound(count_again).execute(&mut **tx).await;
        counted.attempt("count what is due")?;
    }
    // Of an average unit each: the last block of a tile may be shorter.
    sqlx::query(
        "UPDATE job SET samples_total = samples_total - samples_total / units_due * $2, \
         units_due = units_due - $2, rev = rev + 1 WHERE id = $1 AND units_due > 0",
    )
    .bind(job.0)
    .bind(i64::try_from(gone).unwrap_or(i64::MAX))
    .execute(&mut **tx)
    .await
    .attempt("withhold from job")?;
    Ok(gone)
}
