//! Results of a worker that is not believed any more are taken back.
//!
//! Sums that are in a film cannot be told from the others in it: a tile whose film
//! holds some of them is begun again. Where an error stop chose the samples by such a
//! film, the whole frame is.

use super::error::{Attempt, StoreError};
use super::folds::FrameTile;
use super::log::{Event, log_change};
use super::open::Store;
use super::order::lock_job;
use super::rows::{JobRow, big, count, int, optional_text, small};
use shearwater_shared::api::LogKind;
use shearwater_shared::job::JobId;
use shearwater_shared::plan::{Plan, Run};
use sqlx::{Any, Transaction};

/// What was taken back.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Withdrawn {
    /// Units that are ready again.
    pub units: u64,
    /// Objects that no row names any more.
    pub objects: Vec<String>,
}

/// A counted part, as far as it matters here.
#[derive(Debug)]
struct Part {
    run: Run,
    object: Option<String>,
    core_us: i64,
    bad_samples: i64,
    depth_cap_hits: i64,
    wrong: bool,
}

/// Numbers that a frame and its job lose.
#[derive(Clone, Copy, Debug, Default)]
struct Less {
    units: u64,
    samples: u64,
    bad_samples: i64,
    depth_cap_hits: i64,
    samples_folded: u64,
    core_us_folded: i64,
}

impl Less {
    fn add(&mut self, part: &Part, plan: &Plan) {
        let samples = plan.run_samples(&part.run);
        self.units += u64::from(part.run.block1.saturating_sub(part.run.block0));
        self.samples += samples;
        self.bad_samples += part.bad_samples;
        self.depth_cap_hits += part.depth_cap_hits;
        if part.object.is_none() {
            self.samples_folded += samples;
            self.core_us_folded += part.core_us;
        }
    }
}

impl Store {
    /// Tiles of live jobs that hold results of workers which are not believed any
    /// more, in order, at most `limit`.
    ///
    /// # Errors
    /// The database failed.
    pub async fn tiles_to_withdraw(&self, limit: u32) -> Result<Vec<FrameTile>, StoreError> {
        sqlx::query(
            "SELECT DISTINCT p.job, p.frame, p.tile FROM distrust d \
             JOIN part p ON p.worker = d.worker JOIN job j ON j.id = p.job \
             WHERE j.finished_ms IS NULL ORDER BY p.job, p.frame, p.tile LIMIT $1",
        )
        .bind(i64::from(limit))
        .fetch_all(&self.read)
        .await
        .attempt("find wrong results")?
        .iter()
        .map(|row| {
            Ok(FrameTile {
                job: JobId(int(row, "job")?),
                frame: small(row, "frame")?,
                tile: small(row, "tile")?,
            })
        })
        .collect()
    }

    /// Runs in a job's pictures of workers that were found to be wrong afterwards.
    ///
    /// # Errors
    /// The database failed.
    pub async fn wrong_runs(&self, job: JobId) -> Result<u64, StoreError> {
        let row = sqlx::query(
            "SELECT count(*) AS runs FROM distrust d JOIN part p ON p.worker = d.worker \
             WHERE p.job = $1",
        )
        .bind(job.0)
        .fetch_one(&self.read)
        .await
        .attempt("count wrong results")?;
        count(&row, "runs")
    }

    /// Take the wrong results of a tile back: all of the tile when some are in its
    /// film, else only they. Their units are ready again; a finished frame is open.
    ///
    /// # Errors
    /// The database failed; the tile is as before.
    pub async fn withdraw_tile(
        &self,
        job: &JobRow,
        at: &FrameTile,
        now_ms: i64,
    ) -> Result<Withdrawn, StoreError> {
        let mut tx = self.begin().await?;
        hold(&mut tx, at.job, at.frame, Some(at.tile)).await?;
        let mut gone = parts(&mut tx, at.job, at.frame, Some(at.tile)).await?;
        if gone.iter().all(|part| !part.wrong) {
            // Now: claims pass by what is held.
            tx.rollback().await.attempt("let go")?;
            return Ok(Withdrawn::default());
        }
        let film = gone.iter().any(|part| part.wrong && part.object.is_none());
        gone.retain(|part| film || part.wrong);
        let (mut less, plan) = (Less::default(), job.plan());
        let mut withdrawn = Withdrawn::default();
        for part in &gone {
            free_units(&mut tx, at.job, &part.run).await?;
            less.add(part, &plan);
            withdrawn.objects.extend(part.object.clone());
        }
        withdrawn.units = less.units;
        if !film {
            // Nothing was folded.
            (less.samples_folded, less.core_us_folded) = (0, 0);
        }
        less_of_job(&mut tx, at.job, &less).await?;
        for part in &gone {
            take_part(&mut tx, at.job, &part.run).await?;
        }
        if film {
            withdrawn.objects.extend(empty_film(&mut tx, at).await?);
        }
        open_frame(&mut tx, at.job, at.frame, &less).await?;
        log_withdrawn(&mut tx, at.job, &gone, now_ms).await?;
        tx.commit().await.attempt("commit withdrawal")?;
        Ok(withdrawn)
    }

    /// Take all results of a frame back and forget its passes: its rows are made again
    /// when it is claimed.
    ///
    /// # Errors
    /// The database failed; the frame is as before.
    pub async fn withdraw_frame(
        &self,
        job: &JobRow,
        frame: u32,
        now_ms: i64,
    ) -> Result<Withdrawn, StoreError> {
        let mut tx = self.begin().await?;
        hold(&mut tx, job.id, frame, None).await?;
        let gone = parts(&mut tx, job.id, frame, None).await?;
        if gone.iter().all(|part| !part.wrong) {
            // Now: claims pass by what is held.
            tx.rollback().await.attempt("let go")?;
            return Ok(Withdrawn::default());
        }
        let (mut less, plan) = (Less::default(), job.plan());
        let mut withdrawn = Withdrawn::default();
        for part in &gone {
            less.add(part, &plan);
            withdrawn.objects.extend(part.object.clone());
        }
        withdrawn.units = less.units;
        let films = films(&mut tx, job.id, frame).await?;
        withdrawn.objects.extend(films);
        forget_units(&mut tx, job, frame).await?;
        less_of_job(&mut tx, job.id, &less).await?;
        open_frame(&mut tx, job.id, frame, &less).await?;
        forget_frame(&mut tx, job.id, frame).await?;
        log_withdrawn(&mut tx, job.id, &gone, now_ms).await?;
        tx.commit().await.attempt("commit withdrawal")?;
        Ok(withdrawn)
    }
}

/// Take the units of a tile, or of a whole frame, and the job, before anything is read:
/// another coordinator withdraws the same, counts or folds before or after, never between.
async fn hold(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
    frame: u32,
    tile: Option<u32>,
) -> Result<(), StoreError> {
    sqlx::query(
        "UPDATE unit SET state = state WHERE job = $1 AND frame = $2 AND ($3 < 0 OR tile = $3)",
    )
    .bind(job.0)
    .bind(i64::from(frame))
    .bind(tile.map_or(-1, i64::from))
    .execute(&mut **tx)
    .await
    .attempt("take units")?;
    lock_job(tx, job).await.map(drop)
}

/// The counted parts of a tile, or of a whole frame.
async fn parts(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
    frame: u32,
    tile: Option<u32>,
) -> Result<Vec<Part>, StoreError> {
    let rows = sqlx::query(
        "SELECT p.tile, p.block0, p.block1, p.object, p.core_us, p.bad_samples, \
         p.depth_cap_hits, CAST(CASE WHEN d.worker IS NULL THEN 0 ELSE 1 END AS BIGINT) AS wrong \
         FROM part p LEFT JOIN distrust d ON d.worker = p.worker \
         WHERE p.job = $1 AND p.frame = $2 AND ($3 < 0 OR p.tile = $3) ORDER BY p.tile, p.block0",
    )
    .bind(job.0)
    .bind(i64::from(frame))
    .bind(tile.map_or(-1, i64::from))
    .fetch_all(&mut **tx)
    .await
    .attempt("read parts")?;
    rows.iter()
        .map(|row| {
            Ok(Part {
                run: Run {
                    frame,
                    tile: small(row, "tile")?,
                    block0: small(row, "block0")?,
                    block1: small(row, "block1")?,
                },
                object: optional_text(row, "object")?,
                core_us: int(row, "core_us")?,
                bad_samples: int(row, "bad_samples")?,
                depth_cap_hits: int(row, "depth_cap_hits")?,
                wrong: int(row, "wrong")? != 0,
            })
        })
        .collect()
}

/// Make the units of one run ready.
async fn free_units(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
    run: &Run,
) -> Result<(), StoreError> {
    sqlx::query(
        "UPDATE unit SET state = 0, lease = 0 WHERE job = $1 AND frame = $2 AND tile = $3 \
         AND block >= $4 AND block < $5 AND state = 2",
    )
    .bind(job.0)
    .bind(i64::from(run.frame))
    .bind(i64::from(run.tile))
    .bind(i64::from(run.block0))
    .bind(i64::from(run.block1))
    .execute(&mut **tx)
    .await
    .attempt("free units")?;
    Ok(())
}

/// Forget the part of one run.
async fn take_part(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
    run: &Run,
) -> Result<(), StoreError> {
    for statement in [
        "DELETE FROM audit WHERE job = $1 AND frame = $2 AND tile = $3 AND block0 = $4 \
         AND block1 = $5",
        "DELETE FROM part WHERE job = $1 AND frame = $2 AND tile = $3 AND block0 = $4 \
         AND block1 = $5",
    ] {
        sqlx::query(statement)
            .bind(job.0)
            .bind(i64::from(run.frame))
            .bind(i64::from(run.tile))
            .bind(i64::from(run.block0))
            .bind(i64::from(run.block1))
            .execute(&mut **tx)
            .await
            .attempt("take run back")?;
    }
    Ok(())
}

/// Begin a tile's film again; the name of the old one.
async fn empty_film(
    tx: &mut Transaction<'static, Any>,
    at: &FrameTile,
) -> Result<Option<String>, StoreError> {
    let bound = |sql: &'static str| {
        sqlx::query(sql)
            .bind(at.job.0)
            .bind(i64::from(at.frame))
            .bind(i64::from(at.tile))
    };
    // Whoever folds this tile now finds another version.
    bound("UPDATE tilefold SET version = version + 1 WHERE job = $1 AND frame = $2 AND tile = $3")
        .execute(&mut **tx)
        .await
        .attempt("lock tile")?;
    let row = bound("SELECT object FROM tilefold WHERE job = $1 AND frame = $2 AND tile = $3")
        .fetch_optional(&mut **tx)
        .await
        .attempt("read tile")?;
    bound(
        "UPDATE tilefold SET blocks = 0, object = NULL, error = NULL, brightness = NULL \
         WHERE job = $1 AND frame = $2 AND tile = $3",
    )
    .execute(&mut **tx)
    .await
    .attempt("empty tile")?;
    row.map_or(Ok(None), |row| optional_text(&row, "object"))
}

/// The films of a frame's tiles.
async fn films(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
    frame: u32,
) -> Result<Vec<String>, StoreError> {
    let rows = sqlx::query(
        "SELECT object FROM tilefold WHERE job = $1 AND frame = $2 AND object IS NOT NULL",
    )
    .bind(job.0)
    .bind(i64::from(frame))
    .fetch_all(&mut **tx)
    .await
    .attempt("read films")?;
    let names = rows.iter().map(|row| optional_text(row, "object"));
    Ok(names
        .collect::<Result<Vec<_>, _>>()?
        .into_iter()
        .flatten()
        .collect())
}

/// A frame has less than was counted; if it was finished, it is not any more. Points of
/// its error against time may be wrong.
async fn open_frame(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
    frame: u32,
    less: &Less,
) -> Result<(), StoreError> {
    sqlx::query(
        "UPDATE job SET frames_done = frames_done - 1 WHERE id = $1 AND EXISTS \
         (SELECT 1 FROM frame WHERE job = $1 AND frame = $2 AND film_hash IS NOT NULL)",
    )
    .bind(job.0)
    .bind(i64::from(frame))
    .execute(&mut **tx)
    .await
    .attempt("open frame")?;
    sqlx::query(
        "UPDATE frame SET units_done = units_done - $3, bad_samples = bad_samples - $4, \
         samples_folded = samples_folded - $5, core_us_folded = core_us_folded - $6, \
         film_hash = NULL, error = NULL, nmse_pico = NULL WHERE job = $1 AND frame = $2",
    )
    .bind(job.0)
    .bind(i64::from(frame))
    .bind(big(less.units))
    .bind(less.bad_samples)
    .bind(big(less.samples_folded))
    .bind(less.core_us_folded)
    .execute(&mut **tx)
    .await
    .attempt("take from frame")?;
    sqlx::query("DELETE FROM error_point WHERE job = $1 AND frame = $2")
        .bind(job.0)
        .bind(i64::from(frame))
        .execute(&mut **tx)
        .await
        .attempt("forget errors")?;
    Ok(())
}

/// A job has less than was counted, and whoever decides about it must look again. What
/// its cores spent, they have spent.
async fn less_of_job(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
    less: &Less,
) -> Result<(), StoreError> {
    sqlx::query(
        "UPDATE job SET units_done = units_done - $2, samples_done = samples_done - $3, \
         bad_samples = bad_samples - $4, depth_cap_hits = depth_cap_hits - $5, \
         extended = extended + 1 WHERE id = $1",
    )
    .bind(job.0)
    .bind(big(less.units))
    .bind(big(less.samples))
    .bind(less.bad_samples)
    .bind(less.depth_cap_hits)
    .execute(&mut **tx)
    .await
    .attempt("take from job")?;
    Ok(())
}

/// Forget the units of a frame; its job has those of the first pass to come.
async fn forget_units(
    tx: &mut Transaction<'static, Any>,
    job: &JobRow,
    frame: u32,
) -> Result<(), StoreError> {
    let plan = job.plan();
    let row = sqlx::query(
        "SELECT (SELECT count(*) FROM unit u WHERE u.job = $1 AND u.frame = $2 AND u.state < 3) \
         AS units, tiles, blocks FROM job WHERE id = $1",
    )
    .bind(job.id.0)
    .bind(i64::from(frame))
    .fetch_one(&mut **tx)
    .await
    .attempt("count frame's units")?;
    let (tiles, blocks) = (small(&row, "tiles")?, small(&row, "blocks")?);
    let first_units = i64::from(tiles) * i64::from(blocks);
    let first = (0..tiles).map(|tile| samples_of(&plan, frame, tile, blocks));
    let ends = sqlx::query(
        "SELECT tile, count(*) AS blocks FROM unit WHERE job = $1 AND frame = $2 AND state < 3 \
         GROUP BY tile",
    )
    .bind(job.id.0)
    .bind(i64::from(frame))
    .fetch_all(&mut **tx)
    .await
    .attempt("count tiles' units")?;
    let mut samples = 0;
    for end in &ends {
        samples += samples_of(&plan, frame, small(end, "tile")?, small(end, "blocks")?);
    }
    sqlx::query("DELETE FROM unit WHERE job = $1 AND frame = $2")
        .bind(job.id.0)
        .bind(i64::from(frame))
        .execute(&mut **tx)
        .await
        .attempt("forget units")?;
    sqlx::query(
        "UPDATE job SET units_due = units_due + $2, samples_total = samples_total + $3 \
         WHERE id = $1",
    )
    .bind(job.id.0)
    .bind(first_units - int(&row, "units")?)
    .bind(big(first.sum::<u64>()) - big(samples))
    .execute(&mut **tx)
    .await
    .attempt("count what is due")?;
    Ok(())
}

/// Forget the other rows of a frame: another walk through the frames makes them again.
async fn forget_frame(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
    frame: u32,
) -> Result<(), StoreError> {
    for statement in [
        "UPDATE job SET next_frame = $2 WHERE id = $1 AND next_frame > $2",
        "DELETE FROM part WHERE job = $1 AND frame = $2",
        "DELETE FROM audit WHERE job = $1 AND frame = $2",
        "DELETE FROM tilefold WHERE job = $1 AND frame = $2",
        "DELETE FROM frame WHERE job = $1 AND frame = $2",
    ] {
        let done = sqlx::query(statement).bind(job.0).bind(i64::from(frame));
        let done = done.execute(&mut **tx).await;
        done.attempt("forget frame")?;
    }
    Ok(())
}

/// Samples of the first `blocks` blocks of a tile.
fn samples_of(plan: &Plan, frame: u32, tile: u32, blocks: u32) -> u64 {
    plan.run_samples(&Run {
        frame,
        tile,
        block0: 0,
        block1: blocks,
    })
}

async fn log_withdrawn(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
    gone: &[Part],
    now_ms: i64,
) -> Result<(), StoreError> {
    let runs: Vec<Run> = gone.iter().map(|part| part.run).collect();
    let event = Event {
        runs: &runs,
        ..Event::new(job, LogKind::Withdrawn, now_ms)
    };
    log_change(tx, &event).await
}
