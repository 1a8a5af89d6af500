//! `GET /v1/jobs/{id}/log`: what happened to a job's units.

use super::extract::{Segment, job_id, no_job, query};
use super::openapi::Fails;
use super::page::{self, PageQuery};
use super::problem::ApiError;
use crate::app::App;
use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use shearwater_shared::api::LogPage;
use shearwater_shared::routes;
use std::sync::Arc;

/// Events on a page when the client does not say.
const PAGE_SIZE: u32 = 100;
/// Most events on a page: an answer of some hundred KiB.
const PAGE_SIZE_MAX: u32 = 1000;

/// A page of a job's log, newest first; 100 events when nothing is said, at most 1,000.
#[utoipa::path(
    get,
    path = routes::JOB_LOG,
    operation_id = "list_log",
    tag = "jobs",
    params(("id" = i64, Path, description = "the job's number", minimum = 1), PageQuery),
    responses((status = 200, description = "The page", body = LogPage), Fails<400>, Fails<404>, Fails<422>)
)]
pub(crate) async fn list(
    State(app): State<Arc<App>>,
    Segment(id): Segment,
    params: Result<Query<PageQuery>, QueryRejection>,
) -> Result<Json<LogPage>, ApiError> {
    let params = query(params)?;
    let id = job_id(&id)?;
    app.store.job_rev(id).await?.ok_or_else(|| no_job(id))?;
    let limit = params.page_size.unwrap_or(PAGE_SIZE);
    let limit = limit.clamp(1, PAGE_SIZE_MAX);
    let listing = format!("log {id}");
    let below = page::number(&listing, params.page_token.as_deref())?.unwrap_or(i64::MAX);
    // One more than asked for says whether there is another page.
    let mut events = app.store.log(id, below, limit + 1).await?;
    let more = events.len() > limit as usize;
    events.truncate(limit as usize);
    let last = events.last().filter(|_| more);
    Ok(Json(LogPage {
        next_page_token: last.map(|event| page::token(&listing, &event.seq.to_string())),
        events,
    }))
}
