//! A job is deleted: at once for everybody who asks, its rows in small steps.

use super::error::{Attempt, StoreError};
use super::open::Store;
use super::rows::int;
use shearwater_shared::job::JobId;

/// Most rows that one transaction removes: some ten milliseconds, so that results
/// hardly wait behind it.
const STEP_ROWS: i64 = 2000;
/// Deletions that are looked at together.
const DELETIONS_MAX: i64 = 64;

macro_rules! some_of {
    ($table:literal, $key:literal) => {
        concat!(
            "DELETE FROM ",
            $table,
            " WHERE job = $1 AND (",
            $key,
            ") IN (SELECT ",
            $key,
            " FROM ",
            $table,
            " WHERE job = $1 LIMIT $2)"
        )
    };
}
const STEPS: [&str; 11] = [
    some_of!("unit", "frame, tile, block"),
    some_of!("part", "frame, tile, block0"),
    some_of!("tilefold", "frame, tile"),
    some_of!("error_point", "frame, samples"),
    some_of!("frame", "frame"),
    some_of!("lease", "id"),
    some_of!("failure", "frame, tile, block, worker"),
    some_of!("job_asset", "hash"),
    some_of!("webhook", "job"),
    some_of!("audit", "frame, tile, block0"),
    some_of!("job_log", "slot"),
];

impl Store {
    /// Forget a job; false when there is none. Whatever belongs to it goes by
    /// [`Store::delete_some`].
    ///
    /// # Errors
    /// The database failed; the job is as before.
    pub async fn delete_job(&self, id: JobId) -> Result<bool, StoreError> {
        let mut tx = self.begin().await?;
        // First the row that all transactions of a job take: nothing of it is
        // added once it is gone.
        for (statement, what) in [
            ("DELETE FROM job WHERE id = $1", "delete job"),
            ("INSERT INTO deletion (job) VALUES ($1)", "note deleted job"),
            ("DELETE FROM idem WHERE job = $1", "delete idempotency key"),
        ] {
            let done = sqlx::query(statement)
                .bind(id.0)
                .execute(&mut *tx)
                .await
                .attempt(what)?;
            if done.rows_affected() == 0 && what == "delete job" {
                return Ok(false);
            }
        }
        tx.commit().await.attempt("commit deletion")?;
        Ok(true)
    }

    /// Deleted jobs of which something is left.
    ///
    /// # Errors
    /// The database failed.
    pub async fn deletions(&self) -> Result<Vec<JobId>, StoreError> {
        sqlx::query("SELECT job FROM deletion ORDER BY job LIMIT $1")
            .bind(DELETIONS_MAX)
            .fetch_all(&self.read)
            .await
            .attempt("read deletions")?
            .iter()
            .map(|row| Ok(JobId(int(row, "job")?)))
            .collect()
    }

    /// Remove some rows of a deleted job; how many. With 0 only its objects are
    /// left.
    ///
    /// # Errors
    /// The database failed.
    pub async fn delete_some(&self, id: JobId) -> Result<u64, StoreError> {
        for statement in STEPS {
            let done = sqlx::query(statement)
                .bind(id.0)
                .bind(STEP_ROWS)
                .execute(&self.write)
                .await
                .attempt("delete rows")?;
            if done.rows_affected() > 0 {
                return Ok(done.rows_affected());
            }
        }
        Ok(0)
    }

    /// Nothing is left of a deleted job, its objects neither.
    ///
    /// # Errors
    /// The database failed.
    pub async fn deletion_done(&self, id: JobId) -> Result<(), StoreError> {
        sqlx::query("DELETE FROM deletion WHERE job = $1")
            .bind(id.0)
            .execute(&self.write)
            .await
            .attempt("end deletion")?;
        Ok(())
    }
}
