//! A line to a server that can be cut, and mended again.

use std::io::{Read, Write};
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

const OPEN: u8 = 0;
const CUT: u8 = 1;
const SILENT: u8 = 2;

/// A port that leads to a server.
pub(crate) struct Relay {
    pub(crate) addr: SocketAddr,
    state: Arc<AtomicU8>,
    open: Arc<Mutex<Vec<TcpStream>>>,
}

impl Relay {
    /// Lead to `target`.
    pub(crate) fn to(target: SocketAddr) -> Self {
        Self::on(Ipv4Addr::LOCALHOST, target)
    }

    /// The same, at an address of this machine.
    pub(crate) fn on(ip: Ipv4Addr, target: SocketAddr) -> Self {
        let listener = TcpListener::bind((ip, 0)).expect("a port");
        let addr = listener.local_addr().expect("address");
        let state = Arc::new(AtomicU8::new(OPEN));
        let open = Arc::new(Mutex::new(Vec::new()));
        let (its_state, its_open) = (Arc::clone(&state), Arc::clone(&open));
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                // A server that is gone: whoever comes is sent away.
                if its_state.load(Ordering::SeqCst) == CUT {
                    continue;
                }
                let Ok(server) = TcpStream::connect(target) else {
                    continue;
                };
                join(&stream, &server, &its_state);
                its_open.lock().expect("list").extend([stream, server]);
            }
        });
        Self { addr, state, open }
    }

    /// The server is gone, and every connection with it.
    pub(crate) fn cut(&self) {
        self.state.store(CUT, Ordering::SeqCst);
        for stream in self.open.lock().expect("list").drain(..) {
            let _ = stream.shutdown(Shutdown::Both);
        }
    }

    /// Connections stay, but nothing comes through any more.
    pub(crate) fn fall_silent(&self) {
        self.state.store(SILENT, Ordering::SeqCst);
    }

    /// All is well again.
    pub(crate) fn mend(&self) {
        self.state.store(OPEN, Ordering::SeqCst);
    }
}

fn join(one: &TcpStream, other: &TcpStream, state: &Arc<AtomicU8>) {
    for (from, to) in [(one, other), (other, one)] {
        let (from, to) = (from.try_clone(), to.try_clone());
        let (from, to) = (from.expect("clone"), to.expect("clone"));
        let state = Arc::clone(state);
        std::thread::spawn(move || carry(from, to, &state));
    }
}

fn carry(mut from: TcpStream, mut to: TcpStream, state: &AtomicU8) {
    let mut bytes = [0; 64 << 10];
    while let Ok(length @ 1..) = from.read(&mut bytes) {
        while state.load(Ordering::SeqCst) == SILENT {
            std::thread::sleep(Duration::from_millis(20));
        }
        if to.write_all(&bytes[..length]).is_err() {
            break;
        }
    }
    let _ = from.shutdown(Shutdown::Both);
    let _ = to.shutdown(Shutdown::Both);
}
