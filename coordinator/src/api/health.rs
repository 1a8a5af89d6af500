//! Is the process alive, can it serve?

use super::problem::ApiError;
use crate::app::App;
use axum::Json;
use axum::extract::State;
use shearwater_shared::api::HealthView;
use shearwater_shared::routes;
use std::sync::Arc;
use std::time::Duration;

/// Time for database and objects to answer, each: both are below the usual
/// probe's second.
const PROBE_TIMEOUT: Duration = Duration::from_millis(450);

/// The process answers.
#[utoipa::path(
    get,
    path = routes::HEALTHZ,
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

/// The database answers with the tables of this version, objects can be written,
/// and the process is not about to end.
#[utoipa::path(
    get,
    path = routes::READYZ,
    tag = "service",
    responses((status = 200, description = "It can serve", body = HealthView))
)]
pub(crate) async fn readyz(State(app): State<Arc<App>>) -> Result<Json<HealthView>, ApiError> {
    if *app.stopping.borrow() {
        return Err(ApiError::NotReady("this coordinator is ending".into()));
    }
    within("the database", tables(&app)).await?;
    within("the object store", write_one(&app)).await?;
    Ok(view("ready"))
}

async fn tables(app: &App) -> Result<(), String> {
    let fits = app.store.tables_fit().await.map_err(|e| e.to_string())?;
    if fits {
        Ok(())
    } else {
        Err("its tables are of another version; run the version that migrated it".into())
    }
}

async fn write_one(app: &App) -> Result<(), String> {
    let name = app.objects.probe_name();
    let written = app.objects.put(&name, b"probe".to_vec()).await;
    written.map_err(|e| e.to_string())?;
    app.objects.delete(&name).await.map_err(|e| e.to_string())
}

/// The cause is for the log: it may name files.
async fn within(
    what: &str,
    probe: impl Future<Output = Result<(), String>>,
) -> Result<(), ApiError> {
    match tokio::time::timeout(PROBE_TIMEOUT, probe).await {
        Ok(Ok(())) => Ok(()),
        Ok(Err(error)) => {
            tracing::warn!(error, "{what} does not answer");
            Err(ApiError::NotReady(format!(
                "{what} fails; the coordinator's log says why"
            )))
        }
        Err(_) => Err(ApiError::NotReady(format!(
            "{what} does not answer in time"
        ))),
    }
}
