//! From a listening socket to requests: connections that cost little, end when
//! they are slow, and are counted.
//!
//! The API behind it knows nothing of sockets; what it may know of the other
//! side is a [`Peer`].

mod connection;
mod limits;
mod tls;

pub(crate) use connection::{Listener, Peer};
pub(crate) use tls::Tls;
pub use tls::{TlsError, TlsFiles};

use crate::app::App;
use axum::Router;
use axum_server::{Handle, Server};
use hyper_util::rt::TokioTimer;
use limits::{HEADER_TIMEOUT, HEADERS_MAX, READ_BUFFER_BYTES};
use std::sync::Arc;
use std::time::Duration;
use tokio::task::JoinHandle;

/// A server at work.
#[derive(Debug)]
pub(crate) struct Serving {
    handle: Handle<Peer>,
    task: JoinHandle<()>,
}

/// Answer with `router` whoever connects.
pub(crate) fn start(listener: Listener, router: Router, tls: Option<&Tls>) -> Serving {
    let handle = Handle::new();
    let service = router.into_make_service_with_connect_info::<Peer>();
    let server = Server::<Peer>::from_listener(listener);
    let task = match tls {
        None => {
            let server = configured(server, &handle);
            tokio::spawn(async move { log(server.serve(service).await) })
        }
        Some(tls) => {
            let server = configured(server.acceptor(tls.acceptor()), &handle);
            tokio::spawn(async move { log(server.serve(service).await) })
        }
    };
    Serving { handle, task }
}

fn configured<A>(server: Server<Peer, A>, handle: &Handle<Peer>) -> Server<Peer, A> {
    let mut server = server.handle(handle.clone()).http1_only();
    server
        .http_builder()
        .http1()
        .timer(TokioTimer::new())
        .header_read_timeout(HEADER_TIMEOUT)
        .max_headers(HEADERS_MAX)
        .max_buf_size(READ_BUFFER_BYTES);
    server
}

fn log(ended: std::io::Result<()>) {
    if let Err(error) = ended {
        tracing::error!(%error, "the listener failed");
    }
}

impl Serving {
    /// No new connections; running requests get `grace`, then they are cut off.
    pub(crate) async fn end(&mut self, app: &Arc<App>, grace: Duration) {
        app.stopping.send_replace(true);
        self.handle.graceful_shutdown(Some(grace));
        // The server keeps the time itself; this only bounds its own end.
        let bound = grace.saturating_add(limits::END_TIMEOUT);
        if tokio::time::timeout(bound, &mut self.task).await.is_err() {
            tracing::warn!("requests still running after the shutdown's time; cut off");
        }
        self.cut();
    }

    /// End everything at once.
    pub(crate) fn cut(&self) {
        self.handle.shutdown();
        self.task.abort();
    }
}
