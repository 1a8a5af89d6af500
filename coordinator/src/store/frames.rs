//! Frames of a job: how far each one is, its film and its error.

use super::error::{Attempt, StoreError, corrupt};
use super::errors::{self, ErrorRow};
use super::open::Store;
use super::order::lock_job;
use super::rows::{count, hash, optional_text, small, stop_code};
use shearwater_shared::api::StopCause;
use shearwater_shared::film::ErrorEstimate;
use shearwater_shared::hash::ContentHash;
use shearwater_shared::job::JobId;
use sqlx::Any;
use sqlx::any::AnyRow;

/// A frame whose rows are made.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameRow {
    /// The job's number of it, from 0.
    pub frame: u32,
    /// Units to be counted, as far as known.
    pub units_due: u64,
    /// Units counted.
    pub units_done: u64,
    /// Hash of its film, once that is final.
    pub film_hash: Option<ContentHash>,
    /// Error of its final film.
    pub error: Option<ErrorEstimate>,
}

/// How a frame ended.
#[derive(Clone, Copy, Debug)]
pub struct FrameEnd {
    /// Hash of its film.
    pub film_hash: ContentHash,
    /// Why it has no more samples.
    pub cause: StopCause,
    /// Samples per pixel, least and most.
    pub samples: (u32, u32),
    /// `extended` of the job that was decided by.
    pub extended: i64,
}

const COLUMNS: &str = "frame, units_due, units_done, film_hash, error";

impl Store {
    /// Bad samples of a frame's counted runs; 0 when there is no such frame.
    ///
    /// # Errors
    /// The database failed.
    pub async fn bad_samples(&self, job: JobId, frame: u32) -> Result<u64, StoreError> {
        let row = sqlx::query("SELECT bad_samples FROM frame WHERE job = $1 AND frame = $2")
            .bind(job.0)
            .bind(i64::from(frame))
            .fetch_optional(&self.read)
            .await
            .attempt("read bad samples")?;
        row.map_or(Ok(0), |row| count(&row, "bad_samples"))
    }

    /// At most `limit` frames from number `from` on, in order: those that have
    /// rows.
    ///
    /// # Errors
    /// The database failed.
    pub async fn frames(
        &self,
        job: JobId,
        from: u32,
        limit: u32,
    ) -> Result<Vec<FrameRow>, StoreError> {
        let end = i64::from(from) + i64::from(limit);
        self.frame_rows("frame >= $2 AND frame < $3 ORDER BY frame", job, from, end)
            .await
    }

    /// One frame; `None` when its rows are not made yet.
    ///
    /// # Errors
    /// The database failed.
    pub async fn frame(&self, job: JobId, frame: u32) -> Result<Option<FrameRow>, StoreError> {
        let mut rows = self.frames(job, frame, 1).await?;
        Ok(rows.pop())
    }

    /// The finished frame with the largest NMSE, the earliest of equal ones;
    /// `None` before the first is finished.
    ///
    /// # Errors
    /// The database failed.
    pub async fn worst_frame(&self, job: JobId) -> Result<Option<FrameRow>, StoreError> {
        let mut rows = self
            .frame_rows(
                "frame >= $2 AND nmse_pico IS NOT NULL \
                 AND nmse_pico = (SELECT max(nmse_pico) FROM frame WHERE job = $1 \
                 AND nmse_pico IS NOT NULL) ORDER BY frame LIMIT $3",
                job,
                0,
                1,
            )
            .await?;
        Ok(rows.pop())
    }

    // The condition is ours; it sees $2 and $3.
    async fn frame_rows(
        &self,
        condition: &'static str,
        job: JobId,
        from: u32,
        last: i64,
    ) -> Result<Vec<FrameRow>, StoreError> {
        let sql = format!("SELECT {COLUMNS} FROM frame WHERE job = $1 AND {condition}");
        sqlx::query::<Any>(sqlx::AssertSqlSafe(sql))
            .bind(job.0)
            .bind(i64::from(from))
            .bind(last)
            .fetch_all(&self.read)
            .await
            .attempt("read frames")?
            .iter()
            .map(frame_row)
            .collect()
    }

    /// Film hashes of at most `limit` finished frames, with their numbers.
    ///
    /// # Errors
    /// The database failed.
    pub async fn film_hashes(
        &self,
        id: JobId,
        limit: u32,
    ) -> Result<Vec<(u32, ContentHash)>, StoreError> {
        sqlx::query(
            "SELECT frame, film_hash FROM frame WHERE job = $1 AND film_hash IS NOT NULL \
             ORDER BY frame LIMIT $2",
        )
        .bind(id.0)
        .bind(i64::from(limit))
        .fetch_all(&self.read)
        .await
        .attempt("read film hashes")?
        .iter()
        .map(|row| Ok((small(row, "frame")?, hash(row, "film_hash")?)))
        .collect()
    }

    /// Store a frame's film hash and last error, once; with the last frame the job is
    /// done. False when another was faster, or the job was added to meanwhile.
    ///
    /// # Errors
    /// The database failed; the frame is as before.
    pub async fn finish_frame(
        &self,
        job: JobId,
        frame: u32,
        end: &FrameEnd,
        last: Option<&ErrorRow>,
        now_ms: i64,
    ) -> Result<bool, StoreError> {
        let error = last.map(|last| &last.error);
        let text = error.map(serde_json::to_string).transpose();
        let text = text.map_err(|e| corrupt("frame error", e))?;
        let mut tx = self.begin().await?;
        lock_job(&mut tx, job).await?;
        let first = sqlx::query(
            "UPDATE frame SET film_hash = $3, error = $4, nmse_pico = $5 \
             WHERE job = $1 AND frame = $2 AND film_hash IS NULL AND EXISTS \
             (SELECT 1 FROM job WHERE id = $1 AND extended = $6) AND NOT EXISTS \
             (SELECT 1 FROM audit WHERE job = $1 AND frame = $2) AND NOT EXISTS (SELECT 1 \
             FROM distrust d JOIN part p ON p.worker = d.worker WHERE p.job = $1 AND p.frame = $2)",
        )
        .bind(job.0)
        .bind(i64::from(frame))
        .bind(end.film_hash.to_string())
        .bind(text)
        .bind(error.map(|error| pico(error.nmse)))
        .bind(end.extended)
        .execute(&mut *tx)
        .await
        .attempt("store film hash")?;
        if first.rows_affected() != 1 {
            return Ok(false);
        }
        if let Some(last) = last {
            errors::insert(&mut tx, job, last).await?;
        }
        let live = sqlx::query(
            "UPDATE job SET frames_done = frames_done + 1, rev = rev + 1, \
             stopped = CASE WHEN stopped < $3 THEN $3 ELSE stopped END, \
             samples_min = CASE WHEN samples_min <= $4 THEN samples_min ELSE $4 END, \
             samples_max = CASE WHEN samples_max >= $5 THEN samples_max ELSE $5 END, \
             finished_ms = CASE WHEN frames_done + 1 = frames THEN $2 ELSE NULL END \
             WHERE id = $1 AND finished_ms IS NULL AND extended = $6",
        )
        .bind(job.0)
        .bind(now_ms)
        .bind(stop_code(end.cause))
        .bind(i64::from(end.samples.0))
        .bind(i64::from(end.samples.1))
        .bind(end.extended)
        .execute(&mut *tx)
        .await
        .attempt("count frame")?;
        if live.rows_affected() != 1 {
            return Ok(false);
        }
        tx.commit().await.attempt("commit frame")?;
        Ok(true)
    }
}

/// In 10^-12, to be ordered as an integer; `as` saturates, and a NaN becomes 0.
fn pico(nmse: f64) -> i64 {
    (nmse * 1e12) as i64
}

fn frame_row(row: &AnyRow) -> Result<FrameRow, StoreError> {
    let film_hash = optional_text(row, "film_hash")?
        .map(|text| text.parse().map_err(|e| corrupt("film_hash", e)))
        .transpose()?;
    let error = optional_text(row, "error")?
        .map(|text| serde_json::from_str(&text).map_err(|e| corrupt("error", e)))
        .transpose()?;
    Ok(FrameRow {
        frame: small(row, "frame")?,
        units_due: count(row, "units_due")?,
        units_done: count(row, "units_done")?,
        film_hash,
        error,
    })
}
