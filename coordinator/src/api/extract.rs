//! From raw requests to checked values; refusals are ours, not axum's.

use super::problem::ApiError;
use axum::body::{Body, Bytes, to_bytes};
use axum::extract::rejection::QueryRejection;
use axum::extract::{FromRequest, FromRequestParts, Path, Query, Request};
use axum::http::request::Parts;
use axum::http::{HeaderMap, header};
use serde::de::DeserializeOwned;
use serde_json::Value;
use shearwater_shared::api::WorkerId;
use shearwater_shared::job::JobId;
use shearwater_shared::limits::{JSON_BODY_BYTES_MAX, NAME_BYTES_MAX};
use std::time::Duration;

/// Time for a body that is held in memory to arrive: 16 MiB over 5 Mbit/s.
const BODY_TIMEOUT: Duration = Duration::from_secs(30);

/// A JSON body of at most `LIMIT` bytes.
#[derive(Debug)]
pub(crate) struct JsonBody<T, const LIMIT: usize = JSON_BODY_BYTES_MAX>(pub(crate) T);

impl<T: DeserializeOwned, S: Send + Sync, const LIMIT: usize> FromRequest<S>
    for JsonBody<T, LIMIT>
{
    type Rejection = ApiError;

    async fn from_request(request: Request, _: &S) -> Result<Self, ApiError> {
        let (parts, body) = request.into_parts();
        let bytes = read_body(&parts.headers, body, "application/json", LIMIT).await?;
        let mut json = serde_json::Deserializer::from_slice(&bytes);
        let value = match serde_path_to_error::deserialize(&mut json) {
            Ok(value) => value,
            Err(error) => {
                return with_whole_numbers(&bytes).map(Self).ok_or_else(|| {
                    ApiError::BadRequest(format!("body, {}: {}", error.path(), error.inner()))
                });
            }
        };
        json.end()
            .map_err(|e| ApiError::BadRequest(format!("body: {e}")))?;
        Ok(Self(value))
    }
}

/// The same body with `7.0` read as 7: to JSON Schema, and so to clients made from
/// our document, both are one integer.
fn with_whole_numbers<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    let mut value: Value = serde_json::from_slice(bytes).ok()?;
    make_whole(&mut value).then(|| serde_json::from_value(value).ok())?
}

/// Largest float that is certainly the integer it was written as: 2^53.
const WHOLE_FLOAT_MAX: f64 = 9_007_199_254_740_992.0;

/// Turn every float without a fraction into an integer; whether there was one.
fn make_whole(value: &mut Value) -> bool {
    match value {
        Value::Number(number) if number.is_f64() => {
            let float = number.as_f64().unwrap_or(f64::NAN);
            // Beyond, a float may be another integer that was written out.
            if float.fract() != 0.0 || float.abs() > WHOLE_FLOAT_MAX {
                return false;
            }
            *value = (float as i64).into();
            true
        }
        Value::Array(items) => any_whole(items.iter_mut()),
        Value::Object(fields) => any_whole(fields.values_mut()),
        _ => false,
    }
}

/// All of them are visited.
fn any_whole<'a>(values: impl Iterator<Item = &'a mut Value>) -> bool {
    values
        .filter_map(|value| make_whole(value).then_some(()))
        .count()
        > 0
}

/// The one variable segment of a path.
#[derive(Debug)]
pub(crate) struct Segment(pub(crate) String);

impl<S: Send + Sync> FromRequestParts<S> for Segment {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, ApiError> {
        Path::<String>::from_request_parts(parts, state)
            .await
            .map(|Path(text)| Self(text))
            .map_err(|rejection| ApiError::BadRequest(format!("path: {}", rejection.body_text())))
    }
}

/// A body of the right type that is not too long; refused before it is read
/// when its headers say so.
pub(crate) async fn read_body(
    headers: &HeaderMap,
    body: Body,
    media_type: &'static str,
    limit: usize,
) -> Result<Bytes, ApiError> {
    let given = headers
        .get(header::CONTENT_TYPE)
        .and_then(|value| value.to_str().ok())
        .and_then(|value| value.split(';').next())
        .map(str::trim);
    if !given.is_some_and(|given| given.eq_ignore_ascii_case(media_type)) {
        return Err(ApiError::MediaType(media_type));
    }
    check_length(headers, limit as u64)?;
    match tokio::time::timeout(BODY_TIMEOUT, to_bytes(body, limit)).await {
        Ok(Ok(bytes)) => Ok(bytes),
        Ok(Err(error)) => Err(body_error(&error, limit)),
        Err(_) => Err(ApiError::Timeout),
    }
}

/// Refuse a body whose announced length is above `limit`.
pub(crate) fn check_length(headers: &HeaderMap, limit: u64) -> Result<(), ApiError> {
    let length = headers
        .get(header::CONTENT_LENGTH)
        .and_then(|value| value.to_str().ok())
        .and_then(|value| value.parse::<u64>().ok());
    match length {
        Some(length) if length > limit => Err(ApiError::TooLarge(limit)),
        _ => Ok(()),
    }
}

fn body_error(error: &axum::Error, limit: usize) -> ApiError {
    // The limit's own error type is private to a crate below axum; its text is
    // the only sign.
    let mut cause: Option<&dyn std::error::Error> = Some(error);
    while let Some(error) = cause {
        if error.to_string().contains("length limit exceeded") {
            return ApiError::TooLarge(limit as u64);
        }
        cause = error.source();
    }
    ApiError::BadRequest("the body broke off".into())
}

/// A job's number out of a path.
pub(crate) fn job_id(text: &str) -> Result<JobId, ApiError> {
    match text.parse() {
        Ok(id) if id > 0 => Ok(JobId(id)),
        _ => Err(ApiError::NotFound(
            "no such job: job numbers are whole and positive".into(),
        )),
    }
}

/// No such job.
pub(crate) fn no_job(id: JobId) -> ApiError {
    ApiError::NotFound(format!("there is no job {id}; it may have been deleted"))
}

/// A query string.
pub(crate) fn query<T>(query: Result<Query<T>, QueryRejection>) -> Result<T, ApiError> {
    query
        .map(|Query(value)| value)
        .map_err(|rejection| ApiError::BadRequest(format!("query: {}", rejection.body_text())))
}

/// A worker's name and instance, of a sensible length.
pub(crate) fn check_worker(worker: &WorkerId) -> Result<(), ApiError> {
    // PostgreSQL stores no text with a NUL.
    let wrong = |text: &str| text.len() > NAME_BYTES_MAX || text.contains('\0');
    if worker.instance.is_empty() || wrong(&worker.instance) || wrong(&worker.name) {
        return Err(ApiError::Invalid(format!(
            "worker: instance must have 1 to {NAME_BYTES_MAX} bytes, name at most so many, none of \
             them 0"
        )));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_floats_are_integers_and_others_are_not() {
        let read = |text: &str| with_whole_numbers::<Vec<u64>>(text.as_bytes());
        assert_eq!(read("[7.0, 8, 1e3]"), Some(vec![7, 8, 1000]));
        for text in [
            "[7.5]",
            "[-1.0]",
            "[1e30]",
            "[1e400]",
            "[7]x",
            "[\"7.0\"]",
            "",
        ] {
            assert_eq!(read(text), None, "{text}");
        }
    }

    #[tokio::test]
    async fn a_body_above_the_limit_is_named_so() {
        let mut headers = HeaderMap::new();
        headers.insert(
            header::CONTENT_TYPE,
            "text/x; charset=utf-8".parse().expect("header"),
        );
        let read = |limit| read_body(&headers, Body::from("12345"), "text/x", limit);
        assert_eq!(read(5).await.expect("fits"), "12345");
        assert!(matches!(read(4).await, Err(ApiError::TooLarge(4))));
        let other = read_body(&headers, Body::empty(), "text/y", 5).await;
        assert!(matches!(other, Err(ApiError::MediaType("text/y"))));
    }
}
