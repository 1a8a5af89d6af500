//! Which assets are stored.

use super::error::{Attempt, StoreError};
use super::open::Store;
use super::rows::{big, count};
use shearwater_shared::hash::ContentHash;

impl Store {
    /// Note an asset whose object is durable; false when the one of before is just
    /// being removed, and the object with it.
    ///
    /// # Errors
    /// The database failed.
    pub async fn add_asset(
        &self,
        hash: &ContentHash,
        size: u64,
        now_ms: i64,
    ) -> Result<bool, StoreError> {
        let done = sqlx::query(
            "INSERT INTO asset (hash, size, created_ms, used_ms) VALUES ($1, $2, $3, $3) \
             ON CONFLICT (hash) DO UPDATE SET used_ms = $3 WHERE asset.doomed = 0",
        )
        .bind(hash.to_string())
        .bind(big(size))
        .bind(now_ms)
        .execute(&self.write)
        .await
        .attempt("note asset")?;
        Ok(done.rows_affected() == 1)
    }

    /// The size of an asset; `None` when it is not stored.
    ///
    /// # Errors
    /// The database failed.
    pub async fn asset_size(&self, hash: &ContentHash) -> Result<Option<u64>, StoreError> {
        sqlx::query("SELECT size FROM asset WHERE hash = $1 AND doomed = 0")
            .bind(hash.to_string())
            .fetch_optional(&self.read)
            .await
            .attempt("read asset")?
            .map(|row| count(&row, "size"))
            .transpose()
    }
}
