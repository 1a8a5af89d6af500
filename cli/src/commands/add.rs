//! `shearwater add`.

use crate::args::{self, Target};
use crate::exit::CliError;
use crate::output;
use clap::Args;
use shearwater_shared::api::AddSamples;
use shearwater_shared::job::JobId;
use shearwater_shared::limits;
use shearwater_shared::stop::ErrorTarget;

/// Add samples to a job
///
/// What is rendered stays; a job of 128 samples that goes on to 256 has the film of
/// one of 256, bit for bit. A job that stopped by time goes on to its samples.
///
/// Example: shearwater add 12 --spp 256
#[derive(Args, Debug)]
pub(crate) struct Add {
    /// Number of the job
    job: i64,
    /// Samples per pixel in all, an even number; of a job with an error target the most that any pixel gets
    #[arg(long, value_name = "N", value_parser = args::parse_spp)]
    spp: Option<u32>,
    /// Instead of --spp: samples per pixel to add
    #[arg(long, value_name = "N", value_parser = args::parse_spp, conflicts_with = "spp")]
    more: Option<u32>,
    /// A smaller error target, for a job that has one
    #[arg(long, value_name = "X", value_parser = args::parse_error)]
    error: Option<ErrorTarget>,
    /// Stop again N seconds after the next work is handed out
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(limits::STOP_SECONDS_MAX)))]
    seconds: Option<u32>,
    #[command(flatten)]
    target: Target,
}

pub(crate) async fn run(args: &Add, json: bool) -> Result<(), CliError> {
    let asked = AddSamples {
        samples: args.spp,
        add: args.more,
        error: args.error,
        seconds: args.seconds,
    };
    let api = args.target.api()?;
    let job = api.add_samples(JobId(args.job), &asked).await?;
    if json {
        output::object(&output::job_value(&job));
    } else {
        output::line(format!(
            "job {} goes on to {}",
            job.id,
            output::samples_text(&job)
        ));
    }
    Ok(())
}
