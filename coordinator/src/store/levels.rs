//! The passes of an error stop: what a decision sees, and what follows from it.

use super::error::{Attempt, StoreError, corrupt};
use super::open::Store;
use super::order::lock_job;
use super::rows::{big, count, int, small, text};
use shearwater_shared::film::TileError;
use shearwater_shared::job::JobId;
use shearwater_shared::plan::{Plan, Run};
use sqlx::{Any, Transaction};

/// A frame between two passes: every unit that is due is counted and folded.
#[derive(Clone, Debug, PartialEq)]
pub struct PassState {
    /// Passes that were decided about.
    pub pass: i64,
    /// Units that are withheld, since the time is up.
    pub withheld: u64,
    /// Every tile, in order: blocks that it has, and its error with them.
    pub tiles: Vec<(u32, TileError)>,
}

/// A decision: these runs are rendered next.
#[derive(Clone, Debug)]
pub struct NextPass {
    /// Job.
    pub job: JobId,
    /// Frame.
    pub frame: u32,
    /// Passes that were decided about before.
    pub pass: i64,
    /// `extended` of the job that was decided by.
    pub extended: i64,
    /// For each tile that goes on, the blocks that it gets.
    pub runs: Vec<Run>,
}

impl Store {
    /// What the decision about a frame sees; `None` when there is no such frame or
    /// a unit of it is due.
    ///
    /// # Errors
    /// The database failed.
    pub async fn pass_state(
        &self,
        job: JobId,
        frame: u32,
    ) -> Result<Option<PassState>, StoreError> {
        let row = sqlx::query(
            "SELECT pass, (SELECT count(*) FROM unit u WHERE u.job = $1 AND u.frame = $2 \
             AND u.state = 3) AS withheld FROM frame \
             WHERE job = $1 AND frame = $2 AND units_done >= units_due",
        )
        .bind(job.0)
        .bind(i64::from(frame))
        .fetch_optional(&self.read)
        .await
        .attempt("read pass")?;
        let Some(row) = row else { return Ok(None) };
        let rows = sqlx::query(
            "SELECT tile, blocks, error FROM tilefold WHERE job = $1 AND frame = $2 \
             AND error IS NOT NULL ORDER BY tile",
        )
        .bind(job.0)
        .bind(i64::from(frame))
        .fetch_all(&self.read)
        .await
        .attempt("read tiles")?;
        let tiles = rows.iter().map(|row| {
            let error = serde_json::from_str(&text(row, "error")?);
            let error = error.map_err(|e| corrupt("tile error", e))?;
            Ok((small(row, "blocks")?, error))
        });
        Ok(Some(PassState {
            pass: int(&row, "pass")?,
            withheld: count(&row, "withheld")?,
            tiles: tiles.collect::<Result<_, StoreError>>()?,
        }))
    }

    /// Make the units of the next pass; false when another was faster or the job
    /// has changed.
    ///
    /// # Errors
    /// The database failed; the frame is as before.
    pub async fn next_pass(&self, next: &NextPass, plan: &Plan) -> Result<bool, StoreError> {
        let mut tx = self.begin().await?;
        lock_job(&mut tx, next.job).await?;
        // Whatever could change the decision changes one of these.
        let mine = sqlx::query(
            "UPDATE frame SET pass = pass + 1 WHERE job = $1 AND frame = $2 AND pass = $3 \
             AND film_hash IS NULL AND units_done >= units_due AND EXISTS (SELECT 1 FROM job \
             WHERE id = $1 AND finished_ms IS NULL AND extended = $4)",
        )
        .bind(next.job.0)
        .bind(i64::from(next.frame))
        .bind(next.pass)
        .bind(next.extended)
        .execute(&mut *tx)
        .await
        .attempt("take next pass")?;
        if mine.rows_affected() != 1 {
            return Ok(false);
        }
        for run in &next.runs {
            make_units(&mut tx, next.job, run).await?;
        }
        let units = next
            .runs
            .iter()
            .map(|run| u64::from(run.block1 - run.block0));
        let samples = next.runs.iter().map(|run| plan.run_samples(run));
        add_due(&mut tx, next, units.sum(), samples.sum()).await?;
        tx.commit().await.attempt("commit next pass")?;
        Ok(true)
    }
}

/// The units of one run, of which there are none yet.
async fn make_units(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
    run: &Run,
) -> Result<(), StoreError> {
    let at = |sql: &'static str| {
        sqlx::query(sql)
            .bind(job.0)
            .bind(i64::from(run.frame))
            .bind(i64::from(run.tile))
    };
    at(
        "WITH RECURSIVE u(n) AS (SELECT CAST($4 AS BIGINT) UNION ALL SELECT n + 1 FROM u \
         WHERE n + 1 < $5) INSERT INTO unit (job, frame, tile, block) \
         SELECT $1, $2, $3, n FROM u",
    )
    .bind(i64::from(run.block0))
    .bind(i64::from(run.block1))
    .execute(&mut **tx)
    .await
    .attempt("insert units")?;
    at("UPDATE tilefold SET due = due + $4 WHERE job = $1 AND frame = $2 AND tile = $3")
        .bind(i64::from(run.block1 - run.block0))
        .execute(&mut **tx)
        .await
        .attempt("count tile's units")?;
    Ok(())
}

async fn add_due(
    tx: &mut Transaction<'static, Any>,
    next: &NextPass,
    units: u64,
    samples: u64,
) -> Result<(), StoreError> {
    sqlx::query("UPDATE frame SET units_due = units_due + $3 WHERE job = $1 AND frame = $2")
        .bind(next.job.0)
        .bind(i64::from(next.frame))
        .bind(big(units))
        .execute(&mut **tx)
        .await
        .attempt("count frame's units")?;
    sqlx::query(
        "UPDATE job SET units_due = units_due + $2, samples_total = samples_total + $3, \
         rev = rev + 1 WHERE id = $1",
    )
    .bind(next.job.0)
    .bind(big(units))
    .bind(big(samples))
    .execute(&mut **tx)
    .await
    .attempt("count job's units")?;
    Ok(())
}
