//! `shearwater download`.

use crate::args::{Film, Target};
use crate::exit::CliError;
use crate::frames::{self, FrameWriter};
use crate::output;
use clap::Args;
use serde_json::json;
use shearwater_shared::api::JobView;
use shearwater_shared::job::JobState;
use std::path::PathBuf;

/// Fetch the pictures of a job, finished or not
///
/// Writes NAME.png (developed) and NAME.exr (linear, with albedo, normal,
/// depth, variance and sample count); NAME.0000.png and so on for the frames of
/// an animation: those that are finished, and NAME.mp4 once all are.
#[derive(Args, Debug)]
pub(crate) struct Download {
    /// Number of the job
    id: i64,
    /// Folder to write to; made if need be
    #[arg(short, long, value_name = "DIR", default_value = "out")]
    output: PathBuf,
    /// Only this frame of the scene, finished or not [default: all finished ones]
    #[arg(long, value_name = "N")]
    frame: Option<u32>,
    #[command(flatten)]
    film: Film,
    #[command(flatten)]
    target: Target,
}

pub(crate) async fn run(args: &Download, json: bool) -> Result<(), CliError> {
    let api = args.target.api()?;
    let job = api.job(shearwater_shared::job::JobId(args.id)).await?;
    // The only frame of a job is fetched as far as it has come.
    let only = (job.settings.frames == 1).then_some(job.settings.first_frame);
    let mut writer = FrameWriter::new(&args.output);
    let mut video = None;
    if let Some(frame) = args.frame.or(only) {
        writer.files = frames::write_pictures(&api, &job, frame, &args.output).await?;
    } else {
        writer.catch_up(&api, &job).await?;
        video = film(args, &job, &writer).await?;
    }
    if json {
        output::object(&json!({
            "job": job.id,
            "done": job.done,
            "progress": job.progress,
            "frames": writer.json(),
            "files": writer.files,
            "video": video,
        }));
    } else {
        let files = writer.files.iter().chain(&video);
        files.for_each(|file| output::line(file.display()));
    }
    Ok(())
}

async fn film(
    args: &Download,
    job: &JobView,
    writer: &FrameWriter,
) -> Result<Option<PathBuf>, CliError> {
    let (written, all) = (writer.written().len(), job.settings.frames);
    if written == 0 {
        return Err(CliError::Job(format!(
            "job {}: none of its {all} frames is finished yet; --frame {} fetches one as far as \
             it has come",
            job.id, job.settings.first_frame
        )));
    }
    if job.state == JobState::Done {
        return Ok(args.film.make(job, &args.output).await);
    }
    output::note(format_args!(
        "{written} of {all} frames are finished; the film is made of all of them"
    ));
    Ok(None)
}
