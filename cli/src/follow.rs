//! Following a job to its end, with a progress bar.

use crate::api::Api;
use crate::exit::CliError;
use crate::frames::FrameWriter;
use crate::output::{duration, scaled};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use shearwater_shared::api::JobView;
use shearwater_shared::job::JobId;
use std::time::{Duration, Instant};

/// How often to ask: often enough for a bar, rare enough for a coordinator
/// with many watchers.
const EVERY: Duration = Duration::from_millis(250);
/// How long a coordinator may be away while somebody watches: a restart.
const AWAY_MAX: Duration = Duration::from_secs(60);

/// A bar on standard error; hidden for programs and where there is no terminal.
pub(crate) fn bar(json: bool) -> ProgressBar {
    if json {
        return ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
    }
    let bar = ProgressBar::new(0);
    if let Ok(style) = ProgressStyle::with_template("{bar:32} {percent:>3} %  {msg}") {
        bar.set_style(style);
    }
    bar
}

/// Ask for the job until no further change will come.
pub(crate) async fn to_end(api: &Api, id: JobId, bar: &ProgressBar) -> Result<JobView, CliError> {
    to_end_with(api, id, bar, None).await
}

/// The same, and write each frame when it is finished.
pub(crate) async fn to_end_with(
    api: &Api,
    id: JobId,
    bar: &ProgressBar,
    mut writer: Option<&mut FrameWriter>,
) -> Result<JobView, CliError> {
    let mut away_since: Option<Instant> = None;
    loop {
        match api.job(id).await {
            Ok(job) => {
                away_since = None;
                show(bar, &job);
                if let Some(writer) = writer.as_deref_mut() {
                    writer.catch_up(api, &job).await?;
                }
                if job.done {
                    bar.finish_and_clear();
                    return Ok(job);
                }
            }
            Err(error @ CliError::Unreachable { .. }) => {
                let since = *away_since.get_or_insert_with(Instant::now);
                if since.elapsed() > AWAY_MAX {
                    return Err(error);
                }
                bar.set_message("waiting for the coordinator");
            }
            Err(error) => return Err(error),
        }
        tokio::time::sleep(EVERY).await;
    }
}

fn show(bar: &ProgressBar, job: &JobView) {
    bar.set_length(job.units_total);
    bar.set_position(job.units_done);
    let mut message = format!("{} samples/s", scaled(job.samples_per_s));
    if job.settings.frames > 1 {
        let (done, all) = (job.frames_done, job.settings.frames);
        message.push_str(&format!("  {done} of {all} frames"));
    }
    if let Some(error) = &job.error {
        message.push_str(&format!("  NMSE {:.1e}", error.nmse));
    }
    if let Some(left) = job.remaining_s {
        message.push_str(&format!("  {} left", duration(left)));
    }
    bar.set_message(message);
}
