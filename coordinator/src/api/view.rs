//! A job as the API shows it.

use super::errors::point;
use super::problem::ApiError;
use crate::app::{App, now_ms};
use crate::farm::{JobCounts, job_state, nmse_at, samples_to_error, webhook_state};
use crate::fold;
use crate::store::{Ended, JobRow};
use shearwater_shared::api::{JobView, WebhookView};
use shearwater_shared::film::ErrorEstimate;
use shearwater_shared::job::{JobId, JobState};
use shearwater_shared::limits::FILM_HASHES_MAX;

/// The view of a job at this moment.
pub(crate) async fn job_view(app: &App, row: JobRow) -> Result<JobView, ApiError> {
    let error = error(app, &row).await?;
    let newest = app.store.newest_error(row.id).await?;
    let newest_error = newest.map(|newest| point(&row, &newest));
    let unfinished = row.frames_done == 0;
    let live = row.finished_ms.is_none();
    let halted = app.troubles.text(now_ms()).filter(|_| live);
    let note = halted
        .map(|why| format!("paused: {why}. It goes on by itself"))
        .or_else(|| note(&row, &app.config.build));
    let note = match note {
        None => wrong_note(app, &row).await?,
        some => some,
    };
    let webhook = webhook(app, &row).await?;
    let mut view = progress(row, now_ms());
    view.newest_error = newest_error;
    view.note = note;
    view.webhook = webhook;
    if let Some((frame, error)) = error {
        view.error_frame = Some(view.settings.absolute_frame(frame));
        // Of a job that may stop earlier nobody knows the last number of samples.
        if unfinished && !view.done && view.settings.stop.is_default() {
            view.nmse_at_end = nmse_at(&error, view.settings.samples);
        }
        view.error = Some(error);
    }
    view.target_s = target_s(&view);
    if view.settings.stop.error.is_some() {
        // What is due is only the present pass.
        view.remaining_s = view.target_s;
    }
    if view.state == JobState::Done && view.settings.frames <= FILM_HASHES_MAX {
        let hashes = app.store.film_hashes(view.id, FILM_HASHES_MAX).await?;
        view.film_hashes = hashes.into_iter().map(|(_, hash)| hash).collect();
    }
    Ok(view)
}

/// The view without what follows from the time alone: equal as long as nothing
/// happens to the job.
pub(super) fn meaning(view: &JobView) -> JobView {
    JobView {
        elapsed_s: 0.0,
        samples_per_s: 0.0,
        remaining_s: None,
        target_s: None,
        ..view.clone()
    }
}

/// Whom its end is told, and how far that has come.
async fn webhook(app: &App, row: &JobRow) -> Result<Option<WebhookView>, ApiError> {
    let found = app.store.webhook(row.id).await?;
    Ok(found.map(|webhook| WebhookView {
        state: webhook_state(row.finished_ms, webhook.told, now_ms()),
        url: webhook
            .url
            .split(['?', '#'])
            .next()
            .unwrap_or_default()
            .to_owned(),
        attempts: webhook.attempts,
        last_status: webhook.last_status,
        last_error: webhook.last_error,
        delivered_ms: webhook.delivered_ms,
    }))
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

/// Seconds until the error target is reached.
fn target_s(view: &JobView) -> Option<f64> {
    let target = view.settings.stop.error?.get();
    let rests = view.done || view.state == JobState::Paused;
    if rests || view.settings.frames > 1 || view.samples_per_s <= 0.0 {
        return None;
    }
    let pixels = u64::from(view.settings.width) * u64::from(view.settings.height);
    let needed = samples_to_error(view.error.as_ref()?, pixels, target)?;
    // `samples` is the most that any pixel gets.
    let all = pixels as f64 * f64::from(view.settings.samples);
    let left = (needed.min(all) - view.samples_done as f64).max(0.0);
    Some(left / view.samples_per_s)
}

/// What a user should know beyond numbers.
fn note(row: &JobRow, build: &str) -> Option<String> {
    let first = row.build.as_ref().filter(|first| *first != build)?;
    (row.finished_ms.is_none()).then(|| {
        format!(
            "begun with build `{first}`, this farm has `{build}`: their pixels would differ, so nobody goes on with \
             it. Submit it again, or finish it with the Shearwater that began it"
        )
    })
}

/// What is to be said of pictures that hold results of a worker which was found to be
/// wrong after the job was done.
async fn wrong_note(app: &App, row: &JobRow) -> Result<Option<String>, ApiError> {
    if row.finished_ms.is_none() {
        return Ok(None);
    }
    let runs = app.store.wrong_runs(row.id).await?;
    Ok((runs > 0).then(|| {
        format!(
            "{runs} of its runs are from a worker that was found to deliver wrong sums; `shearwater retry {}` renders \
             them again",
            row.id
        )
    }))
}

/// State and progress: a function of the row and of the time.
fn progress(row: JobRow, now_ms: i64) -> JobView {
    let units_total = row.units_due;
    let state = job_state(&JobCounts {
        cancelled: row.ended == Ended::Cancelled,
        failed: matches!(row.ended, Ended::Failed(..)),
        paused: row.paused_ms.is_some(),
        frames: u64::from(row.settings.frames),
        frames_done: row.frames_done,
        units_done: row.units_done,
        units_leased: row.units_leased,
    });
    let to_ms = match state {
        JobState::Queued | JobState::Running => Some(now_ms),
        JobState::Paused => row.paused_ms,
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
    let (width, height) = (row.settings.width, row.settings.height);
    let pixels = u64::from(width) * u64::from(height) * u64::from(row.settings.frames);
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
        stopped_by: row.stopped,
        samples_min: row.samples_range.map(|(least, _)| least),
        samples_max: row.samples_range.map(|(_, most)| most),
        samples_mean: row.samples_done as f64 / pixels.max(1) as f64,
        note: None,
        units_total,
        units_done: row.units_done,
        samples_done: row.samples_done,
        progress: row.units_done as f64 / units_total.max(1) as f64,
        elapsed_s,
        samples_per_s,
        core_s: row.core_us as f64 / 1e6,
        remaining_s: (!state.is_final() && state != JobState::Paused && samples_per_s > 0.0)
            .then(|| left / samples_per_s),
        target_s: None,
        error: None,
        error_frame: None,
        nmse_at_end: None,
        newest_error: None,
        bad_samples: row.bad_samples,
        depth_cap_hits: row.depth_cap_hits,
        unequal_results: row.unequal_results,
        audits: row.audits,
        film_hashes: Vec::new(),
        webhook: None,
        rev: row.rev,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view() -> JobView {
        serde_json::from_value(serde_json::json!({
            "id": 1, "name": "picture", "state": "running", "done": false,
            "scene_hash": "0".repeat(64), "priority": 0, "submitted_ms": 0, "units_total": 8,
            "units_done": 1, "samples_done": 6400, "progress": 0.1, "samples_per_s": 100.0,
            "elapsed_s": 64.0, "core_s": 64.0, "remaining_s": 1000.0, "bad_samples": 0,
            "depth_cap_hits": 0, "film_hashes": [], "rev": 1,
            "settings": {"width": 10, "height": 10, "samples": 1064,
                "stop": {"error": 0.01}},
            "error": {"mse": 1.0, "nmse": 1.0, "worst_tile": 0, "worst_tile_nmse": 1.0,
                "relmse": 0.04, "worst_tile_relmse": 1.0, "worst_relmse_tile": 0, "mean": 1.0,
                "mean_interval": 0.1, "pixels": 100, "samples": 6400, "repeated_tiles": 0,
                "firefly_share": null},
        }))
        .expect("a job")
    }

    #[test]
    fn seconds_to_the_target_follow_the_error() {
        // A quarter of the error takes four times the samples: three times what is done.
        assert_eq!(target_s(&view()), Some(3.0 * 64.0));
        let mut late = view();
        late.settings.samples = 164;
        assert_eq!(target_s(&late), Some(100.0), "its samples end first");
        let mut there = view();
        if let Some(detail) = there.error.as_mut().and_then(|e| e.detail.as_mut()) {
            detail.relmse = 0.005;
        }
        assert_eq!(target_s(&there), Some(0.0));
        let mut film = view();
        film.settings.frames = 2;
        let mut plain = view();
        plain.settings.stop.error = None;
        let mut begun = view();
        begun.error = None;
        for none in [film, plain, begun] {
            assert_eq!(target_s(&none), None);
        }
    }
}
