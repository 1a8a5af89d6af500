//! Workers seen lately.

use super::problem::ApiError;
use crate::app::{App, now_ms};
use axum::Json;
use axum::extract::State;
use shearwater_shared::api::{WorkerId, WorkerView};
use std::sync::Arc;

/// Silence after which a worker is no longer shown.
const SHOWN_MS: i64 = 5 * 60 * 1000;

/// Every worker heard of within [`SHOWN_MS`].
pub(crate) async fn list(State(app): State<Arc<App>>) -> Result<Json<Vec<WorkerView>>, ApiError> {
    let now_ms = now_ms();
    let held = app.store.runs_held().await?;
    let workers = app.store.workers(now_ms - SHOWN_MS).await?;
    let views = workers.into_iter().map(|worker| WorkerView {
        threads: worker.threads,
        samples_per_s: worker.milli_samples_per_s as f64 / 1000.0,
        silent_ms: (now_ms - worker.seen_ms).max(0),
        runs_held: held.get(&worker.instance).copied().unwrap_or(0),
        worker: WorkerId {
            name: worker.name,
            instance: worker.instance,
        },
    });
    Ok(Json(views.collect()))
}
