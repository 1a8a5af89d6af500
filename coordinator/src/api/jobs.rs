//! Jobs: list, show, cancel, delete.

use super::conditional::tagged_json;
use super::extract::{Segment, job_id, no_job, query};
use super::openapi::Fails;
use super::page;
use super::problem::ApiError;
use super::view::{job_view, meaning};
use crate::app::{App, now_ms};
use crate::store::JobFilter;
use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use axum::http::{HeaderMap, StatusCode};
use axum::response::Response;
use serde::Deserialize;
use shearwater_shared::api::{JobPage, JobView};
use shearwater_shared::job::JobState;
use shearwater_shared::routes;
use std::sync::Arc;
use utoipa::IntoParams;

/// Jobs on a page when the client does not say.
const PAGE_SIZE: u32 = 50;
/// Most jobs on a page: each is read with its counts.
const PAGE_SIZE_MAX: u32 = 200;

/// Query of a listing.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub(crate) struct ListQuery {
    /// How many at most, 50 when nothing is said; never more than 200.
    #[param(nullable = false)]
    page_size: Option<u32>,
    /// `next_page_token` of the page before.
    #[param(nullable = false, pattern = "^(([0-9a-f]{2}){5,204})?$")]
    page_token: Option<String>,
    /// Only jobs in this state.
    #[param(nullable = false, inline)]
    state: Option<JobState>,
}

/// A page of jobs, newest first.
#[utoipa::path(
    get,
    path = routes::JOBS,
    operation_id = "list_jobs",
    tag = "jobs",
    params(ListQuery),
    responses((status = 200, description = "The page", body = JobPage), Fails<400>, Fails<422>)
)]
pub(crate) async fn list(
    State(app): State<Arc<App>>,
    params: Result<Query<ListQuery>, QueryRejection>,
) -> Result<Json<JobPage>, ApiError> {
    let params = query(params)?;
    let limit = params
        .page_size
        .unwrap_or(PAGE_SIZE)
        .clamp(1, PAGE_SIZE_MAX);
    let listing = format!("jobs {:?}", params.state);
    let below = page::number(&listing, params.page_token.as_deref())?.unwrap_or(i64::MAX);
    let rows = app
        .store
        .jobs(&JobFilter {
            below,
            state: params.state,
            // One more shows whether there is another page.
            limit: limit + 1,
        })
        .await?;
    let more = rows.len() > limit as usize;
    let mut jobs = Vec::with_capacity(rows.len());
    for row in rows.into_iter().take(limit as usize) {
        jobs.push(job_view(&app, row).await?);
    }
    let last = jobs.last().filter(|_| more);
    let last = last.map(|job| page::token(&listing, &job.id.to_string()));
    Ok(Json(JobPage {
        jobs,
        next_page_token: last,
    }))
}

/// One job.
///
/// The `ETag` stays the same as long as nothing happens to the job; fields that
/// follow from the time alone do not count.
#[utoipa::path(
    get,
    path = routes::JOB,
    operation_id = "get_job",
    tag = "jobs",
    params(
        ("id" = i64, Path, description = "the job's number", minimum = 1),
        ("If-None-Match" = Option<String>, Header, description = "an `ETag`")
    ),
    responses(
        (status = 200, description = "The job", body = JobView, headers(("ETag" = String))),
        (status = 304, description = "Nothing has happened to it"),
        Fails<404>
    )
)]
pub(crate) async fn get_job(
    State(app): State<Arc<App>>,
    Segment(id): Segment,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let id = job_id(&id)?;
    let row = app.store.job(id).await?.ok_or_else(|| no_job(id))?;
    let view = job_view(&app, row).await?;
    tagged_json(&headers, &view, &meaning(&view))
}

/// Stop a job. One that has ended stays as it is: cancelling twice is the same
/// as once.
#[utoipa::path(
    post,
    path = routes::JOB_CANCEL,
    operation_id = "cancel_job",
    tag = "jobs",
    params(("id" = i64, Path, description = "the job's number", minimum = 1)),
    responses((status = 200, description = "The job", body = JobView), Fails<404>)
)]
pub(crate) async fn cancel(
    State(app): State<Arc<App>>,
    Segment(id): Segment,
) -> Result<Json<JobView>, ApiError> {
    let id = job_id(&id)?;
    if app.store.cancel(id, now_ms()).await? {
        tracing::info!(job = id.0, "cancelled");
        app.job_changed();
    }
    let row = app.store.job(id).await?.ok_or_else(|| no_job(id))?;
    Ok(Json(job_view(&app, row).await?))
}

/// Forget a job and its pictures; a running one stops.
#[utoipa::path(
    delete,
    path = routes::JOB,
    operation_id = "delete_job",
    tag = "jobs",
    params(("id" = i64, Path, description = "the job's number", minimum = 1)),
    responses((status = 204, description = "It is gone"), Fails<404>)
)]
pub(crate) async fn delete(
    State(app): State<Arc<App>>,
    Segment(id): Segment,
) -> Result<StatusCode, ApiError> {
    let id = job_id(&id)?;
    if !app.store.delete_job(id).await? {
        return Err(no_job(id));
    }
    tracing::info!(job = id.0, "deleted");
    app.job_changed();
    app.deleted.notify_one();
    Ok(StatusCode::NO_CONTENT)
}
