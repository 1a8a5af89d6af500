//! Rows for frames that nobody has touched yet, and the units that are ready.

use super::claim::ClaimQuery;
use super::error::{Attempt, StoreError};
use super::open::Engine;
use super::rows::{int, small, text};
use super::time_up::withhold;
use crate::farm::{Failed, Unit, frames_out_of_time};
use shearwater_shared::job::JobId;
use sqlx::any::AnyRow;
use sqlx::{Any, Transaction};

/// Most frames whose rows one claim makes for each worker in it: small frames fill a
/// lease only together, and a worker builds each of them.
const FRAMES_PER_WISH_MAX: usize = 8;
/// Most frames whose rows one claim makes: bounds its transaction.
const FRAMES_PER_CLAIM_MAX: usize = 64;
/// Failures that a claim looks at, each (unit, worker): a job with more ends soon.
const FAILURES_MAX: i64 = 4096;

macro_rules! ready_sql {
    ($order:literal, $tail:literal) => {
        concat!(
            "SELECT frame, tile, block FROM unit WHERE job = $1 AND state = 0 ORDER BY ",
            $order,
            " LIMIT $2",
            $tail
        )
    };
}
const READY_SQLITE: &str = ready_sql!("frame, tile, block", "");
const READY_POSTGRES: &str = ready_sql!("frame, tile, block", " FOR UPDATE SKIP LOCKED");
const EVEN_SQLITE: &str = ready_sql!("frame, block, tile", "");
const EVEN_POSTGRES: &str = ready_sql!("frame, block, tile", " FOR UPDATE SKIP LOCKED");

/// Ready units for all wishes and who failed on some of them; makes the rows of the
/// next frames when too few are ready.
pub(super) async fn ready_units(
    tx: &mut Transaction<'static, Any>,
    engine: Engine,
    query: &ClaimQuery,
    now_ms: i64,
) -> Result<(Vec<Unit>, Failed), StoreError> {
    let over = match query.timed {
        true => out_of_time(tx, query.job, now_ms).await?,
        false => None,
    };
    let from = From {
        engine,
        query,
        over,
    };
    let wanted: usize = query.wishes.iter().map(|wish| wish.units_max).sum();
    let ready = read_or_make(tx, &from, wanted).await?;
    let failed = failures(tx, query.job, &ready).await?;
    if failed.is_empty() {
        return Ok((ready, failed));
    }
    // Each of them may be withheld from whoever asks.
    let wanted = wanted.saturating_add(failed.len());
    let ready = read_or_make(tx, &from, wanted).await?;
    Ok((ready, failed))
}

/// What is read, and how.
struct From<'a> {
    engine: Engine,
    query: &'a ClaimQuery,
    /// Frames out of time, of a job with a time stop.
    over: Option<u32>,
}

/// How many of the job's frames, from the first on, are out of time as it is now;
/// `None` without a time stop.
async fn out_of_time(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
    now_ms: i64,
) -> Result<Option<u32>, StoreError> {
    let row = sqlx::query(
        "SELECT frames, stop_s, coalesce(timed_from_ms, $2) AS from_ms FROM job \
         WHERE id = $1 AND stop_s IS NOT NULL",
    )
    .bind(job.0)
    .bind(now_ms)
    .fetch_optional(&mut **tx)
    .await
    .attempt("read time stop")?;
    row.map(|row| {
        let (from_ms, seconds) = (int(&row, "from_ms")?, small(&row, "stop_s")?);
        let frames = small(&row, "frames")?;
        Ok(frames_out_of_time(from_ms, seconds, frames, now_ms))
    })
    .transpose()
}

async fn read_or_make(
    tx: &mut Transaction<'static, Any>,
    from: &From<'_>,
    wanted: usize,
) -> Result<Vec<Unit>, StoreError> {
    let frames_max = FRAMES_PER_WISH_MAX.saturating_mul(from.query.wishes.len());
    let ready = read_ready(tx, from, wanted).await?;
    let mut made = 0;
    for _ in 0..frames_max.min(FRAMES_PER_CLAIM_MAX) {
        if ready.len() + made >= wanted {
            break;
        }
        let Some(units) = make_next_frame(tx, from.query.job).await? else {
            break;
        };
        made += units;
    }
    if made == 0 {
        return Ok(ready);
    }
    read_ready(tx, from, wanted).await
}

async fn read_ready(
    tx: &mut Transaction<'static, Any>,
    from: &From<'_>,
    units_max: usize,
) -> Result<Vec<Unit>, StoreError> {
    let job = from.query.job;
    if let Some(over) = from.over {
        withhold(tx, job, over).await?;
    }
    let sql = match (from.engine, from.over) {
        (Engine::Sqlite, None) => READY_SQLITE,
        (Engine::Postgres, None) => READY_POSTGRES,
        (Engine::Sqlite, Some(_)) => EVEN_SQLITE,
        (Engine::Postgres, Some(_)) => EVEN_POSTGRES,
    };
    sqlx::query(sql)
        .bind(job.0)
        .bind(i64::try_from(units_max).unwrap_or(i64::MAX))
        .fetch_all(&mut **tx)
        .await
        .attempt("read ready units")?
        .iter()
        .map(unit_of)
        .collect()
}

fn unit_of(row: &AnyRow) -> Result<Unit, StoreError> {
    Ok(Unit {
        frame: small(row, "frame")?,
        tile: small(row, "tile")?,
        block: small(row, "block")?,
    })
}

/// Who failed on uncounted units of the frames of `ready`.
async fn failures(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
    ready: &[Unit],
) -> Result<Failed, StoreError> {
    let frames = ready.iter().map(|unit| unit.frame);
    let (Some(first), Some(last)) = (frames.clone().min(), frames.max()) else {
        return Ok(Failed::new());
    };
    let rows = sqlx::query(
        "SELECT f.frame, f.tile, f.block, f.worker FROM failure f JOIN unit u ON u.job = f.job \
         AND u.frame = f.frame AND u.tile = f.tile AND u.block = f.block WHERE f.job = $1 \
         AND f.frame >= $2 AND f.frame <= $3 AND u.state < 2 \
         ORDER BY f.frame, f.tile, f.block, f.worker LIMIT $4",
    )
    .bind(job.0)
    .bind(i64::from(first))
    .bind(i64::from(last))
    .bind(FAILURES_MAX)
    .fetch_all(&mut **tx)
    .await
    .attempt("read failures")?;
    let mut failed = Failed::new();
    for row in &rows {
        let by = failed.entry(unit_of(row)?).or_default();
        by.push(text(row, "worker")?);
    }
    Ok(failed)
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
