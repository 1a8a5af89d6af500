//! `Idempotency-Key`: a request that is sent again, since its answer was lost, does
//! nothing twice.

use super::problem::ApiError;
use crate::app::App;
use crate::store::{IdempotencyKey, Repetition};
use axum::http::HeaderMap;
use serde::Serialize;
use shearwater_shared::hash::ContentHash;

/// The header's name.
pub(super) const HEADER: &str = "idempotency-key";
/// Longest key, in bytes; a UUID has 36.
const KEY_BYTES_MAX: usize = 200;

/// The key that came with a request, if any; `scope` keeps keys of different
/// requests apart.
pub(super) fn key(
    headers: &HeaderMap,
    scope: &str,
    request: &impl Serialize,
) -> Result<Option<IdempotencyKey>, ApiError> {
    let Some(key) = headers.get(HEADER) else {
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
    let key = if scope.is_empty() {
        key.to_owned()
    } else {
        // No header holds a line end.
        format!("{scope}\n{key}")
    };
    Ok(Some(IdempotencyKey {
        key,
        body: ContentHash::of(&body),
    }))
}

/// Whether this very request was carried out before.
pub(super) async fn was_done(app: &App, key: &IdempotencyKey) -> Result<bool, ApiError> {
    match app.store.repetition(key).await? {
        None => Ok(false),
        Some(Repetition::Same(_)) => Ok(true),
        Some(Repetition::OtherBody(job)) => Err(ApiError::KeyReused(job.0)),
    }
}
