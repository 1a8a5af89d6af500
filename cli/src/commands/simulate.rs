//! `shearwater simulate`: a coordinator under thousands of workers that render
//! nothing.

use crate::access::AccessArgs;
use crate::args::Size;
use crate::exit::CliError;
use crate::simulation::running::{Running, SimulationPlan};
use crate::simulation::work;
use crate::{open_files, output, signals};
use clap::Args;
use shearwater_shared::limits;
use shearwater_worker::simulate::Habits;
use std::path::PathBuf;
use std::time::Duration;

/// Measure a coordinator under thousands of simulated workers
///
/// The workers speak the real protocol over HTTP, each over connections of its own,
/// and sleep where a worker renders; what they deliver is checked to the last bit
/// at the end. Without --coordinator it starts a coordinator of its own, as a
/// process of its own with a temporary store, and measures that one's memory and
/// CPU time as well. Never point it at a farm that is in use: it refuses to start
/// while there is any other job.
///
/// Each worker needs two or three open files on either side: 5000 of them need
/// `ulimit -n` of 16384.
///
/// Example: shearwater simulate --workers 5000 --units 1000000 --unit-ms 2000
#[derive(Args, Debug)]
pub(crate) struct Simulate {
    /// URL of a running coordinator [default: start one]
    #[arg(long = "coordinator", value_name = "URL", conflicts_with_all = ["data", "database", "objects", "audit", "program"])]
    url: Option<String>,
    #[command(flatten)]
    access: AccessArgs,
    /// Folder of the own coordinator's store; stays [default: a temporary one]
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Database of the own coordinator [default: a file in its folder]
    #[arg(long, value_name = "URL")]
    database: Option<String>,
    /// Object store of the own coordinator [default: a folder in its folder]
    #[arg(long, value_name = "URL")]
    objects: Option<String>,
    /// Program of the own coordinator: another build, to compare [default: this one]
    #[arg(long, value_name = "FILE")]
    program: Option<PathBuf>,
    /// Share of the runs that the own coordinator has rendered again [default: the coordinator's]
    #[arg(long, value_name = "SHARE", value_parser = share)]
    audit: Option<f64>,
    /// Workers
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    workers: u32,
    /// Units of work, rounded up to whole frames
    #[arg(long, value_name = "N", default_value_t = 10_000, value_parser = clap::value_parser!(u64).range(1..=work::UNITS_MAX))]
    units: u64,
    /// Milliseconds that a unit takes one thread
    #[arg(long, value_name = "N", default_value_t = 1000.0, value_parser = positive)]
    unit_ms: f64,
    /// How much that differs from run to run, up and down
    #[arg(long, value_name = "SHARE", default_value_t = 0.25, value_parser = share)]
    jitter: f64,
    /// Share of the workers that take three times as long
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share)]
    slow: f64,
    /// Share of the runs that end in a report of failure
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share)]
    failure_rate: f64,
    /// Share of the runs at whose end the worker vanishes without a word; another one comes
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share)]
    vanish_rate: f64,
    /// Threads of each worker
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1024))]
    threads: u32,
    /// Frames of the job [default: one for 100 units, at most 10000]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(limits::FRAMES_MAX)))]
    frames: Option<u32>,
    /// Size of a frame; 1024x512 makes results as large as real ones
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "640x1")]
    picture: Size,
    /// Seconds over which the workers come [default: one for 500 workers]
    #[arg(long, value_name = "N", value_parser = positive)]
    ramp: Option<f64>,
    /// Seconds for which the workers wait before the job is submitted
    #[arg(long, value_name = "N", default_value_t = 0)]
    idle: u64,
    /// Stop after this many seconds of work, done or not
    #[arg(long, value_name = "N")]
    seconds: Option<u64>,
    /// Another seed, other jitter and failures
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
}

/// Units of a frame, unless something else is asked for.
const UNITS_PER_FRAME: u64 = 100;
/// Most frames, unless something else is asked for.
const FRAMES: u64 = 10_000;
/// Workers that come in a second.
const WORKERS_PER_S: f64 = 500.0;
/// Open files of a simulated worker: a connection for its long poll, one for
/// results, one for heartbeats.
const FILES_PER_WORKER: u64 = 3;

fn share(text: &str) -> Result<f64, String> {
    let share = text.parse().ok().filter(|n| (0.0..=1.0).contains(n));
    share.ok_or_else(|| "expected a number from 0 to 1".to_owned())
}

fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|n| (0.001..=1e9).contains(n));
    number.ok_or_else(|| "expected a number above 0".to_owned())
}

pub(crate) async fn run(args: &Simulate, json: bool) -> Result<(), CliError> {
    // Listened for first: until then a signal would end the program at once and
    // leave the temporary store behind.
    let interrupted = signals::asked_to_end();
    let files = open_files::raise();
    if files < u64::from(args.workers) * FILES_PER_WORKER {
        output::note(format_args!(
            "only {files} open files are allowed: {} workers may need {FILES_PER_WORKER} each; see `ulimit -Hn`",
            args.workers
        ));
    }
    let folder = tempfile::Builder::new()
        .prefix("shearwater-simulate-")
        .tempdir()
        .map_err(CliError::io(&std::env::temp_dir()))?;
    let mut running = Running::start(args.plan()?, folder.path()).await?;
    let ended = tokio::select! {
        ended = running.watch() => ended,
        () = interrupted => Err(CliError::Interrupted),
    };
    let (report, cleaned) = running.finish(ended).await;
    let report = report?;
    if json {
        let value = serde_json::to_value(&report);
        output::object(&value.map_err(|e| CliError::Simulation(e.to_string()))?);
    } else {
        output::line(report.text());
    }
    if report.audit.faults.is_empty() {
        return cleaned;
    }
    Err(CliError::Audit(report.audit.faults.join("; ")))
}

impl Simulate {
    fn plan(&self) -> Result<SimulationPlan, CliError> {
        let frames = (self.units / UNITS_PER_FRAME).clamp(1, FRAMES);
        let frames = self.frames.unwrap_or(frames as u32);
        let usual = f64::from(self.workers) / WORKERS_PER_S;
        let Size { width, height } = self.picture;
        Ok(SimulationPlan {
            url: self.url.clone(),
            access: self.access.read()?,
            program: self.program.clone(),
            data: self.data.clone(),
            database: self.database.clone(),
            objects: self.objects.clone(),
            audit: self.audit,
            workers: self.workers,
            ramp: Duration::from_secs_f64(self.ramp.unwrap_or(usual)),
            idle: Duration::from_secs(self.idle),
            bound: self.seconds.map(Duration::from_secs),
            settings: work::settings(self.units, frames, width, height)?,
            habits: Habits {
                unit_ms: self.unit_ms,
                jitter: self.jitter,
                slow_share: self.slow,
                failure_rate: self.failure_rate,
                vanish_rate: self.vanish_rate,
                threads: self.threads,
                seed: self.seed,
            },
        })
    }
}
