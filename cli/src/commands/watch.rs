//! `shearwater watch`.

use crate::args::Target;
use crate::exit::CliError;
use crate::{follow, output, signals};
use clap::Args;
use shearwater_shared::job::JobId;

/// Follow a job to its end with a progress bar
///
/// Survives a restart of the coordinator. Interrupting it does not stop the
/// job; `cancel` does.
#[derive(Args, Debug)]
pub(crate) struct Watch {
    /// Number of the job
    id: i64,
    #[command(flatten)]
    target: Target,
}

pub(crate) async fn run(args: &Watch, json: bool) -> Result<(), CliError> {
    let api = args.target.api()?;
    let id = JobId(args.id);
    // A wrong address or number is said at once, not after a minute.
    api.job(id).await?;
    let bar = follow::bar(json);
    let job = tokio::select! {
        job = follow::to_end(&api, id, &bar) => job?,
        () = signals::asked_to_end() => return Err(CliError::Interrupted),
    };
    CliError::of_job(&job)?;
    if json {
        output::object(&output::job_value(&job));
    } else {
        output::line(output::job_text(&job));
    }
    Ok(())
}
