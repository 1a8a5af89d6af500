//! A job as the API shows it.

use super::errors::point;
use super::problem::ApiError;
use crate::app::{App, now_ms};
use crate::farm::{JobCounts, job_state, nmse_at};
use crate::fold;
use crate::store::{Ended, JobRow};
use shearwater_shared::api::JobView;
use shearwater_shared::film::ErrorEstimate;
use shearwater_shared::job::{JobId, JobState};
use shearwater_shared::limits::FILM_HASHES_MAX;

/// The view of a job at this moment.
pub(crate) async fn job_view(app: &App, row: JobRow) -> Result<JobView, ApiError> {
    let error = error(app, &row).await?;
    let newest = app.store.newest_error(row.id).await?;
    let newest_error = newest.map(|newest| point(&row, newest));
    let unfinished = row.frames_done == 0;
    let mut view = progress(row, now_ms());
    view.newest_error = newest_error;
    if let Some((frame, error)) = error {
        view.error_frame = Some(view.settings.absolute_frame(frame));
        if unfinished && !view.done {
            view.nmse_at_end = nmse_at(&error, view.settings.samples);
        }
        view.error = Some(error);
    }
    if view.state == JobState::Done && view.settings.frames <= FILM_HASHES_MAX {
        let hashes = app.store.film_hashes(view.id, FILM_HASHES_MAX).await?;
        view.film_hashes = hashes.into_iter().map(|(_, hash)| hash).collect();
    }
    Ok(view)
}

/// The error of the worst finished frame; before there is one, of the first.
/// Its cost does not grow with the number of frames.
async fn error(app: &App, row: &JobRow) -> Result<Option<(u32, ErrorEstimate)>, ApiError> {
    if row.frames_done > 0
        && let Some(worst) = app.store.worst_frame(row.id).await?
    {
        return Ok(worst.error.map(|error| (worst.frame, error)));
    }
    Ok(so_far(app, row.id, 0).await?.map(|error| (0, error)))
}

/// The last error that was noted of an unfinished frame. Frames that were folded
/// before errors were noted are estimated anew.
pub(super) async fn so_far(
    app: &App,
    job: JobId,
    frame: u32,
) -> Result<Option<ErrorEstimate>, ApiError> {
    match app.store.last_error(job, frame).await? {
        Some(last) => Ok(Some(last.error)),
        None => Ok(fold::estimate(app, job, frame).await?),
    }
}

/// State and progress: a function of the row and of the time.
fn progress(row: JobRow, now_ms: i64) -> JobView {
    let units_total = row.units_total();
    let state = job_state(&JobCounts {
        cancelled: row.ended == Ended::Cancelled,
        failed: matches!(row.ended, Ended::Failed(..)),
        frames: u64::from(row.settings.frames),
        frames_done: row.frames_done,
        units_done: row.units_done,
        units_leased: row.units_leased,
    });
    let to_ms = match state {
        JobState::Queued | JobState::Running => Some(now_ms),
        _ => row.last_result_ms.or(row.finished_ms),
    };
    let elapsed_ms = match (row.first_lease_ms, to_ms) {
        (Some(from), Some(to)) => to.saturating_sub(from).max(0),
        _ => 0,
    };
    let elapsed_s = elapsed_ms as f64 / 1000.0;
    let samples_per_s = if elapsed_s > 0.0 {
        row.samples_done as f64 / elapsed_s
    } else {
        0.0
    };
    let (failure, failure_kind) = match row.ended {
        Ended::Failed(reason, kind) => (Some(reason), kind),
        _ => (None, None),
    };
    let left = row.samples_total.saturating_sub(row.samples_done) as f64;
    JobView {
        id: row.id,
        name: row.name,
        state,
        done: state.is_final(),
        failure,
        failure_kind,
        priority: row.priority,
        settings: row.settings,
        scene_hash: row.manifest.scene,
        fps: row.fps,
        animation_frames: row.animation_frames,
        frames_done: row.frames_done,
        submitted_ms: row.submitted_ms,
        finished_ms: row.finished_ms,
        units_total,
        units_done: row.units_done,
        samples_done: row.samples_done,
        progress: row.units_done as f64 / units_total.max(1) as f64,
        elapsed_s,
        samples_per_s,
        core_s: row.core_us as f64 / 1e6,
        remaining_s: (!state.is_final() && samples_per_s > 0.0).then(|| left / samples_per_s),
        error: None,
        error_frame: None,
        nmse_at_end: None,
        newest_error: None,
        bad_samples: row.bad_samples,
        depth_cap_hits: row.depth_cap_hits,
        unequal_results: row.unequal_results,
        film_hashes: Vec::new(),
        rev: row.rev,
    }
}
