//! Error against time: a row of a frame when it is due, and its final one.

use super::error::FoldError;
use crate::app::{App, now_ms};
use crate::store::{ErrorRow, Folded, StoreError};
use shearwater_shared::film::{ErrorEstimate, join_errors};
use shearwater_shared::job::JobId;

/// The error of a frame as far as its tiles are folded; `None` before the first is.
pub(crate) async fn estimate(
    app: &App,
    job: JobId,
    frame: u32,
) -> Result<Option<ErrorEstimate>, StoreError> {
    let tiles = app.store.tile_errors(job, frame).await?;
    let Some(error) = join_errors(tiles.into_iter()) else {
        return Ok(None);
    };
    let brightness = app.store.brightness(job, frame).await?;
    Ok(Some(error.with_brightness(&brightness)))
}

/// Add a row if the frame's error has changed enough since the last one.
pub(super) async fn record(app: &App, job: JobId, frame: u32) -> Result<(), FoldError> {
    // Counted first: what is folded meanwhile makes the error better than the row
    // says, never worse.
    let Some(folded) = app.store.error_due(job, frame).await? else {
        return Ok(());
    };
    if let Some(error) = estimate(app, job, frame).await? {
        if error.detail.is_some_and(|detail| detail.repeated_tiles > 0) {
            tracing::error!(
                job = job.0,
                frame,
                "ALARM: halves of a tile are equal bit for bit: a repeated \
                seed, and its error is unknown"
            );
        }
        app.store.add_error(job, &row(frame, folded, error)).await?;
    }
    Ok(())
}

/// A row of this moment.
pub(super) fn row(frame: u32, folded: Folded, error: ErrorEstimate) -> ErrorRow {
    ErrorRow {
        frame,
        samples: folded.samples,
        at_ms: now_ms(),
        core_us: folded.core_us,
        error,
    }
}
