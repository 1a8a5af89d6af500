//! `shearwater resume`.

use crate::args::Target;
use crate::exit::CliError;
use crate::output;
use clap::Args;
use shearwater_shared::job::JobId;
use shearwater_shared::routes;

/// Go on with a paused job
#[derive(Args, Debug)]
pub(crate) struct Resume {
    /// Number of the job
    id: i64,
    #[command(flatten)]
    target: Target,
}

pub(crate) async fn run(args: &Resume, json: bool) -> Result<(), CliError> {
    let api = args.target.api()?;
    let job = api.steer(routes::JOB_RESUME, JobId(args.id)).await?;
    output::job_state(&job, json);
    Ok(())
}
