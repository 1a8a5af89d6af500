//! What nobody needs any more.

use super::error::{Attempt, StoreError};
use super::open::Store;

/// How long an idempotency key is remembered: a day, the custom.
const IDEMPOTENCY_MS: i64 = 24 * 3600 * 1000;
/// How long ended leases and silent workers are remembered: a day.
const HISTORY_MS: i64 = 24 * 3600 * 1000;
/// How long it is remembered who computed wrongly: longer than any process of a worker
/// lasts, and than any clock is ahead.
const DISTRUST_MS: i64 = 90 * HISTORY_MS;

impl Store {
    /// Whether any row names this object.
    ///
    /// # Errors
    /// The database failed.
    pub async fn names_object(&self, object: &str) -> Result<bool, StoreError> {
        let row = sqlx::query(
            "SELECT object FROM part WHERE object = $1 UNION ALL \
             SELECT object FROM tilefold WHERE object = $1 LIMIT 1",
        )
        .bind(object)
        .fetch_optional(&self.read)
        .await
        .attempt("look for object")?;
        Ok(row.is_some())
    }

    /// Forget old idempotency keys, ended leases and silent workers.
    ///
    /// # Errors
    /// The database failed.
    pub async fn purge(&self, now_ms: i64) -> Result<(), StoreError> {
        for (statement, age_ms) in [
            ("DELETE FROM idem WHERE created_ms < $1", IDEMPOTENCY_MS),
            (
                "DELETE FROM lease WHERE closed = 1 AND until_ms < $1",
                HISTORY_MS,
            ),
            ("DELETE FROM worker WHERE seen_ms < $1", HISTORY_MS),
            // A coordinator's clock was ahead: else they would stay until that time comes.
            ("UPDATE asset SET used_ms = $1 - 1 WHERE used_ms > $1", 0),
            // Instances are never used again; what they delivered must stay marked.
            (
                "DELETE FROM distrust WHERE at_ms < $1 \
                 AND NOT EXISTS (SELECT 1 FROM worker w WHERE w.instance = distrust.worker) \
                 AND NOT EXISTS (SELECT 1 FROM part p WHERE p.worker = distrust.worker)",
                DISTRUST_MS,
            ),
        ] {
            sqlx::query(statement)
                .bind(now_ms.saturating_sub(age_ms))
                .execute(&self.write)
                .await
                .attempt("purge")?;
        }
        Ok(())
    }
}
