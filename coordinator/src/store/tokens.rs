//! Access tokens: hashes, never the tokens.

use super::error::{Attempt, StoreError, corrupt};
use super::open::Store;
use super::rows::{int, optional_text, text};
use crate::access::Role;
use shearwater_shared::job::JobId;
use sqlx::Row;
use sqlx::any::AnyRow;

/// Most tokens of a store; one for each worker of a large farm.
const TOKENS_MAX: i64 = 10_000;
/// How long an ended token is listed: long enough to find out later who had
/// it.
const ENDED_KEPT_MS: i64 = 90 * 24 * 3600 * 1000;

/// A token as stored.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TokenRow {
    /// Public part: eight hexadecimal digits.
    pub id: String,
    /// blake3 of the whole token, in hexadecimal digits.
    pub hash: String,
    /// What it is for.
    pub role: Role,
    /// Name for people; may be empty.
    pub name: String,
    /// When it was made.
    pub created_ms: i64,
    /// When it ends by itself.
    pub expires_ms: Option<i64>,
    /// When it was revoked.
    pub revoked_ms: Option<i64>,
}

impl Store {
    /// Store a token; false when its id is taken or the store has its most. Forgets
    /// those that ended long ago; as one is added, a store never loses its last.
    ///
    /// # Errors
    /// The database failed; nothing was stored.
    pub async fn add_token(&self, token: &TokenRow) -> Result<bool, StoreError> {
        let mut tx = self.begin().await?;
        sqlx::query("DELETE FROM token WHERE COALESCE(revoked_ms, expires_ms) < $1")
            .bind(token.created_ms.saturating_sub(ENDED_KEPT_MS))
            .execute(&mut *tx)
            .await
            .attempt("forget tokens")?;
        let row = sqlx::query("SELECT count(*) AS tokens FROM token")
            .fetch_one(&mut *tx)
            .await
            .attempt("count tokens")?;
        if int(&row, "tokens")? >= TOKENS_MAX {
            return Ok(false);
        }
        let added = sqlx::query(
            "INSERT INTO token (id, hash, role, name, created_ms, expires_ms) \
             VALUES ($1, $2, $3, $4, $5, $6) ON CONFLICT (id) DO NOTHING",
        )
        .bind(&token.id)
        .bind(&token.hash)
        .bind(token.role.name())
        .bind(&token.name)
        .bind(token.created_ms)
        .bind(token.expires_ms)
        .execute(&mut *tx)
        .await
        .attempt("add token")?;
        if added.rows_affected() == 0 {
            return Ok(false);
        }
        tx.commit().await.attempt("commit token")?;
        Ok(true)
    }

    /// A token by its public part.
    ///
    /// # Errors
    /// The database failed.
    pub async fn token(&self, id: &str) -> Result<Option<TokenRow>, StoreError> {
        sqlx::query(
            "SELECT id, hash, role, name, created_ms, expires_ms, revoked_ms FROM token \
             WHERE id = $1",
        )
        .bind(id)
        .fetch_optional(&self.read)
        .await
        .attempt("read token")?
        .as_ref()
        .map(token_row)
        .transpose()
    }

    /// All tokens, oldest first, ended ones among them.
    ///
    /// # Errors
    /// The database failed.
    pub async fn tokens(&self) -> Result<Vec<TokenRow>, StoreError> {
        sqlx::query(
            "SELECT id, hash, role, name, created_ms, expires_ms, revoked_ms FROM token \
             ORDER BY created_ms, id LIMIT $1",
        )
        .bind(TOKENS_MAX)
        .fetch_all(&self.read)
        .await
        .attempt("read tokens")?
        .iter()
        .map(token_row)
        .collect()
    }

    /// Whether the store ever had a token.
    ///
    /// # Errors
    /// The database failed.
    pub async fn has_token(&self) -> Result<bool, StoreError> {
        let row = sqlx::query("SELECT id FROM token LIMIT 1")
            .fetch_optional(&self.read)
            .await
            .attempt("look for tokens")?;
        Ok(row.is_some())
    }

    /// End a token; false when there is none. One that has ended stays as it is.
    ///
    /// # Errors
    /// The database failed.
    pub async fn revoke_token(&self, id: &str, now_ms: i64) -> Result<bool, StoreError> {
        let known =
            sqlx::query("UPDATE token SET revoked_ms = COALESCE(revoked_ms, $2) WHERE id = $1")
                .bind(id)
                .bind(now_ms)
                .execute(&self.write)
                .await
                .attempt("revoke token")?;
        Ok(known.rows_affected() > 0)
    }

    /// The public part of the token that submitted a job, if one did; `None` when
    /// there is no such job.
    ///
    /// # Errors
    /// The database failed.
    pub async fn job_owner(&self, id: JobId) -> Result<Option<Option<String>>, StoreError> {
        sqlx::query("SELECT owner FROM job WHERE id = $1")
            .bind(id.0)
            .fetch_optional(&self.read)
            .await
            .attempt("read owner")?
            .map(|row| optional_text(&row, "owner"))
            .transpose()
    }
}

fn token_row(row: &AnyRow) -> Result<TokenRow, StoreError> {
    let time = |column: &'static str| row.try_get::<Option<i64>, _>(column).attempt(column);
    Ok(TokenRow {
        id: text(row, "id")?,
        hash: text(row, "hash")?,
        role: text(row, "role")?.parse().map_err(|e| corrupt("role", e))?,
        name: text(row, "name")?,
        created_ms: int(row, "created_ms")?,
        expires_ms: time("expires_ms")?,
        revoked_ms: time("revoked_ms")?,
    })
}
