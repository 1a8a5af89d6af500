//! `shearwater render`: a farm of one machine.

use crate::api::{Api, Picture};
use crate::args::{Film, Local, Settings};
use crate::commands::coordinator;
use crate::exit::CliError;
use crate::frames::{self, FrameWriter};
use crate::scene_files::{self, Bundle};
use crate::{error_text, follow, memory, output, signals};
use clap::Args;
use serde_json::json;
use shearwater_shared::api::JobView;
use shearwater_worker::connection::Access;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use tokio::sync::oneshot;

/// Render a scene on this machine
///
/// Starts the real coordinator on a free local port with a temporary store and
/// the real worker beside it, and writes NAME.png and NAME.exr. A scene with
/// `animation` gives NAME.0000.png and so on, each as soon as it is finished,
/// and NAME.mp4 where ffmpeg is installed. The film hash that it prints is the same on every machine, with any number of threads.
///
/// Example: shearwater render scenes/golden-gate/scene.json --size 512x256 --spp 64 -o out
#[derive(Args, Debug)]
pub(crate) struct Render {
    /// scene.json, or the folder that holds it
    scene: PathBuf,
    /// Folder to write to; made if need be
    #[arg(short, long, value_name = "DIR", default_value = "out")]
    output: PathBuf,
    #[command(flatten)]
    settings: Settings,
    #[command(flatten)]
    film: Film,
    #[command(flatten)]
    local: Local,
}

/// Files named one by one; of more, only the first and the last.
const FILES_LISTED_MAX: usize = 8;

/// What a render gave.
struct Rendered {
    job: JobView,
    frames: FrameWriter,
    video: Option<PathBuf>,
}

pub(crate) async fn run(args: &Render, json: bool) -> Result<(), CliError> {
    let started = std::time::Instant::now();
    // Listened for first: until then a signal would end the program at once
    // and leave the temporary store behind.
    let interrupted = signals::asked_to_end();
    let bundle = scene_files::collect(&args.scene)?;
    // Said now rather than after an hour of rendering.
    std::fs::create_dir_all(&args.output).map_err(CliError::io(&args.output))?;
    let store = tempfile::Builder::new()
        .prefix("shearwater-")
        .tempdir()
        .map_err(CliError::io(&std::env::temp_dir()))?;
    let loopback = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
    let mut config = coordinator::in_folder(store.path(), loopback);
    // There is no second worker to ask.
    config.audit_ppm = 0;
    let farm = coordinator::start(config).await?;
    let url = format!("http://{}", farm.addr());
    let rendered = tokio::select! {
        rendered = with_worker(args, &bundle, &url, json) => rendered,
        () = interrupted => Err(CliError::Interrupted),
    };
    farm.shutdown().await;
    let rendered = rendered?;
    report(&rendered, started.elapsed().as_secs_f64(), json);
    Ok(())
}

async fn with_worker(
    args: &Render,
    bundle: &Bundle,
    url: &str,
    json: bool,
) -> Result<Rendered, CliError> {
    let (stop, stopped) = oneshot::channel::<()>();
    let mut config = args.local.config(url.to_owned(), "local".to_owned());
    // There is no other worker: waiting would be for nothing.
    config.leave_when_quarantined = true;
    let worker = shearwater_worker::run(config, async {
        let _ = stopped.await;
    });
    tokio::pin!(worker);
    let rendered = tokio::select! {
        rendered = submit_and_wait(args, bundle, url, json) => rendered,
        ended = &mut worker => {
            ended?;
            return Err(CliError::Coordinator("the worker ended by itself".into()));
        }
    };
    let _ = stop.send(());
    // The picture is there: how the worker leaves changes nothing.
    let _ = worker.await;
    rendered
}

async fn submit_and_wait(
    args: &Render,
    bundle: &Bundle,
    url: &str,
    json: bool,
) -> Result<Rendered, CliError> {
    let api = Api::new(url, &Access::default())?;
    let settings = args.settings.to_override();
    let job = api.submit(bundle, None, settings, 0, None).await?;
    let mut frames = FrameWriter::new(&args.output);
    let job = follow::to_end_with(&api, job.id, &follow::bar(json), Some(&mut frames)).await?;
    CliError::of_job(&job).map_err(|error| bundle.at_file(error))?;
    let video = args.film.make(&job, &args.output).await;
    Ok(Rendered { job, frames, video })
}

fn report(rendered: &Rendered, total_s: f64, json: bool) {
    let job = &rendered.job;
    let frames = rendered.frames.written();
    let hashes: Vec<_> = frames.values().map(|frame| frame.film_hash).collect();
    let nmse = job.error.map(|error| error.nmse);
    let peak = memory::peak_bytes();
    if json {
        output::object(&json!({
            "film_hash": hashes.first(),
            "film_hashes": hashes,
            "frames": rendered.frames.json(),
            "scene_hash": job.scene_hash,
            "name": job.name,
            "width": job.settings.width,
            "height": job.settings.height,
            "spp": job.settings.samples,
            "seed": job.settings.seed,
            "samples": job.samples_done,
            "stopped_by": job.stopped_by,
            "samples_min": job.samples_min,
            "samples_mean": job.samples_mean,
            "samples_max": job.samples_max,
            "samples_per_s": job.samples_per_s,
            "seconds": job.elapsed_s,
            "total_seconds": total_s,
            "core_seconds": job.core_s,
            "nmse": nmse,
            "error": job.error,
            "bad_samples": job.bad_samples,
            "depth_cap_hits": job.depth_cap_hits,
            "peak_memory_bytes": peak,
            "files": rendered.frames.files,
            "video": rendered.video,
        }));
        return;
    }
    let mut rows = output::film_rows(job);
    rows.extend(output::stop_rows(job));
    rows.extend([
        ("speed", error_text::speed(job)),
        (
            "seconds",
            format!("{:.2} ({total_s:.2} in all)", job.elapsed_s),
        ),
    ]);
    rows.extend(error_text::rows(job));
    if let Some(peak) = peak {
        rows.push(("peak memory", format!("{} MiB", peak >> 20)));
    }
    if job.bad_samples > 0 {
        rows.push(("bad samples", job.bad_samples.to_string()));
    }
    rows.extend(written(rendered));
    output::line(output::table(&rows));
}

/// A row for each file; of many, the first and the last of each kind.
fn written(rendered: &Rendered) -> Vec<(&'static str, String)> {
    let files = &rendered.frames.files;
    let line = |text: String| ("wrote", text);
    let mut rows: Vec<_> = if files.len() <= FILES_LISTED_MAX {
        files
            .iter()
            .map(|file| line(file.display().to_string()))
            .collect()
    } else {
        let job = &rendered.job;
        let stem = |frame| frames::stem(job, frame);
        let (first, last) = (job.settings.first_frame, job.settings.last_frame());
        let folder = files.first().and_then(|file| file.parent());
        let folder = folder.unwrap_or(Path::new(""));
        Picture::ALL
            .map(|picture| {
                let ending = picture.extension();
                let from = folder.join(format!("{}.{ending}", stem(first)));
                line(format!("{} to {}.{ending}", from.display(), stem(last)))
            })
            .into()
    };
    rows.extend(
        rendered
            .video
            .iter()
            .map(|film| line(film.display().to_string())),
    );
    rows
}
