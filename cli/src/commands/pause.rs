//! `shearwater pause`.

use crate::args::Target;
use crate::exit::CliError;
use crate::output;
use clap::Args;
use shearwater_shared::job::JobId;
use shearwater_shared::routes;

/// Hand out nothing more of a job until `resume`
///
/// What workers have begun is finished and counted. The pause does not count for the time of a job that stops
/// after some seconds.
#[derive(Args, Debug)]
pub(crate) struct Pause {
    /// Number of the job
    id: i64,
    #[command(flatten)]
    target: Target,
}

pub(crate) async fn run(args: &Pause, json: bool) -> Result<(), CliError> {
    let api = args.target.api()?;
    let job = api.steer(routes::JOB_PAUSE, JobId(args.id)).await?;
    output::job_state(&job, json);
    Ok(())
}
