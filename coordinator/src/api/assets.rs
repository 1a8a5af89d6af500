//! Assets by the hash of their content.

use super::conditional::{Tag, asked_range, describe, unchanged};
use super::extract::{JsonBody, Segment, check_length};
use super::openapi::{Fails, Octets};
use super::pace::Paced;
use super::problem::ApiError;
use crate::app::{App, now_ms};
use crate::objects::{Objects, Upload};
use axum::Json;
use axum::body::Body;
use axum::extract::State;
use axum::http::{HeaderMap, Method, StatusCode, header};
use axum::response::{IntoResponse, Response};
use shearwater_shared::api::{MissingRequest, MissingResponse};
use shearwater_shared::hash::ContentHash;
use shearwater_shared::limits::{ASSET_BYTES_MAX, ASSETS_MAX};
use shearwater_shared::routes;
use std::sync::Arc;

/// Which of some assets are not stored; at most 10,001 at once.
#[utoipa::path(
    post,
    path = routes::ASSETS_MISSING,
    operation_id = "missing_assets",
    tag = "assets",
    request_body = MissingRequest,
    responses(
        (status = 200, description = "Those to be uploaded", body = MissingResponse),
        Fails<400>, Fails<408>, Fails<413>, Fails<415>, Fails<422>
    )
)]
pub(crate) async fn missing(
    State(app): State<Arc<App>>,
    JsonBody(request): JsonBody<MissingRequest>,
) -> Result<Json<MissingResponse>, ApiError> {
    // Scene and files of the largest manifest.
    if request.hashes.len() > ASSETS_MAX + 1 {
        let most = ASSETS_MAX + 1;
        return Err(ApiError::Invalid(format!("hashes: at most {most}")));
    }
    let mut missing = Vec::new();
    for hash in request.hashes {
        if is_stored(&app, &hash).await? {
            // It must not go before the job that it is wanted for.
            app.store.use_asset(&hash, now_ms()).await?;
        } else {
            missing.push(hash);
        }
    }
    Ok(Json(MissingResponse { missing }))
}

/// Whether an asset is known and its object is there in its whole length.
async fn is_stored(app: &App, hash: &ContentHash) -> Result<bool, ApiError> {
    let Some(size) = app.store.asset_size(hash).await? else {
        return Ok(false);
    };
    let found = app.objects.size(&Objects::asset_name(hash)).await?;
    Ok(found == Some(size))
}

/// The content of an asset; `HEAD` gives its length alone. It never changes.
#[utoipa::path(
    get,
    path = routes::ASSET,
    operation_id = "get_asset",
    tag = "assets",
    params(
        ("hash" = ContentHash, Path, description = "blake3 of the content"),
        ("If-None-Match" = Option<String>, Header, description = "an `ETag`"),
        ("Range" = Option<String>, Header, description = "`bytes=` and one range"),
        ("If-Range" = Option<String>, Header, description = "an `ETag`")
    ),
    responses(
        (status = 200, description = "The content", content_type = "application/octet-stream", body = Octets,
            headers(("ETag" = String))),
        (status = 206, description = "The range of it", content_type = "application/octet-stream", body = Octets,
            headers(("Content-Range" = String))),
        (status = 304, description = "The client has it"),
        Fails<400>, Fails<404>, Fails<416>
    )
)]
pub(crate) async fn download(
    State(app): State<Arc<App>>,
    Segment(hash): Segment,
    method: Method,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let hash = parse_hash(&hash)?;
    let size = app.store.asset_size(&hash).await?;
    let size = size.ok_or_else(|| ApiError::NotFound(format!("asset {hash} is not stored")))?;
    let lost = || {
        tracing::error!(%hash, "a stored asset is lost or cut short");
        ApiError::NotFound(format!("asset {hash} is lost; upload it again"))
    };
    let tag = Tag::of_hash(&hash);
    if tag.is_known(&headers) {
        return Ok(unchanged(&tag));
    }
    let range = asked_range(&method, &headers, &tag, size)?;
    let name = Objects::asset_name(&hash);
    let object = match app.objects.open_range(&name, range.clone()).await {
        Ok(object) if object.meta.size == size => object,
        Ok(_) => return Err(lost()),
        Err(error) if error.is_missing() => return Err(lost()),
        Err(error) => return Err(error.into()),
    };
    let fields = [
        (header::CONTENT_TYPE, "application/octet-stream"),
        // A hash never changes its content.
        (header::CACHE_CONTROL, "public, max-age=31536000, immutable"),
    ];
    let mut response = Body::from_stream(object.into_stream()).into_response();
    describe(&mut response, &tag, range.as_ref(), size, &fields)?;
    Ok(response)
}

/// Store an asset: hashed while it streams in, visible only if the hash is the
/// one in the path. 201 when it is new, 200 when it was stored already.
#[utoipa::path(
    put,
    path = routes::ASSET,
    operation_id = "put_asset",
    tag = "assets",
    params(("hash" = ContentHash, Path, description = "blake3 of the content")),
    request_body(content = Octets, content_type = "application/octet-stream", description = "at most 2 GiB"),
    responses(
        (status = 200, description = "It was stored before"),
        (status = 201, description = "It is stored"),
        Fails<400>, Fails<408>, Fails<413>, Fails<422>
    )
)]
pub(crate) async fn upload(
    State(app): State<Arc<App>>,
    Segment(hash): Segment,
    headers: HeaderMap,
    body: Body,
) -> Result<StatusCode, ApiError> {
    let hash = parse_hash(&hash)?;
    check_length(&headers, ASSET_BYTES_MAX)?;
    let _permit = app.uploads.acquire().await.map_err(|_| ApiError::Busy)?;
    // What is stored already is written again all the same: who sends it mends
    // a copy that was damaged.
    let known = is_stored(&app, &hash).await?;
    let mut upload = app.objects.upload(&Objects::asset_name(&hash));
    let received = receive(body, &mut upload).await;
    let outcome = match received {
        Ok((found, size)) if found == hash => Ok(size),
        Ok((found, _)) => Err(ApiError::Invalid(format!(
            "the content's blake3 is {found}, the path says {hash}: damaged on the way, or \
             changed since it was hashed"
        ))),
        Err(error) => Err(error),
    };
    match outcome {
        Ok(size) => {
            upload.complete().await?;
            let noted = app.store.add_asset(&hash, size, now_ms()).await?;
            // A sweep may have removed the one of before under our hands.
            if !noted || !is_stored(&app, &hash).await? {
                return Err(ApiError::Busy);
            }
            Ok(if known {
                StatusCode::OK
            } else {
                StatusCode::CREATED
            })
        }
        Err(error) => {
            if let Err(abort) = upload.abort().await {
                tracing::warn!(error = %abort, "an aborted upload leaves a file behind");
            }
            Err(error)
        }
    }
}

/// Take a body into `upload`; its hash and length.
async fn receive(body: Body, upload: &mut Upload) -> Result<(ContentHash, u64), ApiError> {
    let mut pieces = Paced::new(body.into_data_stream());
    let mut hasher = blake3::Hasher::new();
    let mut size = 0u64;
    while let Some(chunk) = pieces.next().await? {
        size = size.saturating_add(chunk.len() as u64);
        if size > ASSET_BYTES_MAX {
            return Err(ApiError::TooLarge(ASSET_BYTES_MAX));
        }
        hasher.update(&chunk);
        upload.put(chunk).await?;
    }
    let hash = ContentHash::from_bytes(*hasher.finalize().as_bytes());
    Ok((hash, size))
}

fn parse_hash(text: &str) -> Result<ContentHash, ApiError> {
    text.parse()
        .map_err(|e| ApiError::BadRequest(format!("path: {e}")))
}
