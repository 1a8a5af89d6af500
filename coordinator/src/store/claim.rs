//! Units become leased: fresh ones, or once more at the end of a job.

use super::error::{Attempt, StoreError};
use super::log::{Event, log};
use super::open::{Engine, Store};
use super::rows::{big, runs_text, small};
use super::submit::next_id;
use super::time_up::withhold;
use crate::farm::Unit;
use crate::metrics::Transaction as Kind;
use shearwater_shared::api::LogKind;
use shearwater_shared::job::JobId;
use shearwater_shared::plan::Run;
use sqlx::{Any, Transaction};

/// Most frames whose rows one claim makes: small frames fill a lease only
/// together, and a worker builds each of them.
const FRAMES_PER_CLAIM_MAX: u32 = 8;

/// Which units may be claimed.
#[derive(Clone, Debug)]
pub struct ReadyQuery {
    /// Of this job.
    pub job: JobId,
    /// For this worker (instance).
    pub worker: String,
    /// At most so many.
    pub units_max: usize,
    /// Workers present, or 0 when the asking one is alone. Units that it failed
    /// on are left to the others, until as many have failed on them.
    pub present: u64,
    /// For a job with a time stop: how many of its frames, from the first on, are
    /// out of time. Tiles of such a job grow together, block by block.
    pub timed: Option<u32>,
}

/// A fresh lease.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Claimed {
    /// Number of the lease.
    pub id: i64,
    /// Its runs, in the order to render.
    pub runs: Vec<Run>,
}

macro_rules! ready_sql {
    ($order:literal, $tail:literal) => {
        concat!(
            "SELECT frame, tile, block FROM unit WHERE job = $1 AND state = 0 \
             AND ($2 = 0 OR NOT EXISTS (SELECT 1 FROM failure f WHERE f.job = unit.job \
             AND f.frame = unit.frame AND f.tile = unit.tile AND f.block = unit.block \
             AND f.worker = $3) OR (SELECT count(*) FROM failure f WHERE f.job = unit.job \
             AND f.frame = unit.frame AND f.tile = unit.tile AND f.block = unit.block) >= $2) \
             ORDER BY ",
            $order,
            " LIMIT $4",
            $tail
        )
    };
}
const READY_SQLITE: &str = ready_sql!("frame, tile, block", "");
const READY_POSTGRES: &str = ready_sql!("frame, tile, block", " FOR UPDATE SKIP LOCKED");
const EVEN_SQLITE: &str = ready_sql!("frame, block, tile", "");
const EVEN_POSTGRES: &str = ready_sql!("frame, block, tile", " FOR UPDATE SKIP LOCKED");

impl Store {
    /// Lease the runs that `cut` makes of the first ready units; makes the
    /// units of the next frames when too few are ready. `None` when nothing is
    /// ready or the job has ended.
    ///
    /// # Errors
    /// The database failed; nothing was leased.
    pub async fn claim(
        &self,
        query: &ReadyQuery,
        cut: impl FnOnce(&[Unit]) -> Vec<Run> + Send,
        now_ms: i64,
        until_ms: i64,
    ) -> Result<Option<Claimed>, StoreError> {
        let _timed = self.measures.transaction(Kind::Claim);
        let mut tx = self.begin().await?;
        let mut ready = ready_units(&mut tx, self.engine, query).await?;
        // Units may be withheld from this worker: what was made counts as well.
        let mut made = 0;
        for _ in 0..FRAMES_PER_CLAIM_MAX {
            if ready.len().max(made) >= query.units_max {
                break;
            }
            let Some(units) = make_next_frame(&mut tx, query.job).await? else {
                break;
            };
            made += units;
            ready = ready_units(&mut tx, self.engine, query).await?;
        }
        let runs = cut(&ready);
        if runs.is_empty() {
            // The frames that were made are kept.
            tx.commit().await.attempt("commit frame")?;
            return Ok(None);
        }
        if !mark_running(&mut tx, query.job, now_ms).await? {
            return Ok(None);
        }
        let id = next_id(&mut tx, "lease").await?;
        for run in &runs {
            sqlx::query(
                "UPDATE unit SET state = 1, lease = $1 WHERE job = $2 AND frame = $3 \
                 AND tile = $4 AND block >= $5 AND block < $6 AND state = 0",
            )
            .bind(id)
            .bind(query.job.0)
            .bind(i64::from(run.frame))
            .bind(i64::from(run.tile))
            .bind(i64::from(run.block0))
            .bind(i64::from(run.block1))
            .execute(&mut *tx)
            .await
            .attempt("lease units")?;
        }
        let lease = NewLease {
            id,
            job: query.job,
            worker: &query.worker,
            runs: &runs,
            now_ms,
            until_ms,
            kind: LogKind::Leased,
        };
        insert_lease(&mut tx, &lease).await?;
        tx.commit().await.attempt("commit claim")?;
        Ok(Some(Claimed { id, runs }))
    }

    /// Lease `runs`, which another worker holds, once more. Runs that were
    /// counted meanwhile are left out; `None` when all were.
    ///
    /// # Errors
    /// The database failed; nothing was leased.
    pub async fn reissue(
        &self,
        job: JobId,
        runs: &[Run],
        worker: &str,
        now_ms: i64,
        until_ms: i64,
    ) -> Result<Option<Claimed>, StoreError> {
        let _timed = self.measures.transaction(Kind::Claim);
        // In a transaction of its own: the units come first below.
        let mut tx = self.begin().await?;
        let id = next_id(&mut tx, "lease").await?;
        tx.commit().await.attempt("commit number of lease")?;
        let mut tx = self.begin().await?;
        let mut held = Vec::with_capacity(runs.len());
        for run in runs {
            let taken = sqlx::query(
                "UPDATE unit SET lease = $1 WHERE job = $2 AND frame = $3 \
                 AND tile = $4 AND block >= $5 AND block < $6 AND state = 1",
            )
            .bind(id)
            .bind(job.0)
            .bind(i64::from(run.frame))
            .bind(i64::from(run.tile))
            .bind(i64::from(run.block0))
            .bind(i64::from(run.block1))
            .execute(&mut *tx)
            .await
            .attempt("lease units again")?
            .rows_affected();
            // A run that is no longer whole belongs to nobody: it would be
            // refused for overlapping.
            if taken == u64::from(run.block1.saturating_sub(run.block0)) {
                held.push(*run);
            }
        }
        if held.len() != runs.len() || !mark_running(&mut tx, job, now_ms).await? {
            return Ok(None);
        }
        let lease = NewLease {
            id,
            job,
            worker,
            runs: &held,
            now_ms,
            until_ms,
            kind: LogKind::Reissued,
        };
        insert_lease(&mut tx, &lease).await?;
        tx.commit().await.attempt("commit reissue")?;
        Ok(Some(Claimed { id, runs: held }))
    }
}

async fn ready_units(
    tx: &mut Transaction<'static, Any>,
    engine: Engine,
    query: &ReadyQuery,
) -> Result<Vec<Unit>, StoreError> {
    if let Some(over) = query.timed {
        withhold(tx, query.job, over).await?;
    }
    let sql = match (engine, query.timed) {
        (Engine::Sqlite, None) => READY_SQLITE,
        (Engine::Postgres, None) => READY_POSTGRES,
        (Engine::Sqlite, Some(_)) => EVEN_SQLITE,
        (Engine::Postgres, Some(_)) => EVEN_POSTGRES,
    };
    let rows = sqlx::query(sql)
        .bind(query.job.0)
        .bind(big(query.present))
        .bind(&query.worker)
        .bind(i64::try_from(query.units_max).unwrap_or(i64::MAX))
        .fetch_all(&mut **tx)
        .await
        .attempt("read ready units")?;
    rows.iter()
        .map(|row| {
            Ok(Unit {
                frame: small(row, "frame")?,
                tile: small(row, "tile")?,
                block: small(row, "block")?,
            })
        })
        .collect()
}

/// Make the rows of the job's next frame, those that are missing; how many units
/// were made, `None` when there is no further frame. A job that was added to goes
/// through its frames once more.
async fn make_next_frame(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
) -> Result<Option<usize>, StoreError> {
    let row = sqlx::query(
        "UPDATE job SET next_frame = next_frame + 1 WHERE id = $1 AND next_frame < frames \
         AND finished_ms IS NULL RETURNING next_frame, tiles, blocks",
    )
    .bind(job.0)
    .fetch_optional(&mut **tx)
    .await
    .attempt("take next frame")?;
    let Some(row) = row else { return Ok(None) };
    let frame = i64::from(small(&row, "next_frame")?) - 1;
    let (tiles, blocks) = (small(&row, "tiles")?, small(&row, "blocks")?);
    let units = i64::from(tiles) * i64::from(blocks);
    sqlx::query(
        "INSERT INTO frame (job, frame, units_due) VALUES ($1, $2, $3) ON CONFLICT DO NOTHING",
    )
    .bind(job.0)
    .bind(frame)
    .bind(units)
    .execute(&mut **tx)
    .await
    .attempt("insert frame")?;
    sqlx::query(
        "WITH RECURSIVE t(n) AS (SELECT CAST(0 AS BIGINT) UNION ALL SELECT n + 1 FROM t \
         WHERE n + 1 < $3) INSERT INTO tilefold (job, frame, tile, due) \
         SELECT $1, $2, n, $4 FROM t WHERE true ON CONFLICT DO NOTHING",
    )
    .bind(job.0)
    .bind(frame)
    .bind(i64::from(tiles))
    .bind(i64::from(blocks))
    .execute(&mut **tx)
    .await
    .attempt("insert tiles")?;
    let made = sqlx::query(
        "WITH RECURSIVE u(n) AS (SELECT CAST(0 AS BIGINT) UNION ALL SELECT n + 1 FROM u \
         WHERE n + 1 < $3) INSERT INTO unit (job, frame, tile, block) \
         SELECT $1, $2, n / $4, n % $4 FROM u WHERE true ON CONFLICT DO NOTHING",
    )
    .bind(job.0)
    .bind(frame)
    .bind(units)
    .bind(i64::from(blocks))
    .execute(&mut **tx)
    .await
    .attempt("insert units")?;
    Ok(Some(
        usize::try_from(made.rows_affected()).unwrap_or(usize::MAX),
    ))
}

/// Note that the job is being rendered; false when it has ended or is
/// paused.
pub(super) async fn mark_running(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
    now_ms: i64,
) -> Result<bool, StoreError> {
    let live = sqlx::query(
        "UPDATE job SET first_lease_ms = coalesce(first_lease_ms, $2), \
         timed_from_ms = coalesce(timed_from_ms, $2), rev = rev + 1 \
         WHERE id = $1 AND finished_ms IS NULL AND paused_ms IS NULL",
    )
    .bind(job.0)
    .bind(now_ms)
    .execute(&mut **tx)
    .await
    .attempt("mark job running")?;
    Ok(live.rows_affected() == 1)
}

/// A lease to be stored.
#[derive(Clone, Copy, Debug)]
pub(super) struct NewLease<'a> {
    pub(super) id: i64,
    pub(super) job: JobId,
    pub(super) worker: &'a str,
    pub(super) runs: &'a [Run],
    pub(super) now_ms: i64,
    pub(super) until_ms: i64,
    /// What the job's log calls it.
    pub(super) kind: LogKind,
}

/// Insert the lease's row; its job is marked.
pub(super) async fn insert_lease(
    tx: &mut Transaction<'static, Any>,
    lease: &NewLease<'_>,
) -> Result<(), StoreError> {
    sqlx::query(
        "INSERT INTO lease (id, job, worker, runs, created_ms, until_ms) \
         VALUES ($1, $2, $3, $4, $5, $6)",
    )
    .bind(lease.id)
    .bind(lease.job.0)
    .bind(lease.worker)
    .bind(runs_text(lease.runs)?)
    .bind(lease.now_ms)
    .bind(lease.until_ms)
    .execute(&mut **tx)
    .await
    .attempt("insert lease")?;
    sqlx::query("UPDATE job SET served = $2 WHERE id = $1")
        .bind(lease.job.0)
        .bind(lease.id)
        .execute(&mut **tx)
        .await
        .attempt("note turn")?;
    let event = Event {
        worker: Some(lease.worker),
        lease: Some(lease.id),
        runs: lease.runs,
        ..Event::new(lease.job, lease.kind, lease.now_ms)
    };
    log(tx, &event).await
}
