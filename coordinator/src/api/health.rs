//! Is the process alive, can it serve?

use super::problem::ApiError;
use crate::app::{App, now_ms};
use axum::Json;
use axum::extract::State;
use shearwater_shared::api::HealthView;
use shearwater_shared::routes;
use std::sync::Arc;
use std::time::Duration;

/// Time for the database to answer before this coordinator counts as not ready:
/// below the usual probe's second.
const READY_TIMEOUT: Duration = Duration::from_millis(900);

/// The process answers.
#[utoipa::path(
    get,
    path = routes::HEALTHZ,
    operation_id = "healthz",
    tag = "service",
    responses((status = 200, description = "It does", body = HealthView))
)]
pub(crate) async fn healthz() -> Json<HealthView> {
    view("ok")
}

fn view(status: &str) -> Json<HealthView> {
    Json(HealthView {
        status: status.to_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
    })
}

/// Database and objects can be written, the tables are those of this version, and the
/// process is not about to end; if not, what fails, for how long and why.
#[utoipa::path(
    get,
    path = routes::READYZ,
    operation_id = "readyz",
    tag = "service",
    responses((status = 200, description = "It can serve", body = HealthView))
)]
pub(crate) async fn readyz(State(app): State<Arc<App>>) -> Result<Json<HealthView>, ApiError> {
    if *app.stopping.borrow() {
        return Err(ApiError::NotReady("this coordinator is ending".into()));
    }
    if let Some(why) = app.troubles.text(now_ms()) {
        return Err(ApiError::NotReady(why));
    }
    // Nothing is known to be wrong: ask once more, but do not keep a probe waiting.
    match tokio::time::timeout(READY_TIMEOUT, app.store.tables_fit()).await {
        Ok(Ok(true)) => Ok(view("ready")),
        Ok(Ok(false)) => Err(ApiError::NotReady(
            "the database's tables are of another version; run the version that migrated it".into(),
        )),
        Ok(Err(_)) | Err(_) => {
            app.troubles.suspect();
            Err(ApiError::NotReady("the database does not answer".into()))
        }
    }
}
