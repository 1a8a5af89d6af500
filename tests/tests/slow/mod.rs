//! Clients that take their time, over real sockets.

#![allow(dead_code, reason = "each test binary uses its own part")]

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// Pause between two bytes of a dripping client.
const DRIP: Duration = Duration::from_secs(1);
/// No limit of the coordinator is longer.
const PATIENCE: Duration = Duration::from_secs(60);

/// What became of a client.
#[derive(Debug)]
pub(crate) struct Cut {
    /// Time until the coordinator had enough.
    pub(crate) after: Duration,
    /// What it said before.
    pub(crate) answer: String,
}

/// Send `head` at once and then a byte a second, for ever.
pub(crate) fn drip(address: &str, head: &str) -> Cut {
    let mut stream = TcpStream::connect(address).expect("connect");
    stream.write_all(head.as_bytes()).expect("send");
    stream.set_read_timeout(Some(DRIP)).expect("option");
    let began = Instant::now();
    let mut answer = Vec::new();
    loop {
        let mut piece = [0; 4096];
        match stream.read(&mut piece) {
            Ok(0) => break,
            Ok(length) => answer.extend_from_slice(&piece[..length]),
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                assert!(began.elapsed() < PATIENCE, "never cut: {head}");
                if stream.write_all(b"a").is_err() {
                    break;
                }
            }
            Err(_) => break,
        }
    }
    Cut {
        after: began.elapsed(),
        answer: String::from_utf8_lossy(&answer).into_owned(),
    }
}

/// Ask, take nothing of the answer for `pause`, then what is left; how many bytes
/// came.
pub(crate) fn ask_and_sleep(address: &str, head: &str, pause: Duration) -> usize {
    let mut stream = TcpStream::connect(address).expect("connect");
    stream.write_all(head.as_bytes()).expect("send");
    std::thread::sleep(pause);
    stream.set_read_timeout(Some(PATIENCE)).expect("option");
    let (mut bytes, mut piece) = (0, vec![0; 1 << 20]);
    while let Ok(length @ 1..) = stream.read(&mut piece) {
        bytes += length;
    }
    bytes
}

/// One request on a connection of its own; the whole answer.
pub(crate) fn ask(address: &str, request: &[u8]) -> String {
    let mut stream = TcpStream::connect(address).expect("connect");
    stream.set_read_timeout(Some(PATIENCE)).expect("option");
    stream.write_all(request).expect("send");
    let mut answer = Vec::new();
    // A reset after the answer is no matter.
    let _ = stream.read_to_end(&mut answer);
    String::from_utf8_lossy(&answer).into_owned()
}
