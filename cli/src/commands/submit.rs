//! `shearwater submit`.

use crate::args::{self, Settings, Target};
use crate::exit::CliError;
use crate::{output, scene_files};
use clap::Args;
use shearwater_shared::api::WebhookRequest;
use std::path::PathBuf;

/// Submit a scene to a coordinator
///
/// Uploads the files that the coordinator lacks and prints the job's number.
///
/// Example: shearwater submit scene.json --spp 1024 --coordinator http://farm:7788
#[derive(Args, Debug)]
pub(crate) struct Submit {
    /// scene.json, or the folder that holds it
    scene: PathBuf,
    #[command(flatten)]
    settings: Settings,
    /// Name of the job [default: the scene's]
    #[arg(long)]
    name: Option<String>,
    /// Jobs of higher priority are served first, those of the same share the workers; -1000 to 1000
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0,
        allow_negative_numbers = true,
        value_parser = args::parse_priority
    )]
    priority: i32,
    /// Address that is told when the job ends
    #[arg(long, value_name = "URL")]
    webhook: Option<String>,
    /// Signs what is told [default: the farm's]
    #[arg(long, value_name = "TEXT", requires = "webhook")]
    webhook_secret: Option<String>,
    #[command(flatten)]
    target: Target,
}

pub(crate) async fn run(args: &Submit, json: bool) -> Result<(), CliError> {
    let bundle = scene_files::collect(&args.scene)?;
    let api = args.target.api()?;
    let settings = args.settings.to_override();
    let webhook = args.webhook.as_ref().map(|url| WebhookRequest {
        url: url.clone(),
        secret: args.webhook_secret.clone(),
    });
    let job = api
        .submit(&bundle, args.name.clone(), settings, args.priority, webhook)
        .await?;
    if json {
        output::object(&output::job_value(&job));
    } else {
        output::line(format_args!("job {} ({})", job.id, job.name));
    }
    Ok(())
}
