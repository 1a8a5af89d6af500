//! Is the process alive, can it serve?

use super::problem::ApiError;
use crate::app::App;
use axum::Json;
use axum::extract::State;
use serde_json::{Value, json};
use std::sync::Arc;
use std::time::Duration;

/// Time for store and objects to answer before this coordinator counts as not
/// ready: below the usual probe's second.
const READY_TIMEOUT: Duration = Duration::from_millis(900);

/// The process answers.
pub(crate) async fn healthz() -> Json<Value> {
    Json(json!({ "status": "ok", "version": env!("CARGO_PKG_VERSION") }))
}

/// The database answers and objects can be written.
pub(crate) async fn readyz(State(app): State<Arc<App>>) -> Result<Json<Value>, ApiError> {
    let probe = async {
        app.store.ping().await?;
        let name = app.objects.probe_name();
        app.objects.put(&name, b"probe".to_vec()).await?;
        app.objects.delete(&name).await?;
        Ok::<(), ApiError>(())
    };
    match tokio::time::timeout(READY_TIMEOUT, probe).await {
        Ok(Ok(())) => Ok(Json(json!({ "status": "ready" }))),
        Ok(Err(error)) => {
            tracing::warn!(%error, "not ready");
            Err(ApiError::Busy)
        }
        Err(_) => Err(ApiError::Busy),
    }
}
