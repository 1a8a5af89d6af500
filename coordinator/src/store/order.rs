//! In which order a transaction takes its rows.
//!
//! PostgreSQL locks row by row, and two transactions that want each other's rows
//! cost a second and one of them. So every transaction of a job takes its rows in
//! one order: **units, then the job, then everything else** (counters, frames,
//! tiles, parts, workers, leases). Units may be waited for only before the job's
//! row is held; a claim skips those that others hold. SQLite has one lock and
//! does not care.

use super::error::{Attempt, StoreError};
use shearwater_shared::job::JobId;
use sqlx::{Any, Transaction};

/// Take the job's row, counting a change; false when there is no such job.
pub(super) async fn lock_job(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
) -> Result<bool, StoreError> {
    let done = sqlx::query("UPDATE job SET rev = rev + 1 WHERE id = $1")
        .bind(job.0)
        .execute(&mut **tx)
        .await
        .attempt("take job")?;
    Ok(done.rows_affected() == 1)
}
