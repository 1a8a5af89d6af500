//! `shearwater coordinator`.

use crate::access;
use crate::args::DEFAULT_LISTEN;
use crate::exit::CliError;
use crate::{open_files, output, signals};
use clap::Args;
use serde_json::json;
use shearwater_coordinator::access::{Role, UnknownRole};
use shearwater_coordinator::objects::ObjectsUrl;
use shearwater_coordinator::store::DatabaseUrl;
use shearwater_coordinator::{Config, Coordinator, GivenToken, Secret, TlsFiles};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Run the coordinator: jobs, leases, results, pictures
///
/// Everything it knows is in the data folder; kill it at any moment and start
/// it again, and no finished sample is lost. Port 0 takes a free one; the first
/// line of its output says which.
///
/// Several coordinators may share one database and one object store, and any of
/// them answers anything: on one machine a folder will do, on several it takes
/// PostgreSQL and S3. The keys, region and endpoint of S3 are those of the usual
/// environment: AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY, AWS_REGION,
/// AWS_ENDPOINT_URL.
///
/// It listens to this machine only, and lets everybody on it do everything, until
/// another address is given or a token is made (`shearwater token create`): from
/// then on every request needs a token.
///
/// Example: shearwater coordinator --data /var/lib/shearwater --listen 10.0.0.1:7788
#[derive(Args, Debug)]
pub(crate) struct Serve {
    #[command(flatten)]
    stores: Stores,
    /// Address to listen on
    #[arg(long, value_name = "ADDRESS:PORT", default_value = DEFAULT_LISTEN)]
    listen: SocketAddr,
    /// Demand no token where other machines reach it, until the first is made; the network must keep strangers out
    #[arg(long)]
    allow_public: bool,
    /// Host that webhooks may call although its address is not public; `*` is any; repeatable
    #[arg(long, value_name = "HOST")]
    webhook_allow: Vec<String>,
    /// Signs webhooks of jobs without a secret of their own
    #[arg(
        long,
        value_name = "TEXT",
        env = "SHEARWATER_WEBHOOK_SECRET",
        hide_env_values = true
    )]
    webhook_secret: Option<Secret>,
    /// Know this token from the start on, for example a secret of a deployment; may be repeated
    #[arg(long, value_name = "ROLE=FILE")]
    accept_token: Vec<TokenFile>,
    /// Serve https:// with this certificate chain (PEM); a SIGHUP reads it again
    #[arg(long, value_name = "FILE", requires = "tls_key")]
    tls_cert: Option<PathBuf>,
    /// Private key (PEM) of the certificate
    #[arg(long, value_name = "FILE", requires = "tls_cert")]
    tls_key: Option<PathBuf>,
    /// Take only workers with a certificate of these authorities (PEM)
    #[arg(long, value_name = "FILE", requires = "tls_cert")]
    tls_worker_ca: Option<PathBuf>,
    /// Share of the runs, 0 to 1, that a second worker renders again, to find machines that compute wrongly
    #[arg(long, value_name = "SHARE", default_value_t = 0.005, value_parser = parse_share)]
    audit: f64,
}

/// A role and a file that holds a token of it.
#[derive(Clone, Debug)]
struct TokenFile {
    role: Role,
    file: PathBuf,
}

impl FromStr for TokenFile {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('=').ok_or("expected ROLE=FILE")?;
        Ok(Self {
            role: parts.0.parse().map_err(|e: UnknownRole| e.to_string())?,
            file: parts.1.into(),
        })
    }
}

impl Serve {
    fn tls(&self) -> Option<TlsFiles> {
        Some(TlsFiles {
            certificate: self.tls_cert.clone()?,
            key: self.tls_key.clone()?,
            worker_ca: self.tls_worker_ca.clone(),
        })
    }
}

fn parse_share(text: &str) -> Result<f64, String> {
    text.parse::<f64>()
        .ok()
        .filter(|share| (0.0..=1.0).contains(share))
        .ok_or_else(|| "expected a number from 0 to 1, for example 0.005".to_owned())
}

/// Where a farm keeps what it knows.
#[derive(Args, Debug)]
pub(crate) struct Stores {
    /// Folder of the database and the objects; made if need be
    #[arg(long, value_name = "DIR", default_value = "shearwater-data")]
    data: PathBuf,
    /// Database: sqlite:///FILE or postgres://USER:PASSWORD@HOST/NAME [default: farm.db in the data folder]
    #[arg(
        long,
        value_name = "URL",
        env = "SHEARWATER_DATABASE",
        hide_env_values = true
    )]
    database: Option<String>,
    /// Pixel data and assets: file:///FOLDER or s3://BUCKET/PREFIX [default: objects in the data folder]
    #[arg(long, value_name = "URL", env = "SHEARWATER_OBJECTS")]
    objects: Option<String>,
}

pub(crate) async fn run(args: &Serve, json: bool) -> Result<(), CliError> {
    let mut config = config(&args.stores, args.listen)?;
    config.allow_public = args.allow_public;
    config.webhook_allow.clone_from(&args.webhook_allow);
    config.webhook_secret = args.webhook_secret.clone();
    config.tls = args.tls();
    for given in &args.accept_token {
        config.tokens.push(GivenToken {
            role: given.role,
            token: access::read(&given.file)?.trim().to_owned(),
        });
    }
    // Within 0 and 1: checked above.
    config.audit_ppm = (args.audit * 1e6).round() as u32;
    // Each connection is one.
    open_files::raise();
    let coordinator = start(config).await?;
    let url = coordinator.url();
    if json {
        output::object(&json!({ "url": url, "data": args.stores.data }));
    } else {
        output::line(format_args!("listening on {url}"));
    }
    let reload = || match coordinator.reload_certificates() {
        Ok(()) => tracing::info!("certificates read again"),
        Err(error) => tracing::error!(%error, "certificates stay as they were"),
    };
    tokio::select! {
        () = signals::asked_to_end_once() => {}
        () = signals::at_each_hangup(reload), if args.tls_cert.is_some() => {}
    }
    coordinator.shutdown().await;
    Ok(())
}

// Not as clap's own parser: its error would print the URL with its password.
fn database(url: &str) -> Result<DatabaseUrl, CliError> {
    DatabaseUrl::parse(url).map_err(|e| CliError::Coordinator(e.to_string()))
}

fn objects(url: &str) -> Result<ObjectsUrl, CliError> {
    ObjectsUrl::parse(url).map_err(|e| CliError::Coordinator(e.to_string()))
}

/// The settings of a coordinator that takes workers of this very build.
pub(crate) fn config(stores: &Stores, listen: SocketAddr) -> Result<Config, CliError> {
    let mut config = in_folder(&stores.data, listen);
    config.database = stores.database.as_deref().map(database).transpose()?;
    config.objects = stores.objects.as_deref().map(objects).transpose()?;
    Ok(config)
}

/// The same with everything in a folder.
pub(crate) fn in_folder(data: &Path, listen: SocketAddr) -> Config {
    Config::new(data.to_owned(), listen, shearwater_worker::BUILD.to_owned())
}

/// Start a coordinator.
pub(crate) async fn start(config: Config) -> Result<Coordinator, CliError> {
    Coordinator::start(config)
        .await
        .map_err(|e| CliError::Coordinator(e.to_string()))
}
