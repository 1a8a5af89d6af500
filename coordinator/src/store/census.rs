//! How many there are of everything.

use super::error::{Attempt, StoreError, corrupt};
use super::open::Store;
use super::rows::{count, int};
use shearwater_shared::job::JobState;

/// The farm in numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Census {
    /// Jobs in each state.
    pub jobs: Vec<(JobState, u64)>,
    /// Units that nobody holds, of jobs that have not ended; as far as known, for a job
    /// that stops by its error.
    pub units_pending: u64,
    /// Units that workers hold.
    pub units_leased: u64,
    /// Units counted.
    pub units_done: u64,
    /// Workers heard of lately that may work.
    pub workers_present: u64,
    /// Workers heard of lately that get nothing.
    pub workers_quarantined: u64,
    /// Render threads of those that may work.
    pub threads: u64,
    /// Leases that workers hold.
    pub leases_open: u64,
    /// Counted runs that are to be compared.
    pub audits_open: u64,
    /// Counted results that are not folded yet.
    pub parts_unfolded: u64,
}

/// Jobs that have not ended: the same derivation as `farm::state`.
const LIVE: &str = "SELECT CAST(CASE WHEN paused_ms IS NOT NULL THEN 5 WHEN units_done > 0 THEN 1 \
     WHEN EXISTS (SELECT 1 FROM unit u WHERE u.job = job.id AND u.state = 1) THEN 1 \
     ELSE 0 END AS BIGINT) AS state, units_due, units_done FROM job WHERE finished_ms IS NULL";
/// All others, by an index of their own.
const ENDED: &str = "SELECT ended, count(*) AS jobs FROM job WHERE finished_ms IS NOT NULL \
     GROUP BY ended";
const UNITS: &str = "SELECT count(*) AS n FROM unit WHERE state = 1 \
     AND job IN (SELECT id FROM job WHERE finished_ms IS NULL)";
const WORKERS: &str = "SELECT refused, count(*) AS workers, \
     CAST(coalesce(sum(threads), 0) AS BIGINT) AS threads FROM (SELECT threads, \
     CAST(CASE WHEN quarantined_until_ms > $2 OR d.worker IS NOT NULL THEN 1 ELSE 0 END AS BIGINT) \
     AS refused FROM worker LEFT JOIN distrust d ON d.worker = instance \
     WHERE seen_ms >= $1) present GROUP BY refused";

impl Store {
    /// Count everything; workers that were heard of since `since_ms`.
    ///
    /// # Errors
    /// The database failed.
    pub async fn census(&self, since_ms: i64, now_ms: i64) -> Result<Census, StoreError> {
        let mut census = Census::default();
        let mut states = [0u64; 6];
        let mut due = 0u64;
        for row in sqlx::query(LIVE)
            .fetch_all(&self.read)
            .await
            .attempt("count live jobs")?
        {
            let state = usize::try_from(int(&row, "state")?).map_err(|e| corrupt("state", e))?;
            if let Some(jobs) = states.get_mut(state) {
                *jobs += 1;
            }
            due += count(&row, "units_due")?;
            census.units_done += count(&row, "units_done")?;
        }
        for row in sqlx::query(ENDED)
            .fetch_all(&self.read)
            .await
            .attempt("count ended jobs")?
        {
            let state = match int(&row, "ended")? {
                0 => 2,
                1 => 3,
                _ => 4,
            };
            if let Some(jobs) = states.get_mut(state) {
                *jobs += count(&row, "jobs")?;
            }
        }
        let names = [
            JobState::Queued,
            JobState::Running,
            JobState::Done,
            JobState::Cancelled,
            JobState::Failed,
            JobState::Paused,
        ];
        census.jobs = names.into_iter().zip(states).collect();
        census.units_leased = self.number(UNITS).await?;
        census.units_pending = due.saturating_sub(census.units_done + census.units_leased);
        self.count_workers(&mut census, since_ms, now_ms).await?;
        census.leases_open = self
            .number("SELECT count(*) AS n FROM lease WHERE closed = 0")
            .await?;
        census.audits_open = self.number("SELECT count(*) AS n FROM audit").await?;
        census.parts_unfolded = self
            .number("SELECT count(*) AS n FROM part WHERE object IS NOT NULL")
            .await?;
        Ok(census)
    }

    async fn count_workers(
        &self,
        census: &mut Census,
        since_ms: i64,
        now_ms: i64,
    ) -> Result<(), StoreError> {
        let rows = sqlx::query(WORKERS)
            .bind(since_ms)
            .bind(now_ms)
            .fetch_all(&self.read)
            .await
            .attempt("count workers")?;
        for row in &rows {
            let workers = count(row, "workers")?;
            if int(row, "refused")? == 0 {
                census.workers_present = workers;
                census.threads = count(row, "threads")?;
            } else {
                census.workers_quarantined = workers;
            }
        }
        Ok(())
    }

    async fn number(&self, sql: &'static str) -> Result<u64, StoreError> {
        let row = sqlx::query(sql)
            .fetch_one(&self.read)
            .await
            .attempt("count")?;
        count(&row, "n")
    }
}
