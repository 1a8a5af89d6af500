//! Following a job to its end, with a progress bar.

use crate::api::Api;
use crate::error_text;
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
        let files_before = files_of(writer.as_deref());
        match step(api, id, bar, writer.as_deref_mut()).await {
            Ok(job) if job.done => {
                bar.finish_and_clear();
                return Ok(job);
            }
            Ok(_) => away_since = None,
            Err(error @ (CliError::Unreachable { .. } | CliError::Silent { .. })) => {
                // Who gave a picture meanwhile was not away.
                if files_of(writer.as_deref()) > files_before {
                    away_since = None;
                }
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

fn files_of(writer: Option<&FrameWriter>) -> usize {
    writer.map_or(0, |writer| writer.files.len())
}

/// Ask once and write what was finished since. What an error leaves unwritten is
/// written by the next step.
async fn step(
    api: &Api,
    id: JobId,
    bar: &ProgressBar,
    writer: Option<&mut FrameWriter>,
) -> Result<JobView, CliError> {
    let job = api.job(id).await?;
    show(bar, &job);
    if let Some(writer) = writer {
        writer.catch_up(api, &job).await?;
    }
    Ok(job)
}

fn show(bar: &ProgressBar, job: &JobView) {
    bar.set_length(job.units_total);
    bar.set_position(job.units_done);
    let mut message = format!("{} samples/s", scaled(job.samples_per_s));
    if job.settings.frames > 1 {
        let (done, all) = (job.frames_done, job.settings.frames);
        message.push_str(&format!("  {done} of {all} frames"));
    }
    if let Some(error) = error_text::short(job) {
        message.push_str(&format!("  {error}"));
    }
    if let Some(left) = job.remaining_s {
        message.push_str(&format!("  {} left", duration(left)));
    }
    bar.set_message(message);
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};
    use shearwater_worker::connection::Access;
    use std::io::{BufRead, BufReader, Write};
    use std::net::TcpListener;

    /// A job of one frame that is done.
    fn job() -> Value {
        json!({
            "id": 1, "name": "film", "state": "done", "done": true, "scene_hash": "0".repeat(64),
            "settings": {"width": 1, "height": 1, "samples": 2, "seed": 0, "frames": 1},
            "priority": 0, "submitted_ms": 0, "frames_done": 1, "units_total": 1, "units_done": 1,
            "samples_done": 2, "progress": 1.0, "samples_per_s": 1.0,
            "elapsed_s": 1.0, "core_s": 1.0, "bad_samples": 0, "depth_cap_hits": 0,
            "film_hashes": [], "rev": 1,
        })
    }

    fn frames() -> Value {
        let frame = json!({
            "frame": 0, "state": "done", "units_total": 1, "units_done": 1,
        });
        json!({"frames": [frame]})
    }

    /// A coordinator whose every answer but the job's fails once.
    fn serve(listener: &TcpListener) {
        let mut failed = std::collections::BTreeSet::new();
        for connection in listener.incoming() {
            let mut connection = connection.expect("connection");
            let mut lines = BufReader::new(connection.try_clone().expect("clone")).lines();
            let first = lines.next().expect("request").expect("line");
            while lines
                .next()
                .is_some_and(|line| !line.expect("line").is_empty())
            {}
            let path = first.split([' ', '?']).nth(1).expect("path").to_owned();
            let (status, body) = match path.as_str() {
                "/v1/jobs/1" => (200, job().to_string()),
                _ if failed.insert(path.clone()) => (503, "busy".to_owned()),
                path if path.ends_with("/frames") => (200, frames().to_string()),
                _ => (200, path),
            };
            let length = body.len();
            let answer = format!(
                "HTTP/1.1 {status} -\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n{body}"
            );
            connection.write_all(answer.as_bytes()).expect("answer");
        }
    }

    #[tokio::test]
    async fn a_coordinator_that_fails_between_two_pictures_is_asked_again() {
        let listener = TcpListener::bind("127.0.0.1:0").expect("port");
        let url = format!("http://{}", listener.local_addr().expect("address"));
        std::thread::spawn(move || serve(&listener));
        let folder = tempfile::tempdir().expect("folder");
        let mut writer = FrameWriter::new(folder.path());
        let api = Api::new(&url, &Access::default()).expect("address");
        let job = to_end_with(&api, JobId(1), &bar(true), Some(&mut writer)).await;
        assert!(job.expect("patience").done);
        let names: Vec<_> = writer.files.iter().map(|file| file.file_name()).collect();
        assert_eq!(
            names,
            ["film.png", "film.exr"].map(|name| Some(name.as_ref()))
        );
        assert!(writer.files.iter().all(|file| file.is_file()));
    }
}
