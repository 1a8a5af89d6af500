//! From parts to tiles, from tiles to films, from films to pictures.
//!
//! Sums are integers, so the order of folding leaves no trace. A tile's film is
//! a write-once object; a row names the present one and is swapped by compare
//! and exchange, so any coordinator may fold at any time and a crash leaves at
//! most an object that nobody names.

mod error;
mod frame;
mod level;
mod picture;
mod series;
mod tile;

pub use error::FoldError;
pub use picture::Planes;
pub(crate) use picture::picture;
pub(crate) use series::estimate;

use crate::app::App;
use crate::audit::{self, Watch};
use crate::store::FrameTile;
use futures_util::stream::{self, StreamExt};
use shearwater_shared::job::JobId;

/// Parts of one tile that may wait before they are folded although the tile is
/// not complete: bounds what a picture of an unfinished job must read.
const PARTS_MAX: u32 = 8;
/// Tiles looked for in one pass; the next pass follows at once.
const TILES_PER_PASS: u32 = 64;
/// Tiles folded at the same time: one computes while another reads.
const TILES_AT_ONCE: usize = 3;
/// Frames finished in one pass.
const FRAMES_PER_PASS: u32 = 4;

/// Fold what is due and finish frames; how much was done.
pub(crate) async fn pass(app: &App, watch: &mut Watch) -> Result<usize, FoldError> {
    let tiles = app.store.tiles_to_fold(PARTS_MAX, TILES_PER_PASS).await?;
    // An error of one tile or frame must not hold up the others.
    let mut tally = Tally::default();
    let mut frames: Vec<(JobId, u32)> = tiles.iter().map(|at| (at.job, at.frame)).collect();
    frames.dedup();
    let mut folds = stream::iter(tiles)
        .map(|at| fold_or_fail(app, at))
        .buffer_unordered(TILES_AT_ONCE);
    while let Some(folded) = folds.next().await {
        tally.add(folded);
    }
    for (job, frame) in frames {
        // Without its row a frame is only less well told of.
        if let Err(error) = series::record(app, job, frame).await {
            tracing::warn!(job = job.0, frame, %error, "error against time");
        }
    }
    // What this gives up is finished now, not a second later.
    tally.done += audit::give_up(app, watch).await?;
    for (job, frame) in app.store.frames_to_finish(FRAMES_PER_PASS).await? {
        tally.add(match frame::finish(app, job, frame).await {
            Ok(done) => Ok(done),
            Err(error) => lost(app, job, error).await,
        });
    }
    if tally.done > 0 {
        app.job_changed();
    }
    tally.first_error.map_or(Ok(tally.done), Err)
}

/// What one pass did.
#[derive(Default)]
struct Tally {
    done: usize,
    first_error: Option<FoldError>,
}

impl Tally {
    fn add(&mut self, outcome: Result<bool, FoldError>) {
        match (outcome, &self.first_error) {
            (Ok(done), _) => self.done += usize::from(done),
            (Err(error), None) => self.first_error = Some(error),
            (Err(error), Some(_)) => tracing::error!(%error, "folding"),
        }
    }
}

async fn fold_or_fail(app: &App, at: FrameTile) -> Result<bool, FoldError> {
    let _timed = app.metrics.pictures.folding();
    match tile::fold(app, &at).await {
        Ok(done) => Ok(done),
        Err(error) => lost(app, at.job, error).await,
    }
}

/// Stored data that are gone or damaged fail their job, with the reason; any
/// other error is passed on to be tried again.
async fn lost(app: &App, job: JobId, error: FoldError) -> Result<bool, FoldError> {
    if !error.is_permanent() {
        return Err(error);
    }
    tracing::error!(job = job.0, %error, "stored data of the job are lost");
    let reason = format!("{error}; submit the job again");
    app.store
        .fail_job(job, None, &reason, crate::app::now_ms())
        .await?;
    Ok(true)
}
