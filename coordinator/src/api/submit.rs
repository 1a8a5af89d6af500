//! `POST /v1/jobs`.

use super::extract::{JsonBody, query};
use super::idempotency;
use super::openapi::Fails;
use super::problem::ApiError;
use super::settings;
use super::view::job_view;
use crate::access::{Caller, Role};
use crate::app::{App, now_ms};
use crate::objects::Objects;
use crate::store::{IdempotencyKey, NewJob, NewWebhook, Submitted};
use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use shearwater_shared::api::{JobView, SubmitCheck, SubmitRequest, WebhookRequest};
use shearwater_shared::hash::ContentHash;
use shearwater_shared::job::JobId;
use shearwater_shared::limits;
use shearwater_shared::plan::Plan;
use shearwater_shared::routes;
use shearwater_shared::scene::{self, SceneDescription};
use std::hash::{BuildHasher, RandomState};
use std::sync::Arc;
use utoipa::{IntoParams, ToSchema};

/// Most jobs that have not ended: listing and choosing among them stays quick.
const JOBS_MAX: u64 = 10_000;
/// Most of them of one client's token, so that it leaves room for others.
const OWN_JOBS_MAX: u64 = 2_000;

type SubmitBody = JsonBody<SubmitRequest, { limits::SUBMIT_BODY_BYTES_MAX }>;

/// Query of a submission.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub(crate) struct SubmitQuery {
    /// Check everything and store nothing: the answer says what the job would be.
    #[serde(default)]
    #[param(default = false)]
    validate_only: bool,
}

/// Submit a job; its scene and files must be uploaded first. The answer is 201, or
/// 200 when the idempotency key is known.
#[utoipa::path(
    post,
    path = routes::JOBS,
    operation_id = "submit_job",
    tag = "jobs",
    params(
        SubmitQuery,
        ("Idempotency-Key" = Option<String>, Header, pattern = "^[!-~]{1,200}$",
            description = "a repetition of the same body with the same key within a day is the same job")
    ),
    request_body = SubmitRequest,
    responses(
        (status = 200, description = "The job that this key made before; or, with `validate_only`, what it would be",
            body = SubmitAnswer),
        (status = 201, description = "The job", body = JobView, headers(("Location" = String)),
            links(
                ("job" = (operation_id = "get_job", parameters(("id" = "$response.body#/id")))),
                ("frames" = (operation_id = "list_frames", parameters(("id" = "$response.body#/id")))),
                ("samples" = (operation_id = "add_samples", parameters(("id" = "$response.body#/id")))),
                ("cancel" = (operation_id = "cancel_job", parameters(("id" = "$response.body#/id")))),
                ("delete" = (operation_id = "delete_job", parameters(("id" = "$response.body#/id"))))
            )),
        Fails<400>, Fails<408>, Fails<413>, Fails<415>, Fails<422>
    )
)]
pub(crate) async fn submit(
    State(app): State<Arc<App>>,
    params: Result<Query<SubmitQuery>, QueryRejection>,
    caller: Caller,
    headers: HeaderMap,
    JsonBody(request): SubmitBody,
) -> Result<Response, ApiError> {
    let params = query(params)?;
    let key = idempotency::key(&headers, "", &request)?;
    check_queue(&app, &caller).await?;
    let new = checked(&app, caller, request, key).await?;
    if params.validate_only {
        return Ok(Json(would_be(new)).into_response());
    }
    let (id, status) = match app.store.submit(&new, now_ms()).await? {
        Submitted::New(id) => (id, StatusCode::CREATED),
        Submitted::Same(id) => (id, StatusCode::OK),
        Submitted::OtherBody(id) => return Err(ApiError::KeyReused(id.0)),
        Submitted::AssetMissing => {
            return Err(ApiError::Invalid(
                "manifest: a file was removed meanwhile, since nobody needed it; upload what is \
                 missing and submit again"
                    .into(),
            ));
        }
    };
    if status == StatusCode::CREATED {
        tracing::info!(job = id.0, name = new.name, "job submitted");
        app.work_came();
    }
    created(&app, id, status).await
}

/// A job that can be stored.
async fn checked(
    app: &App,
    caller: Caller,
    request: SubmitRequest,
    idempotency: Option<IdempotencyKey>,
) -> Result<NewJob, ApiError> {
    super::steer::check_priority(request.priority)?;
    let scene = checked_scene(app, &request).await?;
    let settings = settings::merged(&request.settings, &scene)?;
    let webhook = request
        .webhook
        .map(|asked| webhook(app, asked))
        .transpose()?;
    let name = request.name.unwrap_or(scene.name);
    if name.contains('\0') {
        // PostgreSQL stores no such text.
        return Err(ApiError::Invalid(
            "name: must not hold a NUL character".into(),
        ));
    }
    Ok(NewJob {
        name,
        manifest: request.manifest,
        settings,
        post: scene.post,
        fps: scene.animation.map(|animation| animation.fps),
        animation_frames: scene.animation.map(|animation| animation.frames),
        priority: request.priority,
        owner: caller.token,
        audit_salt: random_salt(),
        webhook,
        idempotency,
    })
}

/// Whom to tell, if that is allowed and can be signed.
fn webhook(app: &App, asked: WebhookRequest) -> Result<NewWebhook, ApiError> {
    let url = app.webhooks.check(&asked.url)?;
    let lengths = limits::WEBHOOK_SECRET_BYTES_MIN..=limits::WEBHOOK_SECRET_BYTES_MAX;
    match &asked.secret {
        // PostgreSQL stores no text with a NUL.
        Some(secret) if !lengths.contains(&secret.len()) || secret.contains('\0') => {
            Err(ApiError::Invalid(format!(
                "webhook.secret: expected {} to {} bytes, none of them 0",
                lengths.start(),
                lengths.end()
            )))
        }
        None if app.config.webhook_secret.is_none() => Err(ApiError::Invalid(
            "webhook.secret: the farm has none of its own, so name one".into(),
        )),
        _ => Ok(NewWebhook {
            url,
            secret: asked.secret,
        }),
    }
}

fn would_be(new: NewJob) -> SubmitCheck {
    let plan = Plan::new(&new.settings);
    let frames = u64::from(new.settings.frames);
    let units = plan.first_units(&new.settings.stop);
    SubmitCheck {
        name: new.name,
        settings: new.settings,
        fps: new.fps,
        animation_frames: new.animation_frames,
        units_total: units.saturating_mul(frames),
        samples_max: plan.frame_samples().saturating_mul(frames),
    }
}

/// What 200 answers a submission with, for the document.
#[derive(Debug, Serialize, ToSchema)]
#[serde(untagged)]
#[allow(dead_code)]
enum SubmitAnswer {
    Same(Box<JobView>),
    Check(Box<SubmitCheck>),
}

/// Refuse a job when there are too many that have not ended. Submissions at the
/// same moment may go beyond by their own number.
async fn check_queue(app: &App, caller: &Caller) -> Result<(), ApiError> {
    let queued = app.store.queued(caller.token.as_deref()).await?;
    let own = caller.role == Role::Client && caller.token.is_some();
    let (count, most, whose) = if queued.all >= JOBS_MAX {
        (queued.all, JOBS_MAX, "")
    } else if own && queued.own >= OWN_JOBS_MAX {
        (queued.own, OWN_JOBS_MAX, " of this token")
    } else {
        return Ok(());
    };
    Err(ApiError::QueueFull(format!(
        "{count} jobs{whose} have not ended yet, at most {most} may; wait, or cancel some"
    )))
}

async fn created(app: &App, id: JobId, status: StatusCode) -> Result<Response, ApiError> {
    let row = app.store.job(id).await?;
    let row = row.ok_or_else(|| super::extract::no_job(id))?;
    let place = routes::fill(routes::JOB, &id.to_string());
    let view = job_view(app, row).await?;
    Ok((status, [(header::LOCATION, place)], Json(view)).into_response())
}

/// A number that nobody else knows, from the keys of the standard library's hashes.
fn random_salt() -> i64 {
    RandomState::new().hash_one(now_ms()).cast_signed()
}

/// The scene, if it and every file it needs are stored and named.
async fn checked_scene(app: &App, request: &SubmitRequest) -> Result<SceneDescription, ApiError> {
    let manifest = &request.manifest;
    if request
        .name
        .as_ref()
        .is_some_and(|name| name.len() > limits::NAME_BYTES_MAX)
    {
        let most = limits::NAME_BYTES_MAX;
        return Err(ApiError::Invalid(format!("name: at most {most} bytes")));
    }
    if manifest.files.len() > limits::ASSETS_MAX {
        return Err(ApiError::Invalid(format!(
            "manifest.files: {} files, at most {}",
            manifest.files.len(),
            limits::ASSETS_MAX
        )));
    }
    for (name, asset) in &manifest.files {
        let at = || format!("manifest.files[{name:?}]");
        if name.is_empty() || name.len() > limits::ASSET_NAME_BYTES_MAX {
            let most = limits::ASSET_NAME_BYTES_MAX;
            return Err(ApiError::Invalid(format!(
                "{}: a name has 1 to {most} bytes",
                at()
            )));
        }
        match app.store.asset_size(&asset.hash).await? {
            Some(size) if size == asset.size => {}
            Some(size) => {
                return Err(ApiError::Invalid(format!(
                    "{}: size is {}, the stored asset has {size}",
                    at(),
                    asset.size
                )));
            }
            None => return Err(ApiError::Invalid(missing(&at(), &asset.hash))),
        }
    }
    let size = app.store.asset_size(&manifest.scene).await?;
    let size = size.ok_or_else(|| ApiError::Invalid(missing("manifest.scene", &manifest.scene)))?;
    if size > limits::SCENE_BYTES_MAX as u64 {
        return Err(ApiError::Invalid(format!(
            "manifest.scene: {size} bytes, a scene has at most {}",
            limits::SCENE_BYTES_MAX
        )));
    }
    let bytes = match app.objects.get(&Objects::asset_name(&manifest.scene)).await {
        Err(error) if error.is_missing() => {
            let text = missing("manifest.scene", &manifest.scene);
            return Err(ApiError::Invalid(text));
        }
        other => other?,
    };
    let scene = app
        .compute(move || scene::parse(&bytes))
        .await?
        .map_err(|e| ApiError::Invalid(e.to_string()))?;
    for file in scene.files() {
        if !manifest.files.contains_key(&file) {
            return Err(ApiError::Invalid(format!(
                "manifest.files lacks {file:?}, which the scene needs; name its hash and size"
            )));
        }
    }
    Ok(scene)
}

fn missing(at: &str, hash: &ContentHash) -> String {
    let place = routes::fill(routes::ASSET, &hash.to_string());
    format!("{at}: asset {hash} is not stored; PUT it to {place} first")
}
