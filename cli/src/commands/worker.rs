//! `shearwater worker`.

use crate::access::IdentityArgs;
use crate::args::{Local, Target};
use crate::exit::CliError;
use crate::{output, signals};
use clap::Args;
use serde_json::json;

/// Render for a coordinator
///
/// Needs no open port and no shared disk: it asks the coordinator for work and
/// for the files of the scenes. Start it before or after the coordinator; it
/// finds it again after every break. A signal lets it finish what it has begun.
///
/// Example: shearwater worker --coordinator http://farm:7788 --threads 8
#[derive(Args, Debug)]
pub(crate) struct Work {
    #[command(flatten)]
    local: Local,
    /// Name for people [default: the host's]
    #[arg(long)]
    name: Option<String>,
    #[command(flatten)]
    target: Target,
    #[command(flatten)]
    identity: IdentityArgs,
}

pub(crate) async fn run(args: &Work, json: bool) -> Result<(), CliError> {
    let name = args.name.clone().unwrap_or_else(host_name);
    let mut config = args.local.config(args.target.url.clone(), name);
    config.access = args.target.access.read()?;
    config.access.identity = args.identity.read()?;
    let summary = shearwater_worker::run(config, signals::asked_to_end_once()).await?;
    if json {
        output::object(&json!({
            "runs": summary.runs,
            "duplicates": summary.duplicates,
            "refused": summary.refused,
            "failures": summary.failures,
            "samples": summary.samples,
            "core_s": summary.core_s,
            "idle_s": summary.idle_s,
        }));
    } else {
        output::line(format_args!(
            "{} runs, {} samples, {:.1} core seconds, {:.1} of waiting for work",
            summary.runs, summary.samples, summary.core_s, summary.idle_s
        ));
    }
    Ok(())
}

fn host_name() -> String {
    ["/proc/sys/kernel/hostname", "/etc/hostname"]
        .iter()
        .find_map(|file| std::fs::read_to_string(file).ok())
        .map(|name| name.trim().to_owned())
        .filter(|name| !name.is_empty())
        .unwrap_or_else(|| "worker".to_owned())
}
