//! Error against time: a row for a frame whenever its error has changed enough.

use super::error::{Attempt, StoreError, corrupt};
use super::open::Store;
use super::order::lock_job;
use super::rows::{big, count, int, json, small};
use shearwater_shared::film::{Brightness, ErrorEstimate};
use shearwater_shared::job::JobId;
use sqlx::any::AnyRow;
use sqlx::{Any, Transaction};

/// A row is due when the films of a frame hold at least this share more samples, in
/// percent of those of its last row: five or so to an octave draw a smooth curve.
const GROWTH_PERCENT: i64 = 120;
/// Most rows of a frame but the final one. From one unit to the 2^20 that a frame
/// may have there are 77 steps; the rest is room for samples that are added later.
pub const ERROR_POINTS_MAX: u32 = 128;

/// The error of a frame at one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorRow {
    /// The job's number of the frame, from 0.
    pub frame: u32,
    /// Samples that its films held, over all pixels.
    pub samples: u64,
    /// When.
    pub at_ms: i64,
    /// Microseconds of cores spent on these samples.
    pub core_us: u64,
    /// What the halves said.
    pub error: ErrorEstimate,
}

/// Samples and core time in the films of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Folded {
    /// Samples over all pixels.
    pub samples: u64,
    /// Microseconds of cores.
    pub core_us: u64,
}

const COLUMNS: &str = "frame, samples, at_ms, core_us, error";

impl Store {
    /// What the films of an unfinished frame hold, if a row of it is due.
    ///
    /// # Errors
    /// The database failed.
    pub async fn error_due(&self, job: JobId, frame: u32) -> Result<Option<Folded>, StoreError> {
        let row = sqlx::query(
            "SELECT f.samples_folded, f.core_us_folded FROM frame f WHERE f.job = $1 \
             AND f.frame = $2 AND f.film_hash IS NULL AND f.samples_folded > 0 \
             AND f.samples_folded * 100 >= $3 * (SELECT coalesce(max(p.samples), 0) \
             FROM error_point p WHERE p.job = $1 AND p.frame = $2) \
             AND $4 > (SELECT count(*) FROM error_point p WHERE p.job = $1 AND p.frame = $2)",
        )
        .bind(job.0)
        .bind(i64::from(frame))
        .bind(GROWTH_PERCENT)
        .bind(i64::from(ERROR_POINTS_MAX))
        .fetch_optional(&self.read)
        .await
        .attempt("look for due errors")?;
        row.as_ref().map(folded).transpose()
    }

    /// What the films of a frame hold; `None` when its rows are not made yet.
    ///
    /// # Errors
    /// The database failed.
    pub async fn folded(&self, job: JobId, frame: u32) -> Result<Option<Folded>, StoreError> {
        let row = sqlx::query(
            "SELECT samples_folded, core_us_folded FROM frame WHERE job = $1 AND frame = $2",
        )
        .bind(job.0)
        .bind(i64::from(frame))
        .fetch_optional(&self.read)
        .await
        .attempt("read folded samples")?;
        row.as_ref().map(folded).transpose()
    }

    /// Add a row, if the job is still there; another of as many samples stays.
    ///
    /// # Errors
    /// The database failed.
    pub async fn add_error(&self, job: JobId, point: &ErrorRow) -> Result<(), StoreError> {
        let mut tx = self.begin().await?;
        // Whoever watches sees the new numbers.
        lock_job(&mut tx, job).await?;
        insert(&mut tx, job, point).await?;
        tx.commit().await.attempt("commit error")
    }

    /// At most `limit` rows of a frame of more than `after` samples, in order.
    ///
    /// # Errors
    /// The database failed.
    pub async fn errors(
        &self,
        job: JobId,
        frame: u32,
        after: u64,
        limit: u32,
    ) -> Result<Vec<ErrorRow>, StoreError> {
        let sql = format!(
            "SELECT {COLUMNS} FROM error_point WHERE job = $1 AND frame = $2 AND samples > $3 \
             ORDER BY samples LIMIT $4"
        );
        sqlx::query::<Any>(sqlx::AssertSqlSafe(sql))
            .bind(job.0)
            .bind(i64::from(frame))
            .bind(big(after))
            .bind(i64::from(limit))
            .fetch_all(&self.read)
            .await
            .attempt("read errors")?
            .iter()
            .map(error_row)
            .collect()
    }

    /// The last row of a frame.
    ///
    /// # Errors
    /// The database failed.
    pub async fn last_error(&self, job: JobId, frame: u32) -> Result<Option<ErrorRow>, StoreError> {
        let sql = format!(
            "SELECT {COLUMNS} FROM error_point WHERE job = $1 AND frame = $2 \
             ORDER BY samples DESC LIMIT 1"
        );
        let row = sqlx::query::<Any>(sqlx::AssertSqlSafe(sql))
            .bind(job.0)
            .bind(i64::from(frame))
            .fetch_optional(&self.read)
            .await
            .attempt("read error")?;
        row.as_ref().map(error_row).transpose()
    }

    /// The newest row of a job, of whatever frame.
    ///
    /// # Errors
    /// The database failed.
    pub async fn newest_error(&self, job: JobId) -> Result<Option<ErrorRow>, StoreError> {
        let sql = format!(
            "SELECT {COLUMNS} FROM error_point WHERE job = $1 \
             ORDER BY at_ms DESC, frame DESC, samples DESC LIMIT 1"
        );
        let row = sqlx::query::<Any>(sqlx::AssertSqlSafe(sql))
            .bind(job.0)
            .fetch_optional(&self.read)
            .await
            .attempt("read error")?;
        row.as_ref().map(error_row).transpose()
    }

    /// The histogram of a frame's samples, as far as its films have one.
    ///
    /// # Errors
    /// The database failed.
    pub async fn brightness(&self, job: JobId, frame: u32) -> Result<Brightness, StoreError> {
        let rows = sqlx::query(
            "SELECT brightness FROM tilefold WHERE job = $1 AND frame = $2 \
             AND brightness IS NOT NULL",
        )
        .bind(job.0)
        .bind(i64::from(frame))
        .fetch_all(&self.read)
        .await
        .attempt("read brightness")?;
        let mut all = Brightness::zero();
        for row in &rows {
            for (bin, samples, light) in json::<Vec<(usize, u64, u128)>>(row, "brightness")? {
                let place = all.bins.get_mut(bin);
                let place = place.ok_or_else(|| corrupt("brightness", format!("bin {bin}")))?;
                place.samples = place.samples.saturating_add(samples);
                place.light = place.light.saturating_add(light);
            }
        }
        Ok(all)
    }
}

/// The bins of a histogram that hold samples, as a tile's row keeps them.
pub(super) fn brightness_text(brightness: &Brightness) -> Result<Option<String>, StoreError> {
    let bins = (0usize..).zip(&brightness.bins);
    let bins: Vec<(usize, u64, u128)> = bins
        .filter(|(_, bin)| bin.samples > 0)
        .map(|(index, bin)| (index, bin.samples, bin.light))
        .collect();
    if bins.is_empty() {
        return Ok(None);
    }
    let text = serde_json::to_string(&bins).map_err(|e| corrupt("brightness", e))?;
    Ok(Some(text))
}

/// Insert a row within a transaction.
pub(super) async fn insert(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
    point: &ErrorRow,
) -> Result<(), StoreError> {
    let error = serde_json::to_string(&point.error).map_err(|e| corrupt("error", e))?;
    sqlx::query(
        "INSERT INTO error_point (job, frame, samples, at_ms, core_us, error) \
         SELECT id, $2, $3, $4, $5, $6 FROM job WHERE id = $1 ON CONFLICT DO NOTHING",
    )
    .bind(job.0)
    .bind(i64::from(point.frame))
    .bind(big(point.samples))
    .bind(point.at_ms)
    .bind(big(point.core_us))
    .bind(error)
    .execute(&mut **tx)
    .await
    .attempt("insert error")?;
    Ok(())
}

fn folded(row: &AnyRow) -> Result<Folded, StoreError> {
    Ok(Folded {
        samples: count(row, "samples_folded")?,
        core_us: count(row, "core_us_folded")?,
    })
}

fn error_row(row: &AnyRow) -> Result<ErrorRow, StoreError> {
    Ok(ErrorRow {
        frame: small(row, "frame")?,
        samples: count(row, "samples")?,
        at_ms: int(row, "at_ms")?,
        core_us: count(row, "core_us")?,
        error: json(row, "error")?,
    })
}
