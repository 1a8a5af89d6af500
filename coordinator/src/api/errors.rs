//! `GET /v1/jobs/{id}/errors`: a frame's error against time.

use super::conditional::tagged_json;
use super::extract::{Segment, query};
use super::images::job_and_frame;
use super::openapi::Fails;
use super::page;
use super::problem::ApiError;
use crate::app::App;
use crate::store::{ErrorRow, JobRow};
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use axum::http::HeaderMap;
use axum::response::Response;
use serde::Deserialize;
use shearwater_shared::api::{ErrorPage, ErrorPoint};
use shearwater_shared::routes;
use std::sync::Arc;
use utoipa::IntoParams;

/// Points on a page when the client does not say: all of nearly every frame.
const PAGE_SIZE: u32 = 100;
/// Most points on a page: an answer of about 300 KiB.
const PAGE_SIZE_MAX: u32 = 1000;

/// Query of a series.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub(crate) struct ErrorsQuery {
    /// The scene's number of the frame; the job's first when nothing is said.
    #[param(nullable = false)]
    frame: Option<u32>,
    /// How many at most, 100 when nothing is said; never more than 1,000.
    #[param(nullable = false)]
    page_size: Option<u32>,
    /// `next_page_token` of the page before.
    #[param(nullable = false, pattern = "^(([0-9a-f]{2}){5,204})?$")]
    page_token: Option<String>,
}

/// A page of a frame's errors, in order of samples.
#[utoipa::path(
    get,
    path = routes::JOB_ERRORS,
    operation_id = "list_errors",
    tag = "jobs",
    params(
        ("id" = i64, Path, description = "the job's number", minimum = 1),
        ErrorsQuery,
        ("If-None-Match" = Option<String>, Header, description = "an `ETag`")
    ),
    responses(
        (status = 200, description = "The page", body = ErrorPage, headers(("ETag" = String))),
        (status = 304, description = "The page is the same"),
        Fails<400>,
        Fails<404>,
        Fails<422>
    )
)]
pub(crate) async fn list(
    State(app): State<Arc<App>>,
    Segment(id): Segment,
    params: Result<Query<ErrorsQuery>, QueryRejection>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let params = query(params)?;
    let (job, frame) = job_and_frame(&app, &id, params.frame).await?;
    let limit = params.page_size.unwrap_or(PAGE_SIZE);
    let limit = limit.clamp(1, PAGE_SIZE_MAX);
    let listing = format!("errors {} {frame}", job.id);
    let after: u64 = page::number(&listing, params.page_token.as_deref())?.unwrap_or(0);
    // One more than asked for says whether there is another page.
    let mut rows = app.store.errors(job.id, frame, after, limit + 1).await?;
    let more = rows.len() > limit as usize;
    rows.truncate(limit as usize);
    let token = rows.last().filter(|_| more);
    let page = ErrorPage {
        next_page_token: token.map(|row| page::token(&listing, &row.samples.to_string())),
        points: rows.iter().map(|row| point(&job, row)).collect(),
    };
    tagged_json(&headers, &page, &page)
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
