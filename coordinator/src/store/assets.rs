//! Which assets are stored.

use super::error::{Attempt, StoreError};
use super::open::Store;
use super::rows::{big, count};
use shearwater_shared::hash::ContentHash;

impl Store {
    /// Note an asset whose object is durable.
    ///
    /// # Errors
    /// The database failed.
    pub async fn add_asset(
        &self,
        hash: &ContentHash,
        size: u64,
        now_ms: i64,
    ) -> Result<(), StoreError> {
        sqlx::query(
            "INSERT INTO asset (hash, size, created_ms) VALUES ($1, $2, $3) \
             ON CONFLICT (hash) DO NOTHING",
        )
        .bind(hash.to_string())
        .bind(big(size))
        .bind(now_ms)
        .execute(&self.write)
        .await
        .attempt("note asset")?;
        Ok(())
    }

    /// The size of an asset; `None` when it is not stored.
    ///
    /// # Errors
    /// The database failed.
    pub async fn asset_size(&self, hash: &ContentHash) -> Result<Option<u64>, StoreError> {
        sqlx::query("SELECT size FROM asset WHERE hash = $1")
            .bind(hash.to_string())
            .fetch_optional(&self.read)
            .await
            .attempt("read asset")?
            .map(|row| count(&row, "size"))
            .transpose()
    }
}
