//! `shearwater priority`.

use crate::args::{self, Target};
use crate::exit::CliError;
use crate::output;
use clap::Args;
use shearwater_shared::api::ChangeJob;
use shearwater_shared::job::JobId;

/// Change the priority of a job
///
/// Counts from the next lease on. Jobs of higher priority are served first; jobs of the same priority share the
/// workers evenly.
///
/// Example: shearwater priority 12 50
#[derive(Args, Debug)]
pub(crate) struct SetPriority {
    /// Number of the job
    id: i64,
    /// The new priority, -1000 to 1000; jobs have 0 when nobody says otherwise
    #[arg(allow_negative_numbers = true, value_parser = args::parse_priority)]
    priority: i32,
    #[command(flatten)]
    target: Target,
}

pub(crate) async fn run(args: &SetPriority, json: bool) -> Result<(), CliError> {
    let asked = ChangeJob {
        priority: Some(args.priority),
    };
    let api = args.target.api()?;
    let job = api.change(JobId(args.id), &asked).await?;
    if json {
        output::object(&output::job_value(&job));
    } else {
        output::line(format_args!("job {} has priority {}", job.id, job.priority));
    }
    Ok(())
}
