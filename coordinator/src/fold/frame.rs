//! A complete frame: the hash of its film, once.

use super::error::FoldError;
use super::level::{self, Next};
use super::{series, tile};
use crate::app::{App, now_ms};
use crate::farm::{bad_samples_reason, too_many_bad};
use crate::store::{FrameEnd, FrameTile, TileState};
use shearwater_shared::api::StopCause;
use shearwater_shared::film::{FilmError, FilmHasher, TileFilm};
use shearwater_shared::job::JobId;
use shearwater_shared::plan::Plan;

/// Hash the film of a frame whose tiles are all folded, row of tiles by row of
/// tiles, and store it; false when another was faster.
pub(super) async fn finish(app: &App, job: JobId, frame: u32) -> Result<bool, FoldError> {
    let Some(row) = app.store.job(job).await? else {
        return Ok(false);
    };
    let bad = app.store.bad_samples(job, frame).await?;
    let frame_samples = row.plan().frame_samples();
    if too_many_bad(bad, frame_samples) {
        // Said when the result came, unless the process ended in between.
        let reason = bad_samples_reason(row.settings.absolute_frame(frame), bad, frame_samples);
        return Ok(app.store.fail_job(job, None, &reason, now_ms()).await?);
    }
    let plan = row.plan();
    let cause = match level::next(app, &row, frame).await? {
        Next::End(cause) => cause,
        Next::Pass => return Ok(true),
        Next::Nothing => return Ok(false),
    };
    let mut samples: Option<(u64, u64)> = None;
    let mut hasher = FilmHasher::new(plan);
    for first in (0..plan.tiles()).step_by(plan.tiles_x().max(1) as usize) {
        let mut band = Vec::with_capacity(plan.tiles_x() as usize);
        for tile in first..first + plan.tiles_x() {
            let at = FrameTile { job, frame, tile };
            let Some((film, state)) = tile::read(app, &plan, &at).await? else {
                return Ok(false);
            };
            check_samples(&plan, &film, &state, cause)?;
            let both = 2 * film.samples_per_half;
            samples = Some(samples.map_or((both, both), |(least, most)| {
                (least.min(both), most.max(both))
            }));
            band.push(film);
        }
        hasher = app
            .compute(move || {
                let films: Vec<&TileFilm> = band.iter().collect();
                hasher.add_band(&films).map(|()| hasher)
            })
            .await?
            .map_err(|source| FoldError::Film {
                tile: first,
                source,
            })?;
    }
    let hash = hasher
        .finish()
        .map_err(|source| FoldError::Film { tile: 0, source })?;
    let (least, most) = samples.unwrap_or_default();
    let end = FrameEnd {
        film_hash: hash,
        cause,
        samples: (as_small(least), as_small(most)),
        extended: row.extended,
    };
    let error = series::estimate(app, job, frame).await?;
    let folded = app.store.folded(job, frame).await?;
    let last = folded.filter(|folded| folded.samples > 0).zip(error);
    let last = last.map(|(folded, error)| series::row(frame, folded, error));
    let first = app
        .store
        .finish_frame(job, frame, &end, last.as_ref(), now_ms())
        .await?;
    if first {
        app.metrics.pictures.frames.inc();
        let frame = row.settings.absolute_frame(frame);
        tracing::info!(job = job.0, frame, film_hash = %hash, "frame is complete");
    }
    Ok(first)
}

/// Whether a tile has the samples that its blocks have. When the time was up, blocks
/// may be missing between others.
fn check_samples(
    plan: &Plan,
    film: &TileFilm,
    state: &TileState,
    cause: StopCause,
) -> Result<(), FoldError> {
    let expected = u64::from(plan.samples_of_blocks(state.blocks));
    let fits = match cause {
        StopCause::Seconds => film.samples_per_half > 0,
        StopCause::Error | StopCause::Samples => film.samples_per_half == expected,
    };
    if fits {
        return Ok(());
    }
    Err(FoldError::Film {
        tile: state.tile,
        source: FilmError::Shape("its sample count is not that of its blocks"),
    })
}

/// Samples per pixel, which have 25 bits at most.
fn as_small(samples: u64) -> u32 {
    u32::try_from(samples).unwrap_or(u32::MAX)
}
