//! From parts to tiles, from tiles to films, from films to pictures.
//!
//! Sums are integers, so the order of folding leaves no trace. A tile's film is
//! a write-once object; a row names the present one and is swapped by compare
//! and exchange, so any coordinator may fold at any time and a crash leaves at
//! most an object that nobody names.

mod error;
mod frame;
mod picture;
mod tile;

pub use error::FoldError;
pub use picture::Planes;
pub(crate) use picture::picture;

use crate::app::App;
use crate::store::FrameTile;
use futures_util::stream::{self, StreamExt, TryStreamExt};

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
pub(crate) async fn pass(app: &App) -> Result<usize, FoldError> {
    let tiles = app.store.tiles_to_fold(PARTS_MAX, TILES_PER_PASS).await?;
    let folded: usize = stream::iter(tiles)
        .map(|at| fold_or_fail(app, at))
        .buffer_unordered(TILES_AT_ONCE)
        .try_fold(0, |sum, done| async move { Ok(sum + usize::from(done)) })
        .await?;
    let mut finished = 0;
    for (job, frame) in app.store.frames_to_finish(FRAMES_PER_PASS).await? {
        finished += match frame::finish(app, job, frame).await {
            Ok(done) => usize::from(done),
            Err(error) => lost(app, job, error).await?,
        };
    }
    if folded + finished > 0 {
        app.job_changed();
    }
    Ok(folded + finished)
}

async fn fold_or_fail(app: &App, at: FrameTile) -> Result<bool, FoldError> {
    match tile::fold(app, &at).await {
        Ok(done) => Ok(done),
        Err(error) => lost(app, at.job, error).await.map(|n| n > 0),
    }
}

/// Stored data that are gone or damaged fail their job, with the reason; any
/// other error is passed on to be tried again.
async fn lost(
    app: &App,
    job: shearwater_shared::job::JobId,
    error: FoldError,
) -> Result<usize, FoldError> {
    if !error.is_permanent() {
        return Err(error);
    }
    tracing::error!(%job, %error, "stored data of the job are lost");
    let reason = format!("{error}; submit the job again");
    app.store
        .fail_job(job, None, &reason, crate::app::now_ms())
        .await?;
    Ok(1)
}
