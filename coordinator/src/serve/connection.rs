//! Connections: how many there are, and that none stands still for ever.

use super::limits::{WRITE_TIMEOUT, connections_max};
use axum::extract::connect_info::Connected;
use axum_server::{AddrListener, Address};
use std::io::{self, IoSlice};
use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll};
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::Sleep;

/// The other side of a connection, as a request may ask for it.
#[derive(Clone, Debug)]
pub(crate) struct Peer {
    /// Address of whoever connected: the client, or a proxy before it.
    pub(crate) addr: SocketAddr,
    certified: Arc<AtomicBool>,
}

impl Peer {
    /// One without a certificate.
    pub(crate) fn at(addr: SocketAddr) -> Self {
        let certified = Arc::default();
        Self { addr, certified }
    }

    /// Note that it showed a certificate of a worker, and that it is right.
    pub(super) fn certify(&self) {
        self.certified.store(true, Ordering::Relaxed);
    }

    /// Whether it showed a right certificate of a worker.
    pub(crate) fn is_certified(&self) -> bool {
        self.certified.load(Ordering::Relaxed)
    }
}

impl Connected<Self> for Peer {
    fn connect_info(peer: Self) -> Self {
        peer
    }
}

/// Accepts connections while there is a place for them.
#[derive(Debug)]
pub(crate) struct Listener {
    socket: TcpListener,
    places: Arc<Semaphore>,
}

impl Listener {
    /// Accept from a bound socket.
    pub(crate) fn new(socket: TcpListener) -> Self {
        let places = connections_max();
        tracing::debug!(places, "connections");
        Self {
            socket,
            places: Arc::new(Semaphore::new(places)),
        }
    }
}

impl Address for Peer {
    type Stream = Connection;
    type Listener = Listener;
}

impl AddrListener<Connection, Peer> for Listener {
    async fn bind_to(peer: Peer) -> io::Result<Self> {
        TcpListener::bind(peer.addr).await.map(Self::new)
    }

    async fn accept_stream(&self) -> io::Result<(Connection, Peer)> {
        // The place comes first: whoever waits for one waits in the system's
        // queue and costs nothing here.
        let place = Arc::clone(&self.places);
        let place = place.acquire_owned().await.map_err(io::Error::other)?;
        let (io, addr) = self.socket.accept().await?;
        // Small answers to waiting workers must not sit in a send buffer.
        if let Err(error) = io.set_nodelay(true) {
            tracing::debug!(%error, "no TCP_NODELAY");
        }
        let peer = Peer::at(addr);
        let connection = Connection {
            io,
            peer: peer.clone(),
            stall: None,
            _place: place,
        };
        Ok((connection, peer))
    }

    fn get_local_addr(&self) -> io::Result<Peer> {
        self.socket.local_addr().map(Peer::at)
    }
}

/// A connection that ends when its other side takes nothing of an answer.
#[derive(Debug)]
pub(crate) struct Connection {
    io: TcpStream,
    peer: Peer,
    /// Runs while a write waits.
    stall: Option<Pin<Box<Sleep>>>,
    _place: OwnedSemaphorePermit,
}

impl Connection {
    /// Its other side.
    pub(super) fn peer(&self) -> Peer {
        self.peer.clone()
    }

    /// `outcome` of a write, or an error if writes have waited too long.
    fn timed<T>(
        &mut self,
        cx: &mut Context<'_>,
        outcome: Poll<io::Result<T>>,
    ) -> Poll<io::Result<T>> {
        if outcome.is_ready() {
            self.stall = None;
            return outcome;
        }
        let stall = self
            .stall
            .get_or_insert_with(|| Box::pin(tokio::time::sleep(WRITE_TIMEOUT)));
        match stall.as_mut().poll(cx) {
            Poll::Ready(()) => Poll::Ready(Err(io::ErrorKind::TimedOut.into())),
            Poll::Pending => Poll::Pending,
        }
    }
}

impl AsyncRead for Connection {
    fn poll_read(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        Pin::new(&mut self.io).poll_read(cx, buffer)
    }
}

impl AsyncWrite for Connection {
    fn poll_write(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let outcome = Pin::new(&mut self.io).poll_write(cx, bytes);
        self.timed(cx, outcome)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bytes: &[IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let outcome = Pin::new(&mut self.io).poll_write_vectored(cx, bytes);
        self.timed(cx, outcome)
    }

    fn is_write_vectored(&self) -> bool {
        self.io.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        let outcome = Pin::new(&mut self.io).poll_flush(cx);
        self.timed(cx, outcome)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        let outcome = Pin::new(&mut self.io).poll_shutdown(cx);
        self.timed(cx, outcome)
    }
}
