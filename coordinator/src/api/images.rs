//! Pictures of a job at any time, finished or not.

use super::conditional::{Tag, bytes_answer, unchanged};
use super::extract::{Segment, job_id, no_job, query};
use super::openapi::{Fails, Octets};
use super::problem::ApiError;
use crate::app::App;
use crate::develop::{self, Bloom, ExrAttributes, PngDepth, PostSettings, View};
use crate::fold::{self, Planes};
use crate::store::JobRow;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use axum::http::{HeaderMap, Method, header};
use axum::response::Response;
use serde::Deserialize;
use shearwater_shared::hash::ContentHash;
use shearwater_shared::routes;
use shearwater_shared::scene;
use shearwater_shared::stop::Stop;
use std::sync::Arc;
use tokio::sync::OwnedSemaphorePermit;
use utoipa::IntoParams;

/// Query of a developed picture; the scene decides what is not given.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub(crate) struct PngQuery {
    /// The scene's number of the frame; the job's first when nothing is said.
    #[param(nullable = false)]
    frame: Option<u32>,
    /// The tone curve.
    #[param(nullable = false, value_type = String, pattern = "^(agx|standard)$")]
    view: Option<scene::View>,
    /// Stops brighter or darker.
    #[param(nullable = false, minimum = -30.0, maximum = 30.0)]
    exposure_ev: Option<f32>,
    /// Whether the scene's bloom is added; does not invent one.
    #[param(nullable = false)]
    bloom: Option<bool>,
    /// Bits of a channel: 8 or 16.
    #[param(nullable = false, minimum = 8, maximum = 16, multiple_of = 8)]
    depth: Option<u32>,
}

/// Query of a linear picture.
#[derive(Debug, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub(crate) struct ExrQuery {
    /// The scene's number of the frame; the job's first when nothing is said.
    #[param(nullable = false)]
    frame: Option<u32>,
}

/// The developed picture.
///
/// Of a finished frame the `ETag` is strong and ranges are answered; before, the
/// picture changes, and a range is answered with all of it.
#[utoipa::path(
    get,
    path = routes::JOB_PNG,
    operation_id = "get_png",
    tag = "pictures",
    params(
        ("id" = i64, Path, description = "the job's number", minimum = 1),
        PngQuery,
        ("If-None-Match" = Option<String>, Header, description = "an `ETag`"),
        ("Range" = Option<String>, Header, description = "`bytes=` and one range"),
        ("If-Range" = Option<String>, Header, description = "an `ETag`")
    ),
    responses(
        (status = 200, description = "The picture", content_type = "image/png", body = Octets,
            headers(("ETag" = String))),
        (status = 206, description = "The range of it", content_type = "image/png", body = Octets,
            headers(("Content-Range" = String))),
        (status = 304, description = "The client has it"),
        Fails<400>, Fails<404>, Fails<416>
    )
)]
pub(crate) async fn png(
    State(app): State<Arc<App>>,
    Segment(id): Segment,
    params: Result<Query<PngQuery>, QueryRejection>,
    method: Method,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let params = query(params)?;
    let depth = match params.depth {
        None | Some(8) => PngDepth::Eight,
        Some(16) => PngDepth::Sixteen,
        Some(_) => return Err(ApiError::BadRequest("query: depth is 8 or 16".into())),
    };
    let (job, frame) = job_and_frame(&app, &id, params.frame).await?;
    let post = post_settings(&job.post, &params);
    post.check()?;
    let film = film_hash(&app, &job, frame).await?;
    let tag = etag(&job, frame, film, &format!("png {post:?} {depth:?}"));
    if tag.is_known(&headers) {
        return Ok(unchanged(&tag));
    }
    let permit = developing(&app).await?;
    let _timed = app.metrics.pictures.developing_png();
    let picture = fold::picture(&app, &job, frame, Planes::Beauty).await?;
    let bytes = app
        .compute(move || {
            let bytes = develop::develop_png(&picture, &post, depth);
            drop(permit);
            bytes
        })
        .await??;
    image((&method, &headers), "image/png", &tag, bytes)
}

/// The linear picture with its features.
///
/// Of a finished frame the `ETag` is strong and ranges are answered; before, the
/// picture changes, and a range is answered with all of it.
#[utoipa::path(
    get,
    path = routes::JOB_EXR,
    operation_id = "get_exr",
    tag = "pictures",
    params(
        ("id" = i64, Path, description = "the job's number", minimum = 1),
        ExrQuery,
        ("If-None-Match" = Option<String>, Header, description = "an `ETag`"),
        ("Range" = Option<String>, Header, description = "`bytes=` and one range"),
        ("If-Range" = Option<String>, Header, description = "an `ETag`")
    ),
    responses(
        (status = 200, description = "The picture", content_type = "image/x-exr", body = Octets,
            headers(("ETag" = String))),
        (status = 206, description = "The range of it", content_type = "image/x-exr", body = Octets,
            headers(("Content-Range" = String))),
        (status = 304, description = "The client has it"),
        Fails<400>, Fails<404>, Fails<416>
    )
)]
pub(crate) async fn exr(
    State(app): State<Arc<App>>,
    Segment(id): Segment,
    params: Result<Query<ExrQuery>, QueryRejection>,
    method: Method,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let (job, frame) = job_and_frame(&app, &id, query(params)?.frame).await?;
    let film = film_hash(&app, &job, frame).await?;
    let tag = etag(&job, frame, film, "exr");
    if tag.is_known(&headers) {
        return Ok(unchanged(&tag));
    }
    let permit = developing(&app).await?;
    let _timed = app.metrics.pictures.developing_exr();
    let picture = fold::picture(&app, &job, frame, Planes::All).await?;
    let attributes = ExrAttributes {
        software: concat!("Shearwater ", env!("CARGO_PKG_VERSION")).to_owned(),
        film_hash: film.map(|hash| hash.to_string()).unwrap_or_default(),
        scene_hash: job.manifest.scene.to_string(),
        job_id: job.id.to_string(),
        stop: stop_text(&job.settings.stop),
        samples_per_pixel: mean_samples(&picture.sample_count),
        render_seconds: (job.core_us as f64 / 1e6) as f32,
    };
    let bytes = app
        .compute(move || {
            let bytes = develop::encode_exr(&picture, &attributes);
            drop(permit);
            bytes
        })
        .await??;
    image((&method, &headers), "image/x-exr", &tag, bytes)
}

/// A place among those who develop; it goes with the computation, which a
/// client that goes away does not stop.
async fn developing(app: &App) -> Result<OwnedSemaphorePermit, ApiError> {
    let places = Arc::clone(&app.develops);
    places.acquire_owned().await.map_err(|_| ApiError::Busy)
}

/// The job, and the number within it of the scene's frame `frame`; its first one
/// when none is named.
pub(super) async fn job_and_frame(
    app: &App,
    id: &str,
    frame: Option<u32>,
) -> Result<(JobRow, u32), ApiError> {
    let id = job_id(id)?;
    let job = app.store.job(id).await?.ok_or_else(|| no_job(id))?;
    let (first, last) = (job.settings.first_frame, job.settings.last_frame());
    let asked = frame.unwrap_or(first);
    let frame = job.settings.job_frame(asked).ok_or_else(|| {
        ApiError::NotFound(format!(
            "job {id} has frames {first} to {last}, not {asked}"
        ))
    })?;
    Ok((job, frame))
}

async fn film_hash(app: &App, job: &JobRow, frame: u32) -> Result<Option<ContentHash>, ApiError> {
    let row = app.store.frame(job.id, frame).await?;
    Ok(row.and_then(|row| row.film_hash))
}

fn post_settings(post: &scene::Post, params: &PngQuery) -> PostSettings {
    let bloom = post.bloom.as_ref().filter(|_| params.bloom != Some(false));
    PostSettings {
        exposure_ev: params.exposure_ev.unwrap_or(post.exposure_ev),
        bloom: bloom.map(|bloom| Bloom {
            threshold: bloom.threshold,
            strength: bloom.strength,
            radius: bloom.radius,
            passes: bloom.passes,
        }),
        view: match params.view.unwrap_or(post.view) {
            scene::View::Standard => View::Standard,
            scene::View::Agx => View::Agx,
        },
    }
}

/// The rules that could end the picture before all of its samples.
fn stop_text(stop: &Stop) -> String {
    let error = stop.error.map(|error| format!("adaptive, relMSE {error}"));
    let seconds = stop.seconds.map(|seconds| format!("time, {seconds} s"));
    let rules: Vec<String> = error.into_iter().chain(seconds).collect();
    if rules.is_empty() {
        "samples".to_owned()
    } else {
        rules.join("; ")
    }
}

fn mean_samples(counts: &[u32]) -> f32 {
    let sum: u64 = counts.iter().map(|&count| u64::from(count)).sum();
    (sum as f64 / counts.len().max(1) as f64) as f32
}

/// A finished film's tag is a function of the film, and so are the bytes; before,
/// it is one of the revision, and the bytes may be a little newer.
fn etag(job: &JobRow, frame: u32, film: Option<ContentHash>, form: &str) -> Tag {
    let version = env!("CARGO_PKG_VERSION");
    match film {
        Some(hash) => Tag::strong(&format!(
            "{version} {form} {} {hash} {}",
            job.id, job.core_us
        )),
        None => Tag::weak(
            format!("{version} {form} {} {frame} revision {}", job.id, job.rev).as_bytes(),
        ),
    }
}

fn image(
    (method, headers): (&Method, &HeaderMap),
    media_type: &'static str,
    tag: &Tag,
    bytes: Vec<u8>,
) -> Result<Response, ApiError> {
    let fields = [
        (header::CONTENT_TYPE, media_type),
        // Ask each time: a picture of a running job changes.
        (header::CACHE_CONTROL, "no-cache"),
    ];
    bytes_answer(method, headers, tag, bytes, &fields)
}
