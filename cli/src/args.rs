//! The command line.

use crate::access::AccessArgs;
use crate::api::Api;
use crate::commands::{
    add, cancel, compare, coordinator, download, export, gc, jobs, log, pause, priority, render,
    report, resume, retry, simulate, status, submit, token, watch, water, worker, workers,
};
use crate::exit::{self, CliError};
use crate::frames::{self, FrameRange};
use crate::logging::{self, LogFormat};
use crate::{output, video};
use clap::{Args, Parser, Subcommand, ValueEnum};
use shearwater_shared::api::{JobView, SettingsOverride};
use shearwater_shared::limits;
use shearwater_shared::stop::ErrorTarget;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Where a coordinator listens when nobody says otherwise.
pub(crate) const DEFAULT_LISTEN: &str = "127.0.0.1:7788";
const DEFAULT_URL: &str = "http://127.0.0.1:7788";

/// A render farm in one binary: a coordinator splits pictures into runs of
/// samples, workers trace them, and the picture has the same bits however many
/// workers took part and whatever happened on the way.
#[derive(Parser, Debug)]
#[command(name = "shearwater", version, after_help = examples())]
pub(crate) struct Cli {
    #[command(flatten)]
    pub(crate) global: Global,
    #[command(subcommand)]
    pub(crate) command: Command,
}

fn examples() -> String {
    format!(
        "\
Examples:
  One picture on this machine:
    shearwater render scenes/golden-gate/scene.json -o out
  A quick look:
    shearwater render scene.json --size 512x256 --spp 16
  The second second of a moving picture, as numbered files and, with ffmpeg, an MP4:
    shearwater render scenes/fly-past --frames 24..48 -o out
  A farm: one coordinator, any number of workers, jobs from anywhere:
    shearwater token create --role admin --data /var/lib/shearwater
    shearwater coordinator --data /var/lib/shearwater --listen 10.0.0.1:7788
    SHEARWATER_TOKEN=sw_... shearwater worker --coordinator http://farm:7788
    shearwater submit scene.json --coordinator http://farm:7788
    shearwater watch 1 --coordinator http://farm:7788
    shearwater download 1 -o out --coordinator http://farm:7788

{}",
        exit::HELP
    )
}

/// Options of every command.
#[derive(Args, Debug)]
pub(crate) struct Global {
    /// Print one JSON object on standard output instead of text
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Log more on standard error; twice for everything
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub(crate) verbose: u8,
    /// How the log on standard error looks
    #[arg(
        long,
        global = true,
        value_enum,
        default_value_t,
        value_name = "FORMAT",
        env = "SHEARWATER_LOG_FORMAT"
    )]
    pub(crate) log_format: LogFormat,
}

/// What to do.
#[derive(Subcommand, Debug)]
pub(crate) enum Command {
    Render(render::Render),
    Coordinator(coordinator::Serve),
    Worker(worker::Work),
    Submit(submit::Submit),
    Status(status::Status),
    Watch(watch::Watch),
    Add(add::Add),
    Download(download::Download),
    Cancel(cancel::Cancel),
    Jobs(jobs::Jobs),
    Token(token::Token),
    Pause(pause::Pause),
    Resume(resume::Resume),
    Retry(retry::Retry),
    Priority(priority::SetPriority),
    Log(log::Log),
    Workers(workers::Workers),
    Compare(compare::Compare),
    Report(report::Report),
    Water(water::Water),
    Export(export::Export),
    Gc(gc::Gc),
    Simulate(simulate::Simulate),
    /// Print the JSON Schema of scene.json
    ///
    /// Point your editor at it: every field, its unit, range and default.
    Schema,
}

impl Command {
    /// What it has to log.
    pub(crate) const fn log_kind(&self) -> logging::Kind {
        match self {
            Self::Coordinator(_) | Self::Worker(_) => logging::Kind::Service,
            Self::Simulate(_) => logging::Kind::Crowd,
            _ => logging::Kind::Client,
        }
    }
}

/// Which coordinator.
#[derive(Args, Debug)]
pub(crate) struct Target {
    /// URL of the coordinator
    #[arg(
        long = "coordinator",
        value_name = "URL",
        env = "SHEARWATER_COORDINATOR",
        default_value = DEFAULT_URL
    )]
    pub(crate) url: String,
    #[command(flatten)]
    pub(crate) access: AccessArgs,
}

impl Target {
    /// The API there.
    pub(crate) fn api(&self) -> Result<Api, CliError> {
        Api::new(&self.url, &self.access.read()?)
    }
}

/// What differs from the scene's own job.
#[derive(Args, Debug)]
pub(crate) struct Settings {
    /// Size of the picture in pixels, for example 1024x512 [default: the scene's]
    #[arg(long, value_name = "WIDTHxHEIGHT")]
    size: Option<Size>,
    /// Samples per pixel, an even number; powers of two converge best [default: the scene's]
    #[arg(long, value_name = "N", value_parser = parse_spp)]
    spp: Option<u32>,
    /// Stop where the error (relative MSE) is at most X, for example 0.01; --spp is then the most samples
    /// of any pixel [default: the scene's]
    #[arg(long, value_name = "X", value_parser = parse_error)]
    error: Option<ErrorTarget>,
    /// Stop after N seconds of rendering; --spp is then the most samples of any pixel [default: the scene's]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(limits::STOP_SECONDS_MAX)))]
    seconds: Option<u32>,
    /// Seed; another one gives an independent picture of the same scene [default: 0]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Frames of the animation: the first N, or A to B - 1 [default: all]
    #[arg(long, value_name = "N|A..B")]
    frames: Option<FrameRange>,
}

impl Settings {
    /// As the API wants it.
    pub(crate) fn to_override(&self) -> SettingsOverride {
        SettingsOverride {
            width: self.size.map(|size| size.width),
            height: self.size.map(|size| size.height),
            samples: self.spp,
            error: self.error,
            seconds: self.seconds,
            seed: self.seed,
            frames: self.frames.map(|range| range.count),
            first_frame: self.frames.map(|range| range.first),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Size {
    pub(crate) width: u32,
    pub(crate) height: u32,
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let side = |text: &str| {
            let side = text.trim().parse::<u32>().ok()?;
            (1..=limits::IMAGE_SIDE_MAX).contains(&side).then_some(side)
        };
        text.split_once(['x', 'X'])
            .and_then(|(w, h)| Some((side(w)?, side(h)?)))
            .map(|(width, height)| Self { width, height })
            .ok_or_else(|| {
                format!(
                    "expected WIDTHxHEIGHT, each 1 to {}, for example 1024x512",
                    limits::IMAGE_SIDE_MAX
                )
            })
    }
}

/// A job's place among the others.
pub(crate) fn parse_priority(text: &str) -> Result<i32, String> {
    let (least, most) = (limits::PRIORITY_MIN, limits::PRIORITY_MAX);
    text.parse::<i32>()
        .ok()
        .filter(|n| (least..=most).contains(n))
        .ok_or_else(|| format!("expected a whole number, {least} to {most}"))
}

pub(crate) fn parse_error(text: &str) -> Result<ErrorTarget, String> {
    let value = text.parse().map_err(|_| "expected a number".to_owned())?;
    ErrorTarget::new(value).map_err(|e| e.to_string())
}

pub(crate) fn parse_spp(text: &str) -> Result<u32, String> {
    text.parse::<u32>()
        .ok()
        .filter(|n| (2..=limits::SAMPLES_MAX).contains(n) && n.is_multiple_of(2))
        .ok_or_else(|| format!("expected an even number, 2 to {}", limits::SAMPLES_MAX))
}

/// What becomes of numbered pictures.
#[derive(Args, Debug)]
pub(crate) struct Film {
    /// Make no NAME.mp4 of several frames, or NAME.0024-0047.mp4 of a part (made where ffmpeg is installed)
    #[arg(long)]
    no_video: bool,
}

impl Film {
    /// The film of a job whose every frame is written to `folder`, if it is
    /// wanted and can be made. Why it cannot is said in one line.
    pub(crate) async fn make(&self, job: &JobView, folder: &Path) -> Option<PathBuf> {
        if self.no_video || job.settings.frames < 2 {
            return None;
        }
        let stem = frames::file_stem(&job.name);
        let film = video::make(job, folder, &stem).await;
        film.inspect_err(|why| output::note(why)).ok()
    }
}

/// How a worker works on this machine.
#[derive(Args, Debug)]
pub(crate) struct Local {
    /// Threads that render; changes the time, never the picture [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Which copy of the traversal to use; the bits are the same
    #[arg(
        long,
        env = "SHEARWATER_SIMD",
        value_enum,
        default_value = "auto",
        hide = true
    )]
    pub(crate) simd: Simd,
}

/// Which copy of the traversal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Simd {
    /// The fastest that this machine has.
    Auto,
    /// The one that every machine has.
    Portable,
}

impl Local {
    /// A worker for `url`.
    pub(crate) fn config(&self, url: String, name: String) -> shearwater_worker::Config {
        let mut config = shearwater_worker::Config::new(url, name);
        if let Some(threads) = self.threads {
            config.threads = threads.into();
        }
        config.portable_simd = self.simd == Simd::Portable;
        config
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_sound() {
        Cli::command().debug_assert();
    }

    #[test]
    fn sizes_and_samples() {
        let size = "512x256".parse::<Size>();
        assert_eq!(
            size,
            Ok(Size {
                width: 512,
                height: 256
            })
        );
        for bad in ["", "512", "x", "0x5", "5x0", "99999x5", "-1x5", "1x2x3"] {
            assert!(bad.parse::<Size>().is_err(), "{bad}");
        }
        assert_eq!(parse_spp("64"), Ok(64));
        for bad in ["", "0", "1", "63", "-2", "1e3"] {
            assert!(parse_spp(bad).is_err(), "{bad}");
        }
    }
}
