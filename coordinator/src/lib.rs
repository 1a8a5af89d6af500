//! The coordinator: farm decisions, store, API, development of pictures.
//!
//! - [`farm`]: decisions, pure functions of a snapshot and of the time.
//! - [`store`]: transitions, each one SQL statement or short transaction.
//! - [`objects`]: write-once pixel data and assets.
//! - [`fold`]: parts become tiles, tiles a film, a film a picture.
//! - `api`: the REST API and the worker protocol over them.
//!
//! Any number of coordinators may run on one store; each may be killed at any
//! moment. What was acknowledged is never lost and never counted twice.

pub mod access;
mod api;
mod app;
mod audit;
mod background;
mod beats;
mod config;
mod counting;
pub mod develop;
mod dispatch;
pub mod farm;
pub mod fold;
mod gather;
mod gc;
mod known;
mod metrics;
pub mod objects;
mod presence;
mod serve;
pub mod store;
pub mod sweep;
mod trouble;
mod unit_log;
mod webhook;

pub use app::open_token_store;
pub use config::{Config, GivenToken, StartError};
pub use gc::{GcError, GcReport, gc};
pub use serve::{TlsError, TlsFiles};
pub use webhook::{CallerError, Secret};

use access::NewToken;
use app::App;
use axum::Extension;
use axum::extract::ConnectInfo;
use serve::{Listener, Peer, Serving, Tls};
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::TcpListener;
use tokio::task::JoinHandle;

/// How long a shutdown waits for running requests: longer than a result takes,
/// shorter than what service managers wait before they kill.
const SHUTDOWN_TIMEOUT: Duration = Duration::from_secs(10);

/// A running coordinator. Dropping it stops it without waiting.
#[derive(Debug)]
pub struct Coordinator {
    app: Arc<App>,
    addr: SocketAddr,
    server: Serving,
    tls: Option<Tls>,
    tasks: Vec<JoinHandle<()>>,
}

impl Coordinator {
    /// Open the store, listen, and serve until [`Coordinator::shutdown`].
    ///
    /// # Errors
    /// See [`StartError`]; nothing runs then.
    pub async fn start(config: Config) -> Result<Self, StartError> {
        config.check()?;
        let tls = config.tls.clone().map(Tls::load).transpose()?;
        let (app, lines) = App::open(config).await?;
        let app = Arc::new(app);
        let listen = app.config.listen;
        for given in &app.config.tokens {
            let new = NewToken {
                role: given.role,
                name: "given at start".to_owned(),
                expires_ms: None,
            };
            access::adopt(&app.store, &given.token, new, app::now_ms()).await?;
        }
        let public = !listen.ip().is_loopback();
        if public && !app.tokens.any().await? {
            if !app.config.allow_public {
                return Err(StartError::Public(listen));
            }
            tracing::warn!(
                %listen,
                "everybody who reaches this address can use this farm: no token is demanded"
            );
        }
        let bound = TcpListener::bind(listen).await;
        let listener = bound.map_err(|source| StartError::Listen { listen, source })?;
        let addr = listener
            .local_addr()
            .map_err(|source| StartError::Listen { listen, source })?;
        let router = api::router(Arc::clone(&app))?;
        let server = serve::start(Listener::new(listener), router, tls.as_ref());
        let tasks = background::start(&app, lines);
        tracing::info!(%addr, "coordinator listens");
        Ok(Self {
            app,
            addr,
            server,
            tls,
            tasks,
        })
    }

    /// The address it listens on; useful after listening on port 0.
    #[must_use]
    pub const fn addr(&self) -> SocketAddr {
        self.addr
    }

    /// Every route, without the connections before them: requests put into it count
    /// as those of this machine. For tests and fuzzing, which so need no sockets.
    ///
    /// # Errors
    /// See [`StartError`].
    pub fn router(&self) -> Result<axum::Router, StartError> {
        let peer = ConnectInfo(Peer::at(self.addr));
        let router = api::router(Arc::clone(&self.app))?;
        Ok(router.layer(Extension(peer)))
    }

    /// Read certificates and keys again, for further connections; without TLS
    /// nothing happens.
    ///
    /// # Errors
    /// They cannot be read or used; those of before stay.
    pub fn reload_certificates(&self) -> Result<(), TlsError> {
        self.tls.as_ref().map_or(Ok(()), Tls::reload)
    }

    /// Where clients find it.
    #[must_use]
    pub fn url(&self) -> String {
        let scheme = if self.tls.is_some() { "https" } else { "http" };
        format!("{scheme}://{}", self.addr)
    }

    /// Stop: no new requests, streams end, running requests get up to ten
    /// seconds. What they leave undone is safe to be done again.
    pub async fn shutdown(mut self) {
        self.server.end(&self.app, SHUTDOWN_TIMEOUT).await;
        self.stop_tasks();
        for task in &mut self.tasks {
            let _ = task.await;
        }
        self.app.store.close().await;
    }

    fn stop_tasks(&self) {
        self.server.cut();
        for task in &self.tasks {
            task.abort();
        }
    }
}

impl Drop for Coordinator {
    fn drop(&mut self) {
        self.app.stopping.send_replace(true);
        self.stop_tasks();
    }
}
