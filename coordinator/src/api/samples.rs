//! `POST /v1/jobs/{id}/samples`: add samples to a job.

use super::extract::{JsonBody, Segment, job_id, no_job};
use super::idempotency::{self, HEADER};
use super::openapi::Fails;
use super::problem::ApiError;
use super::view::job_view;
use crate::app::{App, now_ms};
use crate::farm::extended;
use crate::store::Ended;
use axum::Json;
use axum::extract::State;
use axum::http::HeaderMap;
use shearwater_shared::api::{AddSamples, JobView};
use shearwater_shared::routes;
use std::sync::Arc;

/// Tries at an addition while others add to the same job.
const TRIES_MAX: u32 = 4;

/// Continue a job, finished or not, to more samples, a smaller error, or beyond
/// its time. What is rendered stays.
#[utoipa::path(
    post,
    path = routes::JOB_SAMPLES,
    operation_id = "add_samples",
    tag = "jobs",
    params(
        ("id" = i64, Path, description = "the job's number", minimum = 1),
        ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,200}$",
            description = "a repetition of the same body with the same key adds nothing")
    ),
    request_body = AddSamples,
    responses(
        (status = 200, description = "The job, going on", body = JobView),
        Fails<400>, Fails<404>, Fails<408>, Fails<409>, Fails<413>, Fails<415>, Fails<422>
    )
)]
pub(crate) async fn add(
    State(app): State<Arc<App>>,
    Segment(id): Segment,
    headers: HeaderMap,
    JsonBody(asked): JsonBody<AddSamples>,
) -> Result<Json<JobView>, ApiError> {
    let id = job_id(&id)?;
    let scope = format!("{HEADER} of samples of job {id}");
    let key = idempotency::key(&headers, &scope, &asked)?;
    for _ in 0..TRIES_MAX {
        let row = app.store.job(id).await?.ok_or_else(|| no_job(id))?;
        if let Some(key) = &key
            && idempotency::was_done(&app, key).await?
        {
            return Ok(Json(job_view(&app, row).await?));
        }
        match &row.ended {
            Ended::No => {}
            Ended::Cancelled => return Err(ApiError::NotDone(id.0, "cancelled")),
            Ended::Failed(..) => return Err(ApiError::NotDone(id.0, "given up")),
        }
        if let Some(first) = row
            .build
            .as_ref()
            .filter(|first| **first != app.config.build)
        {
            return Err(ApiError::JobBuild {
                job: id.0,
                first: first.clone(),
                build: app.config.build.clone(),
            });
        }
        let new = extended(&row.settings, &asked).map_err(|e| ApiError::Invalid(e.to_string()))?;
        if app.store.extend(&row, &new, key.as_ref(), now_ms()).await? {
            tracing::info!(job = id.0, samples = new.samples, "samples added");
            app.work_came();
            let row = app.store.job(id).await?.ok_or_else(|| no_job(id))?;
            return Ok(Json(job_view(&app, row).await?));
        }
    }
    Err(ApiError::Busy)
}
