//! `POST /v1/jobs`.

use super::extract::JsonBody;
use super::problem::ApiError;
use super::settings;
use super::view::job_view;
use crate::app::{App, now_ms};
use crate::objects::Objects;
use crate::store::{NewJob, Submitted};
use axum::Json;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use shearwater_shared::api::SubmitRequest;
use shearwater_shared::hash::ContentHash;
use shearwater_shared::job::JobId;
use shearwater_shared::limits;
use shearwater_shared::routes;
use shearwater_shared::scene::{self, SceneDescription};
use std::sync::Arc;

/// Longest idempotency key, in bytes; a UUID has 36.
const KEY_BYTES_MAX: usize = 200;

type SubmitBody = JsonBody<SubmitRequest, { limits::SUBMIT_BODY_BYTES_MAX }>;

/// Check and store a job. 201 with its place; 200 when the idempotency key is
/// known.
pub(crate) async fn submit(
    State(app): State<Arc<App>>,
    headers: HeaderMap,
    JsonBody(request): SubmitBody,
) -> Result<Response, ApiError> {
    let idempotency = idempotency(&headers, &request)?;
    let scene = checked_scene(&app, &request).await?;
    let settings = settings::merged(&request.settings, &scene)?;
    let name = request.name.unwrap_or(scene.name);
    if name.contains('\0') {
        // PostgreSQL stores no such text.
        return Err(ApiError::Invalid("name: must not hold a NUL character".into()));
    }
    let new = NewJob {
        name,
        manifest: request.manifest,
        settings,
        post: scene.post,
        fps: scene.animation.map(|animation| animation.fps),
        animation_frames: scene.animation.map(|animation| animation.frames),
        priority: request.priority,
        idempotency,
    };
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
        tracing::info!(job = %id, name = new.name, "job submitted");
        app.work_came();
    }
    created(&app, id, status).await
}

async fn created(app: &App, id: JobId, status: StatusCode) -> Result<Response, ApiError> {
    let row = app.store.job(id).await?;
    let row = row.ok_or_else(|| super::extract::no_job(id))?;
    let place = routes::fill(routes::JOB, &id.to_string());
    let view = job_view(app, row).await?;
    Ok((status, [(header::LOCATION, place)], Json(view)).into_response())
}

fn idempotency(
    headers: &HeaderMap,
    request: &SubmitRequest,
) -> Result<Option<(String, ContentHash)>, ApiError> {
    let Some(key) = headers.get("idempotency-key") else {
        return Ok(None);
    };
    let key = key
        .to_str()
        .ok()
        .filter(|key| (1..=KEY_BYTES_MAX).contains(&key.len()))
        .ok_or_else(|| {
            ApiError::BadRequest(format!(
                "Idempotency-Key must be 1 to {KEY_BYTES_MAX} visible ASCII characters"
            ))
        })?;
    // The meaning of the body, not its spelling.
    let body = serde_json::to_vec(request).map_err(|e| ApiError::Internal(e.to_string()))?;
    Ok(Some((key.to_owned(), ContentHash::of(&body))))
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
