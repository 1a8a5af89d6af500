//! Samples are added to a job.

use super::error::{Attempt, StoreError, corrupt};
use super::idem::{self, IdempotencyKey};
use super::open::Store;
use super::rows::{JobRow, big};
use shearwater_shared::job::{JobId, RenderSettings};
use shearwater_shared::plan::Plan;
use sqlx::{Any, Transaction};

impl Store {
    /// Give the job the settings `new`, made of those of `old` (see
    /// [`crate::farm::extended`]): what is counted stays, what is missing is due
    /// again, frame by frame as it is claimed. False when the job has changed in
    /// this respect since it was read, or has ended without being done. `key` is
    /// remembered with it.
    ///
    /// # Errors
    /// The database failed; the job is as before.
    pub async fn extend(
        &self,
        old: &JobRow,
        new: &RenderSettings,
        key: Option<&IdempotencyKey>,
        now_ms: i64,
    ) -> Result<bool, StoreError> {
        let mut tx = self.begin().await?;
        let text = serde_json::to_string(new).map_err(|e| corrupt("settings", e))?;
        let live = sqlx::query(
            "UPDATE job SET settings = $3, stop_s = $4, extended = extended + 1, \
             first_lease_ms = first_lease_ms \
             + CASE WHEN finished_ms IS NULL THEN 0 ELSE $5 - coalesce(last_result_ms, $5) END, \
             timed_from_ms = NULL, finished_ms = NULL, frames_done = 0, stopped = 0, \
             samples_min = NULL, samples_max = NULL, rev = rev + 1 \
             WHERE id = $1 AND extended = $2 AND ended = 0",
        )
        .bind(old.id.0)
        .bind(old.extended)
        .bind(text)
        .bind(new.stop.seconds.map(i64::from))
        .bind(now_ms)
        .execute(&mut *tx)
        .await
        .attempt("extend job")?;
        if live.rows_affected() != 1 {
            return Ok(false);
        }
        if let Some(key) = key {
            idem::remember(&mut tx, key, old.id, now_ms).await?;
        }
        reopen(&mut tx, old.id).await?;
        if new.stop.error.is_some() {
            same_blocks(&mut tx, old.id).await?;
        } else {
            more_blocks(&mut tx, old.id, new).await?;
        }
        tx.commit().await.attempt("commit extension")?;
        Ok(true)
    }
}

/// Withheld units are ready again, and every frame is open.
async fn reopen(tx: &mut Transaction<'static, Any>, job: JobId) -> Result<(), StoreError> {
    for statement in [
        "UPDATE unit SET state = 0 WHERE job = $1 AND state = 3",
        "UPDATE frame SET film_hash = NULL, error = NULL, nmse_pico = NULL WHERE job = $1",
    ] {
        let done = sqlx::query(statement).bind(job.0).execute(&mut **tx).await;
        done.attempt("open frames")?;
    }
    Ok(())
}

/// All tiles get the blocks of `new`: their rows are made when they are claimed, in
/// another walk through the frames.
async fn more_blocks(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
    new: &RenderSettings,
) -> Result<(), StoreError> {
    let plan = Plan::new(new);
    let frames = u64::from(new.frames);
    let samples = plan.frame_samples().saturating_mul(frames);
    for (statement, number) in [
        (
            "UPDATE tilefold SET due = $2 WHERE job = $1",
            plan.blocks().into(),
        ),
        (
            "UPDATE frame SET units_due = $2 WHERE job = $1",
            big(plan.units_per_frame()),
        ),
        (
            "UPDATE job SET next_frame = CASE WHEN blocks = $2 THEN next_frame ELSE 0 END, \
             blocks = $2, units_due = frames * tiles * $2 WHERE id = $1",
            plan.blocks().into(),
        ),
        (
            "UPDATE job SET samples_total = $2 WHERE id = $1",
            big(samples),
        ),
    ] {
        let query = sqlx::query(statement).bind(job.0).bind::<i64>(number);
        let done = query.execute(&mut **tx).await;
        done.attempt("count what is due")?;
    }
    Ok(())
}

/// Tiles keep their blocks; every frame is decided about once more.
async fn same_blocks(tx: &mut Transaction<'static, Any>, job: JobId) -> Result<(), StoreError> {
    for statement in [
        "UPDATE frame SET pass = pass + 1, units_due = (SELECT count(*) FROM unit u \
         WHERE u.job = frame.job AND u.frame = frame.frame) WHERE job = $1",
        "UPDATE tilefold SET due = (SELECT count(*) FROM unit u WHERE u.job = tilefold.job \
         AND u.frame = tilefold.frame AND u.tile = tilefold.tile) WHERE job = $1",
        "UPDATE job SET units_due = (frames - next_frame) * tiles * blocks \
         + (SELECT count(*) FROM unit WHERE unit.job = job.id) WHERE id = $1",
    ] {
        let done = sqlx::query(statement).bind(job.0).execute(&mut **tx).await;
        done.attempt("count what is due")?;
    }
    Ok(())
}
