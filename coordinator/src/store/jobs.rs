//! Jobs: read, list, stop, delete.

use super::error::{Attempt, StoreError};
use super::log::{Event, log};
use super::open::Store;
use super::rows::{JobRow, count, failure_code, int, job_columns, job_row};
use crate::farm::LiveJob;
use shearwater_shared::api::{FailureKind, LogKind};
use shearwater_shared::job::{JobId, JobState};

/// Jobs that one lease request looks at: those of the highest priority, and of these the
/// ones that were served longest ago.
const LIVE_JOBS_MAX: i64 = 64;

/// Which jobs a listing shows.
#[derive(Clone, Copy, Debug)]
pub struct JobFilter {
    /// Only jobs with smaller numbers.
    pub below: i64,
    /// Only jobs in this state.
    pub state: Option<JobState>,
    /// At most so many.
    pub limit: u32,
}

impl Store {
    /// One job.
    ///
    /// # Errors
    /// The database failed.
    pub async fn job(&self, id: JobId) -> Result<Option<JobRow>, StoreError> {
        sqlx::query(concat!(
            "SELECT ",
            job_columns!(),
            " FROM job WHERE id = $1"
        ))
        .bind(id.0)
        .fetch_optional(&self.read)
        .await
        .attempt("read job")?
        .map(|row| job_row(&row))
        .transpose()
    }

    /// Only the job's revision; cheap enough to be asked often.
    ///
    /// # Errors
    /// The database failed.
    pub async fn job_rev(&self, id: JobId) -> Result<Option<i64>, StoreError> {
        sqlx::query("SELECT rev FROM job WHERE id = $1")
            .bind(id.0)
            .fetch_optional(&self.read)
            .await
            .attempt("read revision")?
            .map(|row| int(&row, "rev"))
            .transpose()
    }

    /// Jobs, newest first.
    ///
    /// # Errors
    /// The database failed.
    pub async fn jobs(&self, filter: &JobFilter) -> Result<Vec<JobRow>, StoreError> {
        let state = match filter.state {
            None => -1,
            Some(JobState::Queued) => 0,
            Some(JobState::Running) => 1,
            Some(JobState::Done) => 2,
            Some(JobState::Cancelled) => 3,
            Some(JobState::Failed) => 4,
            Some(JobState::Paused) => 5,
        };
        // The same derivation as farm::state, for filtering.
        sqlx::query(concat!(
            "SELECT ",
            job_columns!(),
            " FROM job WHERE id < $1 AND ($2 = -1 OR $2 = CASE WHEN ended = 1 THEN 3 \
             WHEN ended >= 2 THEN 4 WHEN frames_done = frames THEN 2 \
             WHEN paused_ms IS NOT NULL THEN 5 \
             WHEN units_done > 0 THEN 1 \
             WHEN EXISTS (SELECT 1 FROM unit u WHERE u.job = job.id AND u.state = 1) THEN 1 \
             ELSE 0 END) ORDER BY id DESC LIMIT $3"
        ))
        .bind(filter.below)
        .bind(i64::from(state))
        .bind(i64::from(filter.limit))
        .fetch_all(&self.read)
        .await
        .attempt("list jobs")?
        .iter()
        .map(job_row)
        .collect()
    }

    /// Jobs that have not ended, are not paused, and that the numeric build `build` may
    /// render: those of the highest priority.
    ///
    /// # Errors
    /// The database failed.
    pub async fn live_jobs(&self, build: &str) -> Result<Vec<LiveJob>, StoreError> {
        sqlx::query(
            "SELECT id, priority, units_due, units_done, samples_total, samples_done, core_us, \
             served, (SELECT count(*) FROM unit WHERE unit.job = job.id \
             AND unit.state = 1) AS leased FROM job WHERE finished_ms IS NULL \
             AND paused_ms IS NULL AND (build IS NULL OR build = $2) \
             ORDER BY priority DESC, served, id LIMIT $1",
        )
        .bind(LIVE_JOBS_MAX)
        .bind(build)
        .fetch_all(&self.read)
        .await
        .attempt("read live jobs")?
        .iter()
        .map(|row| {
            Ok(LiveJob {
                id: JobId(int(row, "id")?),
                priority: i32::try_from(int(row, "priority")?).unwrap_or(0),
                units_total: count(row, "units_due")?,
                units_done: count(row, "units_done")?,
                units_leased: count(row, "leased")?,
                samples_total: count(row, "samples_total")?,
                samples_done: count(row, "samples_done")?,
                core_us: count(row, "core_us")?,
                served: int(row, "served")?,
            })
        })
        .collect()
    }

    /// Stop a job for its user; false when it had ended or does not exist.
    ///
    /// # Errors
    /// The database failed.
    pub async fn cancel(&self, id: JobId, now_ms: i64) -> Result<bool, StoreError> {
        self.end(id, 1, None, now_ms).await
    }

    /// Stop a job that cannot be rendered; false when it had ended.
    ///
    /// # Errors
    /// The database failed.
    pub async fn fail_job(
        &self,
        id: JobId,
        kind: Option<FailureKind>,
        reason: &str,
        now_ms: i64,
    ) -> Result<bool, StoreError> {
        self.end(id, failure_code(kind), Some(reason), now_ms).await
    }

    async fn end(
        &self,
        id: JobId,
        ended: i64,
        failure: Option<&str>,
        now_ms: i64,
    ) -> Result<bool, StoreError> {
        let mut tx = self.begin().await?;
        let ended = sqlx::query(
            "UPDATE job SET ended = $2, failure = $3, finished_ms = $4, rev = rev + 1 \
             WHERE id = $1 AND finished_ms IS NULL",
        )
        .bind(id.0)
        .bind(ended)
        .bind(failure.map(str::to_owned))
        .bind(now_ms)
        .execute(&mut *tx)
        .await
        .attempt("end job")?
        .rows_affected();
        sqlx::query("UPDATE lease SET closed = 1 WHERE job = $1 AND closed = 0")
            .bind(id.0)
            .execute(&mut *tx)
            .await
            .attempt("close leases")?;
        if ended == 0 {
            return Ok(false);
        }
        let event = Event::new(id, LogKind::Ended, now_ms);
        let text = Some(failure.unwrap_or("cancelled"));
        log(&mut tx, &Event { text, ..event }).await?;
        tx.commit().await.attempt("commit end of job")?;
        Ok(true)
    }
}
