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

mod api;
mod app;
mod background;
mod config;
pub mod develop;
mod dispatch;
pub mod farm;
pub mod fold;
mod gc;
pub mod objects;
pub mod store;
pub mod sweep;
mod trouble;
mod webhook;

pub use config::{Config, StartError};
pub use gc::{GcError, GcReport, gc};
pub use webhook::{CallerError, Secret};

use app::App;
use axum::serve::ListenerExt;
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
    server: JoinHandle<()>,
    tasks: Vec<JoinHandle<()>>,
}

impl Coordinator {
    /// Open the store, listen, and serve until [`Coordinator::shutdown`].
    ///
    /// # Errors
    /// See [`StartError`]; nothing runs then.
    pub async fn start(config: Config) -> Result<Self, StartError> {
        config.check()?;
        let app = Arc::new(App::open(config).await?);
        let listen = app.config.listen;
        let bound = TcpListener::bind(listen).await;
        let listener = bound.map_err(|source| StartError::Listen { listen, source })?;
        let addr = listener
            .local_addr()
            .map_err(|source| StartError::Listen { listen, source })?;
        let router = api::router(Arc::clone(&app))?;
        let mut stopping = app.stopping.subscribe();
        let server = tokio::spawn(async move {
            // Small answers to waiting workers must not sit in a send buffer.
            let listener = listener.tap_io(|stream| {
                if let Err(error) = stream.set_nodelay(true) {
                    tracing::debug!(%error, "no TCP_NODELAY");
                }
            });
            let serve = axum::serve(listener, router).with_graceful_shutdown(async move {
                let _ = stopping.wait_for(|stopping| *stopping).await;
            });
            if let Err(error) = serve.await {
                tracing::error!(%error, "the listener failed");
            }
        });
        let tasks = background::start(&app);
        tracing::info!(%addr, "coordinator listens");
        Ok(Self {
            app,
            addr,
            server,
            tasks,
        })
    }

    /// The address it listens on; useful after listening on port 0.
    #[must_use]
    pub const fn addr(&self) -> SocketAddr {
        self.addr
    }

    /// Stop: no new requests, streams end, running requests get up to ten
    /// seconds. What they leave undone is safe to be done again.
    pub async fn shutdown(mut self) {
        self.app.stopping.send_replace(true);
        if tokio::time::timeout(SHUTDOWN_TIMEOUT, &mut self.server)
            .await
            .is_err()
        {
            tracing::warn!("requests still running after the shutdown's time; cut off");
        }
        self.stop_tasks();
        for task in &mut self.tasks {
            let _ = task.await;
        }
        self.app.store.close().await;
    }

    fn stop_tasks(&self) {
        self.server.abort();
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
