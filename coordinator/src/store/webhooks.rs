//! Whom the end of a job is told. That there is something to tell follows from the
//! job's own row: no end can be forgotten between two statements.

use super::error::{Attempt, StoreError, corrupt};
use super::open::Store;
use super::rows::{int, optional_text, small, text};
use crate::farm::{TRIES_MS, Told, ahead_ms_max};
use shearwater_shared::job::JobId;
use sqlx::any::AnyRow;
use sqlx::{Any, Row, Transaction};

/// Whom to tell, as submitted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NewWebhook {
    /// Where to.
    pub url: String,
    /// The job's own secret; the farm's without.
    pub secret: Option<String>,
}

/// A job's webhook.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WebhookRow {
    /// Where to.
    pub url: String,
    /// How far it has come.
    pub told: Told,
    /// Tries at that end.
    pub attempts: u32,
    /// Status of the last answer.
    pub last_status: Option<u16>,
    /// Why the last try failed.
    pub last_error: Option<String>,
    /// When it was taken.
    pub delivered_ms: Option<i64>,
}

/// An end that nobody took yet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DueWebhook {
    /// Of which job.
    pub job: JobId,
    /// Where to.
    pub url: String,
    /// The job's own secret.
    pub secret: Option<String>,
    /// When the job ended: with its number the message's name.
    pub finished_ms: i64,
    /// Which end the tries so far were about.
    ended_ms: i64,
    /// How many there were.
    attempts: u32,
}

impl DueWebhook {
    /// Number of the next try at this end, from 1.
    #[must_use]
    pub const fn attempt(&self) -> u32 {
        if self.ended_ms == self.finished_ms {
            self.attempts.saturating_add(1)
        } else {
            1
        }
    }
}

impl Store {
    /// A job's webhook, if it has one.
    ///
    /// # Errors
    /// The database failed.
    pub async fn webhook(&self, job: JobId) -> Result<Option<WebhookRow>, StoreError> {
        let row = sqlx::query(
            "SELECT url, ended_ms, state, attempts, last_status, last_error, delivered_ms \
             FROM webhook WHERE job = $1",
        )
        .bind(job.0)
        .fetch_optional(&self.read)
        .await
        .attempt("read webhook")?;
        row.map(|row| webhook_row(&row)).transpose()
    }

    /// At most `limit` ends that should be told now, the earliest first.
    ///
    /// # Errors
    /// The database failed.
    pub async fn due_webhooks(
        &self,
        now_ms: i64,
        limit: u32,
    ) -> Result<Vec<DueWebhook>, StoreError> {
        sqlx::query(
            "SELECT w.job, w.url, w.secret, w.ended_ms, w.attempts, j.finished_ms \
             FROM job j JOIN webhook w ON w.job = j.id WHERE j.finished_ms > $1 \
             AND (w.ended_ms <> j.finished_ms OR (w.state = 0 \
             AND (w.next_ms <= $2 OR w.next_ms > $3))) ORDER BY j.finished_ms LIMIT $4",
        )
        .bind(now_ms.saturating_sub(TRIES_MS))
        .bind(now_ms)
        .bind(now_ms.saturating_add(ahead_ms_max()))
        .bind(i64::from(limit))
        .fetch_all(&self.read)
        .await
        .attempt("look for webhooks")?
        .iter()
        .map(due_row)
        .collect()
    }

    /// Take a try for oneself; false when another coordinator has it. Nobody else
    /// tries before `next_ms`, even if this process is gone by then.
    ///
    /// # Errors
    /// The database failed.
    pub async fn claim_webhook(&self, due: &DueWebhook, next_ms: i64) -> Result<bool, StoreError> {
        let claimed = sqlx::query(
            "UPDATE webhook SET ended_ms = $2, attempts = $3, next_ms = $4, state = 0, \
             delivered_ms = NULL WHERE job = $1 AND ended_ms = $5 AND attempts = $6 \
             AND (ended_ms <> $2 OR state = 0) \
             AND EXISTS (SELECT 1 FROM job WHERE id = $1 AND finished_ms = $2)",
        )
        .bind(due.job.0)
        .bind(due.finished_ms)
        .bind(i64::from(due.attempt()))
        .bind(next_ms)
        .bind(due.ended_ms)
        .bind(i64::from(due.attempts))
        .execute(&self.write)
        .await
        .attempt("claim webhook")?;
        Ok(claimed.rows_affected() == 1)
    }

    /// The receiver took what was told.
    ///
    /// # Errors
    /// The database failed; it will be told again.
    pub async fn webhook_taken(
        &self,
        due: &DueWebhook,
        status: u16,
        now_ms: i64,
    ) -> Result<(), StoreError> {
        let mut tx = self.begin().await?;
        sqlx::query(
            "UPDATE webhook SET state = 1, delivered_ms = $3, last_status = $4, last_error = NULL \
             WHERE job = $1 AND ended_ms = $2 AND state = 0",
        )
        .bind(due.job.0)
        .bind(due.finished_ms)
        .bind(now_ms)
        .bind(i64::from(status))
        .execute(&mut *tx)
        .await
        .attempt("close webhook")?;
        changed(tx, due.job).await
    }

    /// A try failed; the next is at `next_ms`.
    ///
    /// # Errors
    /// The database failed; the next try is when this one's time is over.
    pub async fn webhook_failed(
        &self,
        due: &DueWebhook,
        status: Option<u16>,
        error: &str,
        next_ms: i64,
    ) -> Result<(), StoreError> {
        let mut tx = self.begin().await?;
        sqlx::query(
            "UPDATE webhook SET next_ms = $4, last_status = $5, last_error = $6 \
             WHERE job = $1 AND ended_ms = $2 AND attempts = $3 AND state = 0",
        )
        .bind(due.job.0)
        .bind(due.finished_ms)
        .bind(i64::from(due.attempt()))
        .bind(next_ms)
        .bind(status.map(i64::from))
        .bind(error)
        .execute(&mut *tx)
        .await
        .attempt("note failed webhook")?;
        changed(tx, due.job).await
    }
}

/// Whoever watches the job sees it.
async fn changed(mut tx: Transaction<'static, Any>, job: JobId) -> Result<(), StoreError> {
    sqlx::query("UPDATE job SET rev = rev + 1 WHERE id = $1")
        .bind(job.0)
        .execute(&mut *tx)
        .await
        .attempt("count change")?;
    tx.commit().await.attempt("commit webhook")
}

/// Note whom to tell, in the transaction that makes the job.
pub(super) async fn insert(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
    new: &NewWebhook,
) -> Result<(), StoreError> {
    sqlx::query("INSERT INTO webhook (job, url, secret) VALUES ($1, $2, $3)")
        .bind(job.0)
        .bind(&new.url)
        .bind(new.secret.clone())
        .execute(&mut **tx)
        .await
        .attempt("insert webhook")?;
    Ok(())
}

fn webhook_row(row: &AnyRow) -> Result<WebhookRow, StoreError> {
    let number = |column: &'static str| row.try_get::<Option<i64>, _>(column).attempt(column);
    let status = number("last_status")?.map(u16::try_from).transpose();
    Ok(WebhookRow {
        url: text(row, "url")?,
        told: Told {
            ended_ms: int(row, "ended_ms")?,
            taken: int(row, "state")? == 1,
        },
        attempts: small(row, "attempts")?,
        last_status: status.map_err(|e| corrupt("last_status", e))?,
        last_error: optional_text(row, "last_error")?,
        delivered_ms: number("delivered_ms")?,
    })
}

fn due_row(row: &AnyRow) -> Result<DueWebhook, StoreError> {
    Ok(DueWebhook {
        job: JobId(int(row, "job")?),
        url: text(row, "url")?,
        secret: optional_text(row, "secret")?,
        finished_ms: int(row, "finished_ms")?,
        ended_ms: int(row, "ended_ms")?,
        attempts: small(row, "attempts")?,
    })
}
