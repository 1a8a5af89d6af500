//! Jobs: list, show, cancel, delete.

use super::extract::{Segment, job_id, no_job, query};
use super::problem::ApiError;
use super::view::job_view;
use crate::app::{App, now_ms};
use crate::store::JobFilter;
use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use axum::http::StatusCode;
use serde::Deserialize;
use shearwater_shared::api::{JobPage, JobView};
use shearwater_shared::job::JobState;
use std::sync::Arc;

/// Jobs on a page when the client does not say.
const PAGE_SIZE: u32 = 50;
/// Most jobs on a page: each is read with its counts.
const PAGE_SIZE_MAX: u32 = 200;

/// Query of a listing.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ListQuery {
    page_size: Option<u32>,
    page_token: Option<String>,
    state: Option<JobState>,
}

/// A page of jobs, newest first.
pub(crate) async fn list(
    State(app): State<Arc<App>>,
    params: Result<Query<ListQuery>, QueryRejection>,
) -> Result<Json<JobPage>, ApiError> {
    let params = query(params)?;
    let limit = params
        .page_size
        .unwrap_or(PAGE_SIZE)
        .clamp(1, PAGE_SIZE_MAX);
    let below = match params.page_token.as_deref() {
        None | Some("") => i64::MAX,
        Some(token) => token.parse().map_err(|_| {
            ApiError::BadRequest("page_token: pass the next_page_token of the last answer".into())
        })?,
    };
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
    let last = jobs.last().map(|job| job.id.to_string());
    Ok(Json(JobPage {
        jobs,
        next_page_token: last.filter(|_| more),
    }))
}

/// One job.
pub(crate) async fn get_job(
    State(app): State<Arc<App>>,
    Segment(id): Segment,
) -> Result<Json<JobView>, ApiError> {
    let id = job_id(&id)?;
    let row = app.store.job(id).await?.ok_or_else(|| no_job(id))?;
    Ok(Json(job_view(&app, row).await?))
}

/// Stop a job. One that has ended stays as it is: cancelling twice is the same
/// as once.
pub(crate) async fn cancel(
    State(app): State<Arc<App>>,
    Segment(id): Segment,
) -> Result<Json<JobView>, ApiError> {
    let id = job_id(&id)?;
    if app.store.cancel(id, now_ms()).await? {
        tracing::info!(job = %id, "cancelled");
        app.job_changed();
    }
    let row = app.store.job(id).await?.ok_or_else(|| no_job(id))?;
    Ok(Json(job_view(&app, row).await?))
}

/// Forget a job and its pictures; a running one stops.
pub(crate) async fn delete(
    State(app): State<Arc<App>>,
    Segment(id): Segment,
) -> Result<StatusCode, ApiError> {
    let id = job_id(&id)?;
    if !app.store.delete_job(id).await? {
        return Err(no_job(id));
    }
    tracing::info!(job = %id, "deleted");
    app.job_changed();
    app.deleted.notify_one();
    Ok(StatusCode::NO_CONTENT)
}
