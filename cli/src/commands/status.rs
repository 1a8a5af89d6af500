//! `shearwater status`.

use crate::api::Api;
use crate::args::Target;
use crate::exit::CliError;
use crate::output;
use clap::Args;
use shearwater_shared::job::JobId;

/// Show where a job stands
///
/// Ends with 0 whatever the job's state; `watch` ends with 1 when it failed.
#[derive(Args, Debug)]
pub(crate) struct Status {
    /// Number of the job
    id: i64,
    #[command(flatten)]
    target: Target,
}

pub(crate) async fn run(args: &Status, json: bool) -> Result<(), CliError> {
    let job = Api::new(&args.target.url)?.job(JobId(args.id)).await?;
    if json {
        output::object(&output::job_value(&job));
    } else {
        output::line(output::job_text(&job));
    }
    Ok(())
}
