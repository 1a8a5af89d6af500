//! `shearwater coordinator`.

use crate::args::DEFAULT_LISTEN;
use crate::exit::CliError;
use crate::{output, signals};
use clap::Args;
use serde_json::json;
use shearwater_coordinator::{Config, Coordinator};
use std::net::SocketAddr;
use std::path::PathBuf;

/// Run the coordinator: jobs, leases, results, pictures
///
/// Everything it knows is in the data folder; kill it at any moment and start
/// it again, and no finished sample is lost. Port 0 takes a free one; the first
/// line of its output says which.
///
/// Example: shearwater coordinator --data /var/lib/shearwater --listen 0.0.0.0:7788
#[derive(Args, Debug)]
pub(crate) struct Serve {
    /// Folder of the database and the objects; made if need be
    #[arg(long, value_name = "DIR", default_value = "shearwater-data")]
    data: PathBuf,
    /// Address to listen on
    #[arg(long, value_name = "ADDRESS:PORT", default_value = DEFAULT_LISTEN)]
    listen: SocketAddr,
}

pub(crate) async fn run(args: &Serve, json: bool) -> Result<(), CliError> {
    let coordinator = start(Config::new(&args.data, args.listen)).await?;
    let url = format!("http://{}", coordinator.addr());
    if json {
        output::object(&json!({ "url": url, "data": args.data }));
    } else {
        println!("listening on {url}");
    }
    signals::asked_to_end_once().await;
    coordinator.shutdown().await;
    Ok(())
}

/// Start a coordinator.
pub(crate) async fn start(config: Config) -> Result<Coordinator, CliError> {
    Coordinator::start(config)
        .await
        .map_err(|e| CliError::Coordinator(e.to_string()))
}
