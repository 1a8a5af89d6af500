//! The worker protocol but for results: leases, heartbeats, failures, release.

use super::extract::{JsonBody, check_worker, no_job};
use super::openapi::Fails;
use super::problem::ApiError;
use crate::app::{App, now_ms};
use crate::dispatch::{Dispatch, Question};
use crate::farm::{QUARANTINE_MS, should_quarantine, unit_is_poison};
use crate::store::{Beat, WorkerRow};
use crate::unit_log;
use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use shearwater_shared::api::{
    FailureKind, FailureReport, HeartbeatRequest, HeartbeatResponse, Lease, LeaseRequest,
    ReleaseRequest,
};
use shearwater_shared::limits::LEASE_WAIT_MS_MAX;
use shearwater_shared::plan::Run;
use shearwater_shared::routes;
use shearwater_shared::wire::PROTOCOL_VERSION;
use std::sync::Arc;
use std::time::Duration;
use tokio::time::Instant;

/// Most leases that one worker names at once; it should hold two.
const LEASES_NAMED_MAX: usize = 64;
/// Longest reason of a failure that is kept, in characters.
const REASON_CHARS_MAX: usize = 1000;
/// Most threads and samples per second that a worker may claim to have.
const THREADS_MAX: u32 = 4096;
const SAMPLES_PER_S_MAX: f64 = 1e12;

/// Work for a worker; waits for it up to `wait_ms`, then 204.
#[utoipa::path(
    post,
    path = routes::WORKER_LEASES,
    operation_id = "lease_work",
    tag = "worker protocol",
    request_body = LeaseRequest,
    responses(
        (status = 200, description = "Work", body = Lease),
        (status = 204, description = "Nothing within the wait"),
        Fails<400>, Fails<403>, Fails<408>, Fails<409>, Fails<413>, Fails<415>, Fails<422>
    )
)]
pub(crate) async fn lease(
    State(app): State<Arc<App>>,
    JsonBody(mut request): JsonBody<LeaseRequest>,
) -> Result<Response, ApiError> {
    let asked = Instant::now();
    check_worker(&request.worker)?;
    check_build(&app, &request)?;
    request.threads = request.threads.clamp(1, THREADS_MAX);
    if !(0.0..=SAMPLES_PER_S_MAX).contains(&request.samples_per_s) {
        request.samples_per_s = 0.0;
    }
    let _waiter = app.waiters.try_acquire().map_err(|_| ApiError::Busy)?;
    let row = WorkerRow {
        instance: request.worker.instance.clone(),
        name: request.worker.name.clone(),
        threads: request.threads,
        milli_samples_per_s: (request.samples_per_s * 1000.0) as u64,
        seen_ms: now_ms(),
        distrusted: false,
        quarantined_until_ms: 0,
        quarantine_reason: None,
    };
    app.presence.asked(row).await?;
    let wait = Duration::from_millis(request.wait_ms.min(LEASE_WAIT_MS_MAX));
    let deadline = Instant::now() + wait;
    let worker = request.worker.clone();
    let mut stopping = app.stopping.subscribe();
    let answer = tokio::select! {
        answer = app.questions.ask(Question { request, deadline }) => answer,
        _ = stopping.wait_for(|stop| *stop) => None,
    };
    match answer.transpose()? {
        Some(Dispatch::Lease(lease)) => {
            app.metrics.leases.waited(asked.elapsed());
            unit_log::leased(&lease, &worker);
            Ok(Json(*lease).into_response())
        }
        Some(Dispatch::Quarantined(until_ms, reason)) => {
            let seconds = (until_ms - now_ms()).max(0) / 1000;
            Err(ApiError::Quarantined(seconds, reason))
        }
        Some(Dispatch::Nothing) | None => Ok(StatusCode::NO_CONTENT.into_response()),
    }
}

fn check_build(app: &App, request: &LeaseRequest) -> Result<(), ApiError> {
    if request.protocol != PROTOCOL_VERSION {
        return Err(ApiError::Protocol {
            ours: PROTOCOL_VERSION,
            theirs: request.protocol,
            version: env!("CARGO_PKG_VERSION"),
        });
    }
    check_numeric_build(app, &request.build)
}

/// Refuse a worker whose pixels would differ.
pub(super) fn check_numeric_build(app: &App, build: &str) -> Result<(), ApiError> {
    if build == app.config.build {
        return Ok(());
    }
    Err(ApiError::Build {
        farm: app.config.build.clone(),
        worker: build.chars().take(200).collect(),
        version: env!("CARGO_PKG_VERSION"),
    })
}

fn check_leases(ids: &[i64]) -> Result<(), ApiError> {
    if ids.len() > LEASES_NAMED_MAX {
        return Err(ApiError::Invalid(format!(
            "leases: at most {LEASES_NAMED_MAX}"
        )));
    }
    Ok(())
}

/// Keep leases alive; tell which of them nobody waits for.
#[utoipa::path(
    post,
    path = routes::WORKER_HEARTBEAT,
    operation_id = "heartbeat",
    tag = "worker protocol",
    request_body = HeartbeatRequest,
    responses(
        (status = 200, description = "Leases to drop", body = HeartbeatResponse),
        Fails<400>, Fails<408>, Fails<413>, Fails<415>, Fails<422>
    )
)]
pub(crate) async fn heartbeat(
    State(app): State<Arc<App>>,
    JsonBody(request): JsonBody<HeartbeatRequest>,
) -> Result<Json<HeartbeatResponse>, ApiError> {
    check_worker(&request.worker)?;
    check_leases(&request.leases)?;
    let (instance, now_ms) = (&request.worker.instance, now_ms());
    app.presence.seen(instance, now_ms);
    if request.leases.is_empty() {
        return Ok(Json(HeartbeatResponse { drop: Vec::new() }));
    }
    let beat = |&lease: &i64| Beat {
        lease,
        worker: instance.clone(),
    };
    let beats = request.leases.iter().map(beat).collect();
    let wanted = app.beats.ask(beats).await.ok_or(ApiError::Busy)??;
    let mut drop = Vec::new();
    for &id in &request.leases {
        if !wanted.contains(&id) {
            app.store.release(instance, id, now_ms).await?;
            drop.push(id);
        }
    }
    Ok(Json(HeartbeatResponse { drop }))
}

/// Take a report that a run cannot be rendered.
#[utoipa::path(
    post,
    path = routes::WORKER_FAILURES,
    operation_id = "report_failure",
    tag = "worker protocol",
    request_body = FailureReport,
    responses(
        (status = 204, description = "Noted"),
        Fails<400>, Fails<404>, Fails<408>, Fails<413>, Fails<415>, Fails<422>
    )
)]
pub(crate) async fn failure(
    State(app): State<Arc<App>>,
    JsonBody(report): JsonBody<FailureReport>,
) -> Result<StatusCode, ApiError> {
    check_worker(&report.worker)?;
    let instance = &report.worker.instance;
    let lease = app.store.lease(report.lease).await?;
    let lease = lease
        .filter(|lease| lease.worker == *instance && lease.job == report.job)
        .ok_or_else(|| {
            ApiError::NotFound(format!("lease {} is not this worker's", report.lease))
        })?;
    let runs = match report.run {
        Some(run) if lease.runs.contains(&run) => vec![run],
        Some(_) => return Err(ApiError::Invalid("run: it is not of this lease".into())),
        None => of_frame(lease.runs, report.frame)?,
    };
    app.store
        .job_rev(report.job)
        .await?
        .ok_or_else(|| no_job(report.job))?;
    app.metrics.leases.failed.inc();
    // PostgreSQL stores no text with a NUL.
    let said = report.reason.chars().filter(|&c| c != '\0');
    let reason: String = said.take(REASON_CHARS_MAX).collect();
    let worker = &report.worker.name;
    if report.kind == FailureKind::Scene {
        tracing::info!(job = report.job.0, worker, reason, "the scene is wrong");
        app.store
            .fail_job(report.job, Some(report.kind), &reason, now_ms())
            .await?;
        app.job_changed();
        return Ok(StatusCode::NO_CONTENT);
    }
    tracing::warn!(job = report.job.0, worker, reason, "a worker failed");
    let (failures, streak) = app
        .store
        .record_failure(report.job, report.lease, &runs, instance, &reason, now_ms())
        .await?;
    if unit_is_poison(failures) {
        let what = format!(
            "{} workers failed {} times on the same unit; the last one said: {reason}",
            failures.workers, failures.times
        );
        app.store
            .fail_job(report.job, Some(report.kind), &what, now_ms())
            .await?;
    } else if should_quarantine(streak) {
        tracing::error!(worker = report.worker.name, instance, "quarantined");
        let why = format!("it failed on different units in a row; the last time: {reason}");
        app.store
            .quarantine(instance, now_ms() + QUARANTINE_MS, &why)
            .await?;
        app.presence.refresh(&app.store, now_ms()).await?;
    }
    app.work_came();
    Ok(StatusCode::NO_CONTENT)
}

/// The runs of one frame, if one is named.
fn of_frame(mut runs: Vec<Run>, frame: Option<u32>) -> Result<Vec<Run>, ApiError> {
    if let Some(frame) = frame {
        runs.retain(|run| run.frame == frame);
    }
    if runs.is_empty() {
        return Err(ApiError::Invalid(
            "frame: the lease has no run of it".into(),
        ));
    }
    Ok(runs)
}

/// Take leases back undone.
#[utoipa::path(
    post,
    path = routes::WORKER_RELEASE,
    operation_id = "release_leases",
    tag = "worker protocol",
    request_body = ReleaseRequest,
    responses(
        (status = 204, description = "They are handed out again"),
        Fails<400>, Fails<408>, Fails<413>, Fails<415>, Fails<422>
    )
)]
pub(crate) async fn release(
    State(app): State<Arc<App>>,
    JsonBody(request): JsonBody<ReleaseRequest>,
) -> Result<StatusCode, ApiError> {
    check_worker(&request.worker)?;
    check_leases(&request.leases)?;
    for &id in &request.leases {
        let instance = &request.worker.instance;
        let released = app.store.release(instance, id, now_ms()).await?;
        app.metrics.leases.released.inc_by(released.into());
    }
    app.work_came();
    Ok(StatusCode::NO_CONTENT)
}
