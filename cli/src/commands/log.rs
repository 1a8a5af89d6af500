//! `shearwater log`.

use crate::args::Target;
use crate::exit::CliError;
use crate::output;
use clap::Args;
use serde_json::json;
use shearwater_shared::api::LogEvent;
use shearwater_shared::job::JobId;

/// Events asked for in one call.
const PAGE: usize = 500;

/// Show what happened to a job's units, newest first
///
/// Leases, results, failures, expiries, audits, each with its worker and units: f0 t3 b0-2 is frame 0 of the
/// job, tile 3, blocks 0 and 1.
#[derive(Args, Debug)]
pub(crate) struct Log {
    /// Number of the job
    id: i64,
    /// Show at most this many events
    #[arg(long, value_name = "N", default_value_t = 100)]
    limit: usize,
    #[command(flatten)]
    target: Target,
}

pub(crate) async fn run(args: &Log, json: bool) -> Result<(), CliError> {
    let api = args.target.api()?;
    let mut events: Vec<LogEvent> = Vec::new();
    let mut token: Option<String> = None;
    while events.len() < args.limit {
        let size = PAGE.min(args.limit - events.len());
        let page = api.log(JobId(args.id), size, token.as_deref()).await?;
        events.extend(page.events);
        token = page.next_page_token;
        if token.is_none() {
            break;
        }
    }
    if json {
        output::object(&json!({ "events": events }));
    } else {
        events.iter().for_each(|event| output::line(text(event)));
    }
    Ok(())
}

fn text(event: &LogEvent) -> String {
    let kind = serde_json::to_value(event.kind).unwrap_or_default();
    let kind = kind.as_str().unwrap_or_default();
    let mut text = format!("{:>8}  {}  {kind:13}", event.seq, event.at_ms);
    let mut add = |part: String| {
        text.push(' ');
        text.push_str(&part);
    };
    if let Some(worker) = &event.worker {
        add(format!("worker {worker}"));
    }
    if let Some(lease) = event.lease {
        add(format!("lease {lease}"));
    }
    for run in &event.runs {
        let (frame, tile) = (run.frame, run.tile);
        add(format!("f{frame} t{tile} b{}-{}", run.block0, run.block1));
    }
    if let Some(ms) = event.ms {
        add(format!("{ms} ms"));
    }
    if let Some(more) = &event.text {
        add(more.clone());
    }
    text
}
