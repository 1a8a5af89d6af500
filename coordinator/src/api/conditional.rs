//! Entity tags, conditional requests and ranges (RFC 9110, sections 13 and 14).

use super::problem::ApiError;
use axum::Json;
use axum::body::{Body, Bytes};
use axum::http::{HeaderMap, HeaderName, Method, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use shearwater_shared::hash::ContentHash;
use std::ops::Range;

/// What names a representation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Tag {
    /// As in the header.
    text: String,
    /// Equal tags mean equal bytes.
    strong: bool,
}

impl Tag {
    /// Of bytes that are a function of `content`.
    pub(crate) fn strong(content: &str) -> Self {
        let text = format!("\"{}\"", digest(content.as_bytes()));
        Self { text, strong: true }
    }

    /// Of what means the same as long as `content` is the same.
    pub(crate) fn weak(content: &[u8]) -> Self {
        let text = format!("W/\"{}\"", digest(content));
        Self {
            text,
            strong: false,
        }
    }

    /// Of an asset: its hash in full.
    pub(crate) fn of_hash(hash: &ContentHash) -> Self {
        let text = format!("\"{hash}\"");
        Self { text, strong: true }
    }

    /// The header's value.
    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    fn opaque(&self) -> &str {
        self.text.strip_prefix("W/").unwrap_or(&self.text)
    }

    /// Whether the client has it already (`If-None-Match`, weak comparison).
    pub(crate) fn is_known(&self, headers: &HeaderMap) -> bool {
        headers
            .get_all(header::IF_NONE_MATCH)
            .iter()
            .filter_map(|value| value.to_str().ok())
            .flat_map(|value| value.split(','))
            .map(str::trim)
            .any(|given| given == "*" || given.strip_prefix("W/").unwrap_or(given) == self.opaque())
    }
}

fn digest(content: &[u8]) -> String {
    let hash = ContentHash::of(content).to_string();
    hash.chars().take(32).collect()
}

/// 304: the client has it.
pub(crate) fn unchanged(tag: &Tag) -> Response {
    (StatusCode::NOT_MODIFIED, [(header::ETAG, tag.text())]).into_response()
}

/// JSON with the tag of `meaning`, or 304.
pub(crate) fn tagged_json<T: Serialize>(
    headers: &HeaderMap,
    value: &T,
    meaning: &impl Serialize,
) -> Result<Response, ApiError> {
    let meaning = serde_json::to_vec(meaning).map_err(|e| ApiError::Internal(e.to_string()))?;
    let tag = Tag::weak(&meaning);
    if tag.is_known(headers) {
        return Ok(unchanged(&tag));
    }
    let fields = [
        (header::ETAG, tag.text()),
        (header::CACHE_CONTROL, "no-cache"),
    ];
    Ok((fields, Json(value)).into_response())
}

/// Which bytes of `length` an answer has: `None` for all of them. A header that
/// cannot be read, of another unit or of several ranges counts as none, as
/// does one that was meant for another representation.
pub(crate) fn asked_range(
    method: &Method,
    headers: &HeaderMap,
    tag: &Tag,
    length: u64,
) -> Result<Option<Range<u64>>, ApiError> {
    if *method != Method::GET || !tag.strong {
        return Ok(None);
    }
    if let Some(only_if) = headers.get(header::IF_RANGE)
        && only_if.as_bytes() != tag.text.as_bytes()
    {
        return Ok(None);
    }
    let range = headers.get(header::RANGE).and_then(|v| v.to_str().ok());
    let Some((first, last)) = range.and_then(parse) else {
        return Ok(None);
    };
    let range = match (first, last) {
        (Some(first), last) => first..last.map_or(length, |last| last.saturating_add(1)),
        // The last so many bytes.
        (None, Some(many)) => length.saturating_sub(many)..length,
        (None, None) => return Ok(None),
    };
    let range = range.start..range.end.min(length);
    if range.is_empty() {
        return Err(ApiError::Range(length));
    }
    Ok(Some(range))
}

/// `bytes=FIRST-`, `bytes=FIRST-LAST` or `bytes=-MANY`.
fn parse(text: &str) -> Option<(Option<u64>, Option<u64>)> {
    let (unit, range) = text.split_once('=')?;
    if !unit.trim().eq_ignore_ascii_case("bytes") {
        return None;
    }
    let (first, last) = range.trim().split_once('-')?;
    let number = |digits: &str| match digits.trim() {
        "" => Some(None),
        digits if digits.bytes().all(|b| b.is_ascii_digit()) => {
            // More digits than fit are behind every end.
            Some(Some(digits.parse().unwrap_or(u64::MAX)))
        }
        _ => None,
    };
    let (first, last) = (number(first)?, number(last)?);
    match (first, last) {
        (None, None) => None,
        (Some(first), Some(last)) if last < first => None,
        found => Some(found),
    }
}

/// The bytes of a picture, or those that were asked for.
pub(crate) fn bytes_answer(
    method: &Method,
    headers: &HeaderMap,
    tag: &Tag,
    bytes: Vec<u8>,
    fields: &[(HeaderName, &str)],
) -> Result<Response, ApiError> {
    let bytes = Bytes::from(bytes);
    let length = bytes.len() as u64;
    let range = asked_range(method, headers, tag, length)?;
    let body = match &range {
        Some(range) => {
            let (start, end) = (range.start as usize, range.end as usize);
            bytes.slice(start.min(bytes.len())..end.min(bytes.len()))
        }
        None => bytes,
    };
    let mut response = Body::from(body).into_response();
    describe(&mut response, tag, range.as_ref(), length, fields)?;
    Ok(response)
}

/// Status and header fields of a whole answer or of a range of it.
pub(crate) fn describe(
    response: &mut Response,
    tag: &Tag,
    range: Option<&Range<u64>>,
    length: u64,
    fields: &[(HeaderName, &str)],
) -> Result<(), ApiError> {
    let mut set = |name: HeaderName, value: &str| {
        let value = value.parse();
        let value = value.map_err(|_| ApiError::Internal(format!("header {name}")))?;
        response.headers_mut().insert(name, value);
        Ok::<(), ApiError>(())
    };
    set(header::ETAG, tag.text())?;
    let ranges = if tag.strong { "bytes" } else { "none" };
    set(header::ACCEPT_RANGES, ranges)?;
    for (name, value) in fields {
        set(name.clone(), value)?;
    }
    let sent = range.map_or(length, |range| range.end - range.start);
    set(header::CONTENT_LENGTH, &sent.to_string())?;
    if let Some(range) = range {
        let last = range.end.saturating_sub(1);
        let value = format!("bytes {}-{last}/{length}", range.start);
        set(header::CONTENT_RANGE, &value)?;
        *response.status_mut() = StatusCode::PARTIAL_CONTENT;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn headers(range: &str, only_if: Option<&str>) -> HeaderMap {
        let mut headers = HeaderMap::new();
        headers.insert(header::RANGE, range.parse().expect("value"));
        if let Some(tag) = only_if {
            headers.insert(header::IF_RANGE, tag.parse().expect("value"));
        }
        headers
    }

    fn asked(range: &str) -> Result<Option<Range<u64>>, ApiError> {
        asked_range(&Method::GET, &headers(range, None), &Tag::strong("x"), 100)
    }

    #[test]
    fn ranges_are_those_of_the_standard() {
        for (text, expected) in [
            ("bytes=0-0", Some(0..1)),
            ("bytes=10-19", Some(10..20)),
            ("Bytes = 90-", Some(90..100)),
            ("bytes=-5", Some(95..100)),
            ("bytes=-500", Some(0..100)),
            ("bytes=50-99999999999999999999999", Some(50..100)),
            ("bytes=5-4", None),
            ("bytes=0-1,5-6", None),
            ("bytes=-", None),
            ("bytes=a-b", None),
            ("bytes=+1-2", None),
            ("lines=1-2", None),
            ("", None),
        ] {
            assert_eq!(asked(text).expect(text), expected, "{text}");
        }
        for behind in ["bytes=100-", "bytes=100-200", "bytes=-0"] {
            assert!(
                matches!(asked(behind), Err(ApiError::Range(100))),
                "{behind}"
            );
        }
    }

    #[test]
    fn a_range_of_another_version_or_of_something_that_changes_is_the_whole() {
        let tag = Tag::strong("now");
        let ask = |tag: &Tag, only_if: &str| {
            let headers = headers("bytes=1-2", Some(only_if));
            asked_range(&Method::GET, &headers, tag, 9).expect("readable")
        };
        assert_eq!(ask(&tag, tag.text()), Some(1..3));
        assert_eq!(ask(&tag, Tag::strong("before").text()), None);
        assert_eq!(ask(&tag, "Sun, 22 Nov 2026 00:00:00 GMT"), None);
        let weak = Tag::weak(b"now");
        assert_eq!(ask(&weak, weak.text()), None);
        let head = asked_range(&Method::HEAD, &headers("bytes=1-2", None), &tag, 9);
        assert_eq!(head.expect("readable"), None);
    }

    proptest! {
        #[test]
        fn a_range_is_within(text in "(bytes=)?[0-9]{0,20}-?[0-9]{0,20}", length in 0u64..200) {
            let headers = headers(&text, None);
            let asked = asked_range(&Method::GET, &headers, &Tag::strong("x"), length);
            match asked {
                Ok(Some(range)) => prop_assert!(range.start < range.end && range.end <= length),
                Ok(None) => {}
                Err(ApiError::Range(of)) => prop_assert_eq!(of, length),
                Err(other) => prop_assert!(false, "{other}"),
            }
        }
    }
}
