//! How many jobs wait or run.

use super::error::{Attempt, StoreError};
use super::open::Store;
use super::rows::count;

/// Jobs that have not ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Queued {
    /// All of them.
    pub all: u64,
    /// Those of one token.
    pub own: u64,
}

impl Store {
    /// Jobs that have not ended, and how many of them were submitted with the token
    /// `owner`.
    ///
    /// # Errors
    /// The database failed.
    pub async fn queued(&self, owner: Option<&str>) -> Result<Queued, StoreError> {
        let row = sqlx::query(
            "SELECT count(*) AS jobs, \
             CAST(COALESCE(SUM(CASE WHEN owner = $1 THEN 1 ELSE 0 END), 0) AS BIGINT) AS own \
             FROM job WHERE finished_ms IS NULL",
        )
        .bind(owner)
        .fetch_one(&self.read)
        .await
        .attempt("count queued jobs")?;
        Ok(Queued {
            all: count(&row, "jobs")?,
            own: count(&row, "own")?,
        })
    }
}
