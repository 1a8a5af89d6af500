//! `POST /v1/worker/results`: sums of one run.
//!
//! Checked, made durable, counted, acknowledged: in this order. A result is
//! taken whatever became of its lease.

use super::extract::{no_job, read_body};
use super::leases::check_numeric_build;
use super::openapi::{Fails, Octets};
use super::problem::ApiError;
use crate::app::{App, now_ms};
use crate::farm::{QUARANTINE_MS, bad_samples_reason, is_audited, too_many_bad};
use crate::store::{CommitOutcome, JobRow, PartRecord};
use crate::unit_log;
use axum::Json;
use axum::body::Body;
use axum::extract::State;
use axum::http::HeaderMap;
use shearwater_shared::api::ResultResponse;
use shearwater_shared::hash::ContentHash;
use shearwater_shared::job::JobId;
use shearwater_shared::limits::{NAME_BYTES_MAX, RUN_SAMPLES_PER_HALF_MAX};
use shearwater_shared::routes;
use shearwater_shared::wire::{self, MESSAGE_BYTES_MAX, PartUpload, WireError};
use std::sync::Arc;
use tracing::Instrument;

/// Most microseconds of cores that a run may name: two weeks, far above any run,
/// and small enough that eight million of them fit into 63 bits.
const CORE_US_MAX: u64 = 1 << 40;

/// Take one run's sums: bytes as in `shared/src/wire.rs`.
#[utoipa::path(
    post,
    path = routes::WORKER_RESULTS,
    operation_id = "deliver_result",
    tag = "worker protocol",
    request_body(content = Octets, content_type = "application/vnd.shearwater.v1+bincode"),
    responses(
        (status = 200, description = "Durable and counted", body = ResultResponse),
        Fails<400>, Fails<404>, Fails<408>, Fails<409>, Fails<410>, Fails<413>, Fails<415>, Fails<422>
    )
)]
pub(crate) async fn result(
    State(app): State<Arc<App>>,
    headers: HeaderMap,
    body: Body,
) -> Result<Json<ResultResponse>, ApiError> {
    let answer = take(app.clone(), headers, body).await;
    let duplicate = answer.as_ref().map(|answer| answer.duplicate);
    app.metrics.results.answered(duplicate);
    answer
}

async fn take(
    app: Arc<App>,
    headers: HeaderMap,
    body: Body,
) -> Result<Json<ResultResponse>, ApiError> {
    let _permit = app
        .results_under_way
        .acquire()
        .await
        .map_err(|_| ApiError::Busy)?;
    let body = read_body(&headers, body, wire::CONTENT_TYPE, MESSAGE_BYTES_MAX).await?;
    let _timed = app.metrics.results.received(body.len());
    let sealed = app
        .compute(move || wire::decode_part(&body).and_then(seal))
        .await?
        .map_err(refusal)?;
    let upload = &sealed.upload;
    check_numeric_build(&app, &upload.build)?;
    let job = known_job(&app, upload).await?;
    // A client that goes away must not stop this between object and row.
    let counting = Arc::clone(&app);
    let span = unit_log::span(upload);
    let task = tokio::spawn(async move { count(&counting, &job, sealed).await }.instrument(span));
    task.await.map_err(|e| ApiError::Internal(e.to_string()))?
}

/// The job of a result that may be of it.
async fn known_job(app: &App, upload: &PartUpload) -> Result<Arc<JobRow>, ApiError> {
    let known = app.known.job(&app.store, upload.job).await?;
    if let Some(job) = known
        && check_build(&job, &upload.build)
            .and_then(|()| check(&job, upload))
            .is_ok()
    {
        return Ok(job);
    }
    // It may have changed since: samples are added to jobs.
    let job = app.known.job_now(&app.store, upload.job).await?;
    let job = job.ok_or_else(|| no_job(upload.job))?;
    check_build(&job, &upload.build)?;
    check(&job, upload)?;
    Ok(job)
}

/// Refuse what another numeric build than the job's rendered.
fn check_build(job: &JobRow, build: &str) -> Result<(), ApiError> {
    match &job.build {
        Some(first) if first != build => Err(other_build(job.id, first, build)),
        _ => Ok(()),
    }
}

fn other_build(job: JobId, first: &str, build: &str) -> ApiError {
    ApiError::JobBuild {
        job: job.0,
        first: first.to_owned(),
        build: build.to_owned(),
    }
}

fn refusal(error: WireError) -> ApiError {
    match error {
        WireError::TooLong(_) => ApiError::TooLarge(MESSAGE_BYTES_MAX as u64),
        WireError::Version(theirs) => ApiError::Protocol {
            ours: wire::PROTOCOL_VERSION,
            theirs,
            version: env!("CARGO_PKG_VERSION"),
        },
        other => ApiError::BadRequest(other.to_string()),
    }
}

/// Whether the sums can be those of the run that they name.
fn check(job: &JobRow, upload: &PartUpload) -> Result<(), ApiError> {
    let plan = job.plan();
    let run = &upload.run;
    let no_run = || {
        ApiError::Invalid(format!(
            "run: job {} has no frame {}, tile {}, blocks {} to {}",
            job.id, run.frame, run.tile, run.block0, run.block1
        ))
    };
    if run.frame >= job.settings.frames
        || upload.worker.len() > NAME_BYTES_MAX
        || upload.worker.contains('\0')
    {
        return Err(no_run());
    }
    let samples = plan.sample_range(run).ok_or_else(no_run)?;
    let rect = plan.tile_rect(run.tile).ok_or_else(no_run)?;
    if samples.end - samples.start > RUN_SAMPLES_PER_HALF_MAX {
        return Err(ApiError::Invalid(format!(
            "run: more than {RUN_SAMPLES_PER_HALF_MAX} samples per half"
        )));
    }
    upload
        .sums
        .check(&rect, &samples)
        .map_err(|e| ApiError::Invalid(format!("sums: {e}")))?;
    // Counts are summed per job in 63 bits, for millions of runs.
    let most = plan.run_samples(run);
    if upload.sums.depth_cap_hits > most {
        return Err(ApiError::Invalid(format!(
            "sums: depth_cap_hits is {}, the run has {most} samples",
            upload.sums.depth_cap_hits
        )));
    }
    if upload.core_us > CORE_US_MAX {
        return Err(ApiError::Invalid(format!(
            "core_us is {}, at most {CORE_US_MAX}",
            upload.core_us
        )));
    }
    Ok(())
}

/// A result with what is kept of it.
struct Sealed {
    upload: PartUpload,
    /// Tells equal results from unequal ones.
    sums_hash: ContentHash,
    /// The sums.
    bytes: Vec<u8>,
}

fn seal(mut upload: PartUpload) -> Result<Sealed, WireError> {
    // Which bad samples are described may depend on the order of threads.
    let listed = std::mem::take(&mut upload.sums.bad.listed);
    let mut bytes = wire::encode_sums(&upload.sums)?;
    let sums_hash = ContentHash::of(&bytes);
    if !listed.is_empty() {
        upload.sums.bad.listed = listed;
        bytes = wire::encode_sums(&upload.sums)?;
    }
    Ok(Sealed {
        upload,
        sums_hash,
        bytes,
    })
}

async fn count(app: &App, job: &JobRow, sealed: Sealed) -> Result<Json<ResultResponse>, ApiError> {
    let Sealed {
        upload,
        sums_hash,
        bytes,
    } = sealed;
    let part = PartRecord {
        job: upload.job,
        run: upload.run,
        lease: upload.lease,
        build: upload.build,
        sums_hash,
        object: app.objects.part_name(upload.job, &upload.run),
        samples: job.plan().run_samples(&upload.run),
        core_us: upload.core_us,
        audited: is_audited(
            job.audit_salt,
            upload.job,
            &upload.run,
            app.config.audit_ppm,
        ),
        bad_samples: upload.sums.bad.total(),
        depth_cap_hits: upload.sums.depth_cap_hits,
        worker: upload.worker,
    };
    for bad in &upload.sums.bad.listed {
        let frame = job.settings.absolute_frame(part.run.frame);
        tracing::warn!(job = part.job.0, frame, ?bad, "bad sample");
    }
    app.objects.put(&part.object, bytes).await?;
    let outcome = app.results.ask(part.clone()).await;
    let outcome = outcome.ok_or(ApiError::Busy)??;
    if outcome != CommitOutcome::Counted {
        app.objects.delete(&part.object).await?;
    }
    tracing::debug!(?outcome, samples = part.samples, "result");
    answer(app, &part, outcome).await
}

async fn answer(
    app: &App,
    part: &PartRecord,
    outcome: CommitOutcome,
) -> Result<Json<ResultResponse>, ApiError> {
    match outcome {
        CommitOutcome::Counted => {
            app.metrics.results.counted(part);
            if part.bad_samples > 0 {
                fail_if_too_bad(app, part.job, part.run.frame).await?;
            }
            if part.audited {
                // Another worker may have it.
                app.work_came();
            } else {
                app.job_changed();
            }
            Ok(Json(ResultResponse { duplicate: false }))
        }
        CommitOutcome::Duplicate => Ok(Json(ResultResponse { duplicate: true })),
        CommitOutcome::Overlap => {
            app.work_came();
            Ok(Json(ResultResponse { duplicate: true }))
        }
        CommitOutcome::Unequal { first_worker } => {
            tracing::error!(job = part.job.0, run = ?part.run, worker = part.worker, first_worker,
                "ALARM: two workers delivered different sums for one run; the first are kept until a third has it");
            app.work_came();
            Err(ApiError::Unequal)
        }
        CommitOutcome::OtherBuild { first } => Err(other_build(part.job, &first, &part.build)),
        CommitOutcome::Distrusted => {
            let reason = app.store.distrust_of(&part.worker).await?;
            let seconds = QUARANTINE_MS / 1000;
            Err(ApiError::Quarantined(seconds, reason.unwrap_or_default()))
        }
        CommitOutcome::Ended => Err(ApiError::Ended(part.job.0)),
        CommitOutcome::Unknown => {
            let job = app.known.job_now(&app.store, part.job).await?;
            job.ok_or_else(|| no_job(part.job))?;
            Err(ApiError::Invalid(
                "run: nobody was given this run yet; send only what was leased".into(),
            ))
        }
    }
}

async fn fail_if_too_bad(app: &App, id: JobId, frame: u32) -> Result<(), ApiError> {
    let Some(job) = app.known.job(&app.store, id).await? else {
        return Ok(());
    };
    let bad = app.store.bad_samples(id, frame).await?;
    let frame_samples = job.plan().frame_samples();
    if too_many_bad(bad, frame_samples) {
        let reason = bad_samples_reason(job.settings.absolute_frame(frame), bad, frame_samples);
        app.store.fail_job(id, None, &reason, now_ms()).await?;
    }
    Ok(())
}
