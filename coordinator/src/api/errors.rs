//! `GET /v1/jobs/{id}/errors`: a frame's error against time.

use super::extract::{Segment, query};
use super::images::job_and_frame;
use super::problem::ApiError;
use crate::app::App;
use crate::store::{ErrorRow, JobRow};
use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use serde::Deserialize;
use shearwater_shared::api::{ErrorPage, ErrorPoint};
use std::sync::Arc;

/// Points on a page when the client does not say: all of nearly every frame.
const PAGE_SIZE: u32 = 100;
/// Most points on a page: an answer of about 300 KiB.
const PAGE_SIZE_MAX: u32 = 1000;

/// Query of a series.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ErrorsQuery {
    frame: Option<u32>,
    page_size: Option<u32>,
    page_token: Option<String>,
}

/// A page of a frame's errors, in order of samples.
pub(crate) async fn list(
    State(app): State<Arc<App>>,
    Segment(id): Segment,
    params: Result<Query<ErrorsQuery>, QueryRejection>,
) -> Result<Json<ErrorPage>, ApiError> {
    let params = query(params)?;
    let (job, frame) = job_and_frame(&app, &id, params.frame).await?;
    let limit = params.page_size.unwrap_or(PAGE_SIZE);
    let limit = limit.clamp(1, PAGE_SIZE_MAX);
    let after: u64 = match params.page_token.as_deref() {
        None | Some("") => 0,
        Some(token) => token.parse().map_err(|_| {
            ApiError::BadRequest("page_token: pass the next_page_token of the last answer".into())
        })?,
    };
    // One more than asked for says whether there is another page.
    let mut rows = app.store.errors(job.id, frame, after, limit + 1).await?;
    let more = rows.len() > limit as usize;
    rows.truncate(limit as usize);
    let token = rows.last().filter(|_| more);
    Ok(Json(ErrorPage {
        next_page_token: token.map(|row| row.samples.to_string()),
        points: rows.iter().map(|row| point(&job, row)).collect(),
    }))
}

/// A row as the API shows it.
pub(super) fn point(job: &JobRow, row: &ErrorRow) -> ErrorPoint {
    let since_ms = job.first_lease_ms.unwrap_or(row.at_ms);
    ErrorPoint {
        frame: job.settings.absolute_frame(row.frame),
        at_ms: row.at_ms,
        elapsed_s: row.at_ms.saturating_sub(since_ms).max(0) as f64 / 1000.0,
        core_s: row.core_us as f64 / 1e6,
        samples_done: row.samples,
        error: row.error,
    }
}
