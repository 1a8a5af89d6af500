//! From the bytes of an input to a request.

use super::farm::{SCENE, token};
use super::wire::sealed;
use axum::body::Body;
use axum::http::{HeaderName, HeaderValue, Method, Request, Uri, header};
use shearwater_shared::hash::ContentHash;
use shearwater_shared::{routes, wire};

/// What a line of headers may be at most; the server takes no more.
const HEADERS_MAX: usize = 64;

/// A request as HTTP/1 writes one, with line feeds alone: `METHOD target`, lines of
/// headers, an empty line, a body. `{admin}`, `{client}` and `{worker}` stand for
/// tokens and `{scene}` for the hash of a scene that is uploaded; a body of the
/// worker's results gets its head and hash. `None`: no server would hand it on.
pub(super) fn parse(data: &[u8]) -> Option<Request<Body>> {
    let (head, body) = match data.windows(2).position(|w| w == b"\n\n") {
        Some(at) => (&data[..at], &data[at + 2..]),
        None => (data, &b""[..]),
    };
    let head = filled(head);
    let mut lines = head.split(|&b| b == b'\n');
    let mut words = lines.next()?.splitn(2, |&b| b == b' ');
    let method = Method::from_bytes(words.next()?).ok()?;
    let uri = Uri::try_from(words.next()?).ok()?;
    let mut body = filled(body);
    if uri.path() == routes::WORKER_RESULTS {
        body = sealed(wire::PROTOCOL_VERSION, &body);
    }
    let calls_out = body
        .windows(9)
        .any(|w| w.eq_ignore_ascii_case(b"\"webhook\""));
    if calls_out && uri.query() != Some("validate_only=true") {
        // Nobody is to be called because of a fuzzer.
        return None;
    }
    let mut request = Request::builder().method(method).uri(uri);
    for line in lines.take(HEADERS_MAX) {
        let at = line.iter().position(|&b| b == b':')?;
        let name = HeaderName::from_bytes(&line[..at]).ok()?;
        let value = HeaderValue::from_bytes(line[at + 1..].trim_ascii()).ok()?;
        if name != header::CONTENT_LENGTH && name != header::TRANSFER_ENCODING {
            request = request.header(name, value);
        }
    }
    request
        .header(header::CONTENT_LENGTH, body.len())
        .body(Body::from(body))
        .ok()
}

/// The bytes with the words in braces replaced.
fn filled(bytes: &[u8]) -> Vec<u8> {
    let scene = ContentHash::of(SCENE.as_bytes()).to_string();
    let words = [
        ("{admin}", token("a")),
        ("{client}", token("b")),
        ("{worker}", token("c")),
        ("{scene}", scene),
    ];
    let mut filled = Vec::with_capacity(bytes.len());
    let mut rest = bytes;
    while let Some((&first, after)) = rest.split_first() {
        match words
            .iter()
            .find(|(word, _)| rest.starts_with(word.as_bytes()))
        {
            Some((word, text)) => {
                filled.extend_from_slice(text.as_bytes());
                rest = &rest[word.len()..];
            }
            None => {
                filled.push(first);
                rest = after;
            }
        }
    }
    filled
}
