//! Is the process alive, can it serve?

use super::problem::ApiError;
use crate::app::{App, now_ms};
use axum::Json;
use axum::extract::State;
use serde_json::{Value, json};
use std::sync::Arc;
use std::time::Duration;

/// Time for the database to answer before this coordinator counts as not ready:
/// below the usual probe's second.
const READY_TIMEOUT: Duration = Duration::from_millis(900);

/// The process answers.
pub(crate) async fn healthz() -> Json<Value> {
    Json(json!({ "status": "ok", "version": env!("CARGO_PKG_VERSION") }))
}

/// The database and the objects can be written; if not, why and for how long.
pub(crate) async fn readyz(State(app): State<Arc<App>>) -> Result<Json<Value>, ApiError> {
    let not_ready = |app: &App| app.troubles.text(now_ms()).map(ApiError::NotReady);
    if let Some(error) = not_ready(&app) {
        return Err(error);
    }
    // Nothing is known to be wrong: ask once more, but do not keep a probe waiting.
    match tokio::time::timeout(READY_TIMEOUT, app.store.ping()).await {
        Ok(Ok(())) => Ok(Json(json!({ "status": "ready" }))),
        Ok(Err(_)) | Err(_) => {
            app.troubles.suspect();
            Err(ApiError::NotReady("the database does not answer".into()))
        }
    }
}
