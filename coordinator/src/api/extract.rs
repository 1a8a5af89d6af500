//! From raw requests to checked values; refusals are ours, not axum's.

use super::problem::ApiError;
use axum::body::{Body, Bytes, to_bytes};
use axum::extract::rejection::QueryRejection;
use axum::extract::{FromRequest, FromRequestParts, Path, Query, Request};
use axum::http::request::Parts;
use axum::http::{HeaderMap, header};
use serde::de::DeserializeOwned;
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
        let value = serde_path_to_error::deserialize(&mut json)
            .map_err(|e| ApiError::BadRequest(format!("body, {}: {}", e.path(), e.inner())))?;
        json.end()
            .map_err(|e| ApiError::BadRequest(format!("body: {e}")))?;
        Ok(Self(value))
    }
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
        return Err(ApiError::BadRequest(format!(
            "worker: instance must have 1 to {NAME_BYTES_MAX} bytes, name at most so many, none of \
             them 0"
        )));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

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
