//! `shearwater jobs`.

use crate::args::Target;
use crate::exit::CliError;
use crate::output;
use clap::Args;
use serde_json::json;
use shearwater_shared::api::JobView;

/// Jobs asked for in one call.
const PAGE: usize = 100;

/// List jobs, newest first
#[derive(Args, Debug)]
pub(crate) struct Jobs {
    /// Show at most this many
    #[arg(long, value_name = "N", default_value_t = 50)]
    limit: usize,
    #[command(flatten)]
    target: Target,
}

pub(crate) async fn run(args: &Jobs, json: bool) -> Result<(), CliError> {
    let api = args.target.api()?;
    let mut jobs: Vec<JobView> = Vec::new();
    let mut token: Option<String> = None;
    while jobs.len() < args.limit {
        let page_size = PAGE.min(args.limit - jobs.len());
        let page = api.jobs(page_size, token.as_deref()).await?;
        jobs.extend(page.jobs);
        token = page.next_page_token;
        if token.is_none() {
            break;
        }
    }
    jobs.truncate(args.limit);
    if json {
        let jobs: Vec<_> = jobs.iter().map(output::job_value).collect();
        output::object(&json!({ "jobs": jobs }));
    } else {
        print_table(&jobs);
    }
    Ok(())
}

fn print_table(jobs: &[JobView]) {
    output::line(format_args!(
        "{:>6}  {:9}  {:>7}  {:>11}  {:>6}  {:>6}  NAME",
        "ID", "STATE", "DONE", "SIZE", "SPP", "FRAMES"
    ));
    for job in jobs {
        let size = format!("{}x{}", job.settings.width, job.settings.height);
        output::line(format_args!(
            "{:>6}  {:9}  {:>5.1} %  {size:>11}  {:>6}  {:>6}  {}",
            job.id.0,
            output::state_text(job.state),
            job.progress * 100.0,
            job.settings.samples,
            job.settings.frames,
            job.name
        ));
    }
}
