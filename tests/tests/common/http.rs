//! A question over HTTP, without a client library.

use std::io::{self, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

/// Longest wait for an answer.
const TIMEOUT: Duration = Duration::from_secs(30);

/// `GET` a path of `http://host:port`; status and body.
pub(crate) fn get(url: &str, path: &str) -> (u16, String) {
    send(url, "GET", path)
}

/// The same with another method.
pub(crate) fn send(url: &str, method: &str, path: &str) -> (u16, String) {
    let answer = ask(url, method, path, &[]);
    (answer.status, answer.body)
}

/// All of an answer.
pub(crate) struct Answer {
    pub(crate) status: u16,
    /// Status line and headers.
    pub(crate) head: String,
    pub(crate) body: String,
}

impl Answer {
    /// A header; the name in lower case.
    pub(crate) fn header(&self, name: &str) -> Option<&str> {
        self.head.lines().skip(1).find_map(|line| {
            let (of, value) = line.split_once(':')?;
            of.eq_ignore_ascii_case(name).then(|| value.trim())
        })
    }
}

/// The same with headers.
pub(crate) fn ask(url: &str, method: &str, path: &str, headers: &[(&str, &str)]) -> Answer {
    try_ask(url, method, path, headers, TIMEOUT).expect("an answer")
}

/// The same of a server that may be away; waits `patience` for each piece.
///
/// # Errors
/// No answer, or none that is HTTP.
pub(crate) fn try_ask(
    url: &str,
    method: &str,
    path: &str,
    headers: &[(&str, &str)],
    patience: Duration,
) -> io::Result<Answer> {
    let more: Vec<String> = headers
        .iter()
        .map(|(name, value)| format!("{name}: {value}\r\n"))
        .collect();
    let more = more.concat();
    let place = url.trim_start_matches("http://");
    let addr = place.to_socket_addrs()?.next();
    let addr = addr.ok_or_else(|| io::Error::other("no address"))?;
    let mut stream = TcpStream::connect_timeout(&addr, patience)?;
    stream.set_read_timeout(Some(patience))?;
    let request =
        format!("{method} {path} HTTP/1.1\r\nHost: {place}\r\nConnection: close\r\n{more}\r\n");
    stream.write_all(request.as_bytes())?;
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer)?;
    let answer = String::from_utf8_lossy(&answer).into_owned();
    let (head, body) = answer
        .split_once("\r\n\r\n")
        .ok_or_else(|| io::Error::other("no head"))?;
    let status = head.split(' ').nth(1).unwrap_or_default();
    Ok(Answer {
        status: status.parse().map_err(io::Error::other)?,
        head: head.to_owned(),
        body: body.to_owned(),
    })
}
