//! What a user does to a job under way: pause, resume, retry, another priority.

use super::extract::{JsonBody, Segment, job_id, no_job};
use super::openapi::Fails;
use super::problem::ApiError;
use super::view::job_view;
use crate::app::{App, now_ms};
use crate::audit;
use crate::store::Ended;
use axum::Json;
use axum::extract::State;
use shearwater_shared::api::{ChangeJob, JobView};
use shearwater_shared::job::JobId;
use shearwater_shared::limits::{PRIORITY_MAX, PRIORITY_MIN};
use shearwater_shared::routes;
use std::sync::Arc;

/// Hand out nothing of a job for now. One that has ended or is paused stays as it is.
#[utoipa::path(
    post,
    path = routes::JOB_PAUSE,
    tag = "jobs",
    params(("id" = i64, Path, description = "the job's number", minimum = 1)),
    responses((status = 200, description = "The job", body = JobView), Fails<404>)
)]
pub(crate) async fn pause(
    State(app): State<Arc<App>>,
    Segment(id): Segment,
) -> Result<Json<JobView>, ApiError> {
    let id = job_id(&id)?;
    if app.store.pause(id, now_ms()).await? {
        tracing::info!(job = id.0, "paused");
        app.job_changed();
    }
    view(&app, id).await
}

/// Go on with a paused job. One that is not paused stays as it is.
#[utoipa::path(
    post,
    path = routes::JOB_RESUME,
    tag = "jobs",
    params(("id" = i64, Path, description = "the job's number", minimum = 1)),
    responses((status = 200, description = "The job", body = JobView), Fails<404>)
)]
pub(crate) async fn resume(
    State(app): State<Arc<App>>,
    Segment(id): Segment,
) -> Result<Json<JobView>, ApiError> {
    let id = job_id(&id)?;
    if app.store.resume(id, now_ms()).await? {
        tracing::info!(job = id.0, "resumed");
        app.work_came();
    }
    view(&app, id).await
}

/// Try a failed job again. One that is live stays as it is: retrying twice is the same
/// as once.
#[utoipa::path(
    post,
    path = routes::JOB_RETRY,
    tag = "jobs",
    params(("id" = i64, Path, description = "the job's number", minimum = 1)),
    responses((status = 200, description = "The job", body = JobView), Fails<404>, Fails<409>)
)]
pub(crate) async fn retry(
    State(app): State<Arc<App>>,
    Segment(id): Segment,
) -> Result<Json<JobView>, ApiError> {
    let id = job_id(&id)?;
    if app.store.retry(id, now_ms()).await? {
        tracing::info!(job = id.0, "tried again");
        audit::withdraw(&app).await?;
        app.work_came();
    } else {
        let row = app.store.job(id).await?.ok_or_else(|| no_job(id))?;
        match row.ended {
            Ended::Cancelled => return Err(ApiError::NotFailed(id.0, "was cancelled")),
            Ended::No if row.finished_ms.is_some() => {
                return Err(ApiError::NotFailed(id.0, "is done"));
            }
            Ended::No | Ended::Failed(..) => {}
        }
    }
    view(&app, id).await
}

/// Change what may be changed of a job.
#[utoipa::path(
    patch,
    path = routes::JOB,
    operation_id = "change_job",
    tag = "jobs",
    params(("id" = i64, Path, description = "the job's number", minimum = 1)),
    request_body = ChangeJob,
    responses(
        (status = 200, description = "The job", body = JobView),
        Fails<400>, Fails<404>, Fails<408>, Fails<413>, Fails<415>, Fails<422>
    )
)]
pub(crate) async fn change(
    State(app): State<Arc<App>>,
    Segment(id): Segment,
    JsonBody(asked): JsonBody<ChangeJob>,
) -> Result<Json<JobView>, ApiError> {
    let id = job_id(&id)?;
    let priority = asked
        .priority
        .ok_or_else(|| ApiError::Invalid("nothing to change: name a priority".into()))?;
    check_priority(priority)?;
    if app.store.set_priority(id, priority, now_ms()).await? {
        tracing::info!(job = id.0, priority, "priority changed");
        app.work_came();
    }
    view(&app, id).await
}

/// Refuse a priority out of its range.
pub(super) fn check_priority(priority: i32) -> Result<(), ApiError> {
    if (PRIORITY_MIN..=PRIORITY_MAX).contains(&priority) {
        return Ok(());
    }
    Err(ApiError::Invalid(format!(
        "priority is {priority}: expected {PRIORITY_MIN} to {PRIORITY_MAX}"
    )))
}

async fn view(app: &App, id: JobId) -> Result<Json<JobView>, ApiError> {
    let row = app.store.job(id).await?.ok_or_else(|| no_job(id))?;
    Ok(Json(job_view(app, row).await?))
}
