//! `shearwater workers`.

use crate::args::Target;
use crate::exit::CliError;
use crate::output;
use clap::Args;
use serde_json::json;
use shearwater_shared::api::WorkerView;

/// List the workers that were heard of within five minutes
///
/// A worker that gets nothing is shown with the reason.
#[derive(Args, Debug)]
pub(crate) struct Workers {
    #[command(flatten)]
    target: Target,
}

pub(crate) async fn run(args: &Workers, json: bool) -> Result<(), CliError> {
    let api = args.target.api()?;
    let mut workers: Vec<WorkerView> = Vec::new();
    let mut token: Option<String> = None;
    loop {
        let page = api.workers(token.as_deref()).await?;
        workers.extend(page.workers);
        token = page.next_page_token;
        if token.is_none() {
            break;
        }
    }
    if json {
        output::object(&json!({ "workers": workers }));
        return Ok(());
    }
    output::line(format_args!(
        "{:>7}  {:>12}  {:>8}  {:>5}  NAME (INSTANCE)",
        "THREADS", "SAMPLES/S", "SILENT", "TILES"
    ));
    for worker in &workers {
        output::line(format_args!(
            "{:>7}  {:>12.0}  {:>6.1} s  {:>5}  {} ({})",
            worker.threads,
            worker.samples_per_s,
            worker.silent_ms as f64 / 1000.0,
            worker.runs_held,
            worker.worker.name,
            worker.worker.instance
        ));
        if let Some(seconds) = worker.quarantined_s {
            let reason = worker.quarantine_reason.as_deref().unwrap_or("failures");
            output::line(format_args!(
                "{:>9}gets nothing for {seconds} s: {reason}",
                ""
            ));
        }
    }
    Ok(())
}
