//! `shearwater retry`.

use crate::args::Target;
use crate::exit::CliError;
use crate::output;
use clap::Args;
use shearwater_shared::job::JobId;
use shearwater_shared::routes;

/// Try a failed job again
///
/// What is rendered stays; what failed is handed out once more. Also for a job that was done before one of its
/// workers was found to be wrong: what that had delivered is rendered again.
#[derive(Args, Debug)]
pub(crate) struct Retry {
    /// Number of the job
    id: i64,
    #[command(flatten)]
    target: Target,
}

pub(crate) async fn run(args: &Retry, json: bool) -> Result<(), CliError> {
    let api = args.target.api()?;
    let job = api.steer(routes::JOB_RETRY, JobId(args.id)).await?;
    output::job_state(&job, json);
    Ok(())
}
