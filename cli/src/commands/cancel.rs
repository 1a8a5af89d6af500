//! `shearwater cancel`.

use crate::args::Target;
use crate::exit::CliError;
use crate::output;
use clap::Args;
use shearwater_shared::job::JobId;

/// Stop a job
///
/// What is rendered so far can still be downloaded.
#[derive(Args, Debug)]
pub(crate) struct Cancel {
    /// Number of the job
    id: i64,
    #[command(flatten)]
    target: Target,
}

pub(crate) async fn run(args: &Cancel, json: bool) -> Result<(), CliError> {
    let api = args.target.api()?;
    let id = JobId(args.id);
    api.cancel(id).await?;
    let job = api.job(id).await?;
    if json {
        output::object(&output::job_value(&job));
    } else {
        output::line(format_args!(
            "job {id} is {}",
            output::state_text(job.state)
        ));
    }
    Ok(())
}
