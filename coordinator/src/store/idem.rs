//! Idempotency keys: what a request that is repeated did the first time.

use super::error::{Attempt, StoreError};
use super::open::Store;
use super::rows::{hash, int};
use shearwater_shared::hash::ContentHash;
use shearwater_shared::job::JobId;
use sqlx::any::AnyRow;
use sqlx::{Any, Transaction};

/// A client's key, and the hash of the body it came with.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IdempotencyKey {
    /// The key, unique among all requests that take keys.
    pub key: String,
    /// blake3 of the body.
    pub body: ContentHash,
}

/// A key that is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Repetition {
    /// With the same body; it was about this job.
    Same(JobId),
    /// With another body; that one was about this job.
    OtherBody(JobId),
}

const KNOWN: &str = "SELECT body_hash, job FROM idem WHERE key = $1";

impl Store {
    /// What a key did before; `None` when it is new.
    ///
    /// # Errors
    /// The database failed.
    pub async fn repetition(&self, key: &IdempotencyKey) -> Result<Option<Repetition>, StoreError> {
        let row = sqlx::query(KNOWN)
            .bind(&key.key)
            .fetch_optional(&self.read)
            .await
            .attempt("read idempotency key")?;
        row.map(|row| compared(&row, key)).transpose()
    }
}

/// The same, within a transaction that goes on to do it.
pub(super) async fn known(
    tx: &mut Transaction<'static, Any>,
    key: &IdempotencyKey,
) -> Result<Option<Repetition>, StoreError> {
    let row = sqlx::query(KNOWN)
        .bind(&key.key)
        .fetch_optional(&mut **tx)
        .await
        .attempt("read idempotency key")?;
    row.map(|row| compared(&row, key)).transpose()
}

/// Remember what a key does, in the transaction that does it.
pub(super) async fn remember(
    tx: &mut Transaction<'static, Any>,
    key: &IdempotencyKey,
    job: JobId,
    now_ms: i64,
) -> Result<(), StoreError> {
    sqlx::query("INSERT INTO idem (key, body_hash, job, created_ms) VALUES ($1, $2, $3, $4)")
        .bind(&key.key)
        .bind(key.body.to_string())
        .bind(job.0)
        .bind(now_ms)
        .execute(&mut **tx)
        .await
        .attempt("store idempotency key")?;
    Ok(())
}

fn compared(row: &AnyRow, key: &IdempotencyKey) -> Result<Repetition, StoreError> {
    let job = JobId(int(row, "job")?);
    Ok(if hash(row, "body_hash")? == key.body {
        Repetition::Same(job)
    } else {
        Repetition::OtherBody(job)
    })
}
