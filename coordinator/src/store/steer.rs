//! What its user does to a live or failed job: pause, resume, try again, priority.

use super::error::{Attempt, StoreError};
use super::log::{Event, log};
use super::open::Store;
use shearwater_shared::api::LogKind;
use shearwater_shared::job::JobId;

impl Store {
    /// Hand out nothing of the job until it is resumed; false when it had ended, was
    /// paused or does not exist. What is leased may still come.
    ///
    /// # Errors
    /// The database failed; the job is as before.
    pub async fn pause(&self, id: JobId, now_ms: i64) -> Result<bool, StoreError> {
        let pause = "UPDATE job SET paused_ms = $2, rev = rev + 1 \
                     WHERE id = $1 AND finished_ms IS NULL AND paused_ms IS NULL";
        self.steer(id, now_ms, (&[], pause, &[]), "paused").await
    }

    /// Go on with a paused job; false when it was not. The time of the pause counts
    /// neither for its time stop nor as time that it took.
    ///
    /// # Errors
    /// The database failed; the job is as before.
    pub async fn resume(&self, id: JobId, now_ms: i64) -> Result<bool, StoreError> {
        let resume = "UPDATE job SET timed_from_ms = timed_from_ms + ($2 - paused_ms), \
                      first_lease_ms = first_lease_ms + ($2 - paused_ms), paused_ms = NULL, \
                      rev = rev + 1 WHERE id = $1 AND paused_ms IS NOT NULL";
        self.steer(id, now_ms, (&[], resume, &[]), "resumed").await
    }

    /// Try a job again that has failed, or that is done with results of a worker that
    /// was found to be wrong since; false for any other. What is counted stays;
    /// failures are forgotten.
    ///
    /// # Errors
    /// The database failed; the job is as before.
    pub async fn retry(&self, id: JobId, now_ms: i64) -> Result<bool, StoreError> {
        let open = "UPDATE job SET ended = 0, failure = NULL, paused_ms = NULL, \
                    first_lease_ms = first_lease_ms + ($2 - coalesce(last_result_ms, $2)), \
                    timed_from_ms = timed_from_ms + ($2 - finished_ms), \
                    finished_ms = NULL, rev = rev + 1 WHERE id = $1 AND (ended >= 2 OR (ended = 0 \
                    AND finished_ms IS NOT NULL AND EXISTS (SELECT 1 FROM part p \
                    JOIN distrust d ON d.worker = p.worker WHERE p.job = job.id)))";
        let units = "UPDATE unit SET state = 0, lease = 0 WHERE job = $1 AND state = 1";
        let then = [
            "DELETE FROM failure WHERE job = $1",
            "UPDATE audit SET lease = 0 WHERE job = $1",
        ];
        let statements = (&[units][..], open, &then[..]);
        self.steer(id, now_ms, statements, "tried again").await
    }

    /// Give the job another priority; false when it has it already or does not exist.
    ///
    /// # Errors
    /// The database failed; the job is as before.
    pub async fn set_priority(
        &self,
        id: JobId,
        priority: i32,
        now_ms: i64,
    ) -> Result<bool, StoreError> {
        let mut tx = self.begin().await?;
        let changed = sqlx::query(
            "UPDATE job SET priority = $2, rev = rev + 1 WHERE id = $1 AND priority <> $2",
        )
        .bind(id.0)
        .bind(i64::from(priority))
        .execute(&mut *tx)
        .await
        .attempt("change priority")?;
        if changed.rows_affected() != 1 {
            return Ok(false);
        }
        let text = format!("priority {priority}");
        let event = Event::new(id, LogKind::Changed, now_ms);
        let text = Some(text.as_str());
        log(&mut tx, &Event { text, ..event }).await?;
        tx.commit().await.attempt("commit priority")?;
        Ok(true)
    }

    // First its units, then the job, then the rest. The change of the job sees it as $1
    // and the time as $2, the others the job alone.
    async fn steer(
        &self,
        id: JobId,
        now_ms: i64,
        (units, change, then): (&[&'static str], &'static str, &[&'static str]),
        text: &'static str,
    ) -> Result<bool, StoreError> {
        let mut tx = self.begin().await?;
        for statement in units {
            let done = sqlx::query(*statement).bind(id.0).execute(&mut *tx).await;
            done.attempt("change job's units")?;
        }
        let changed = sqlx::query(change).bind(id.0).bind(now_ms);
        let changed = changed.execute(&mut *tx).await.attempt("change job")?;
        if changed.rows_affected() != 1 {
            return Ok(false);
        }
        for statement in then {
            let done = sqlx::query(*statement).bind(id.0).execute(&mut *tx).await;
            done.attempt("change what is the job's")?;
        }
        let event = Event::new(id, LogKind::Changed, now_ms);
        let text = Some(text);
        log(&mut tx, &Event { text, ..event }).await?;
        tx.commit().await.attempt("commit change")?;
        Ok(true)
    }
}
