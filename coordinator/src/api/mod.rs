//! The REST API and the worker protocol.
//!
//! Every answer that is no success is `application/problem+json`, also those
//! for unknown paths and methods; [`problem`] alone maps errors to HTTP.

mod assets;
mod errors;
mod events;
mod extract;
mod frames;
mod health;
mod images;
mod jobs;
mod leases;
mod problem;
mod results;
mod samples;
mod settings;
mod submit;
mod view;
mod workers;

use crate::app::App;
use axum::Router;
use axum::extract::{Request, State};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::Response;
use axum::routing::{get, post};
use problem::ApiError;
use shearwater_shared::routes;
use std::sync::Arc;
use tower_http::catch_panic::CatchPanicLayer;

/// Every route.
pub(crate) fn router(app: Arc<App>) -> Router {
    Router::new()
        .route(routes::JOBS, get(jobs::list).post(submit::submit))
        .route(routes::JOB, get(jobs::get_job).delete(jobs::delete))
        .route(routes::JOB_CANCEL, post(jobs::cancel))
        .route(routes::JOB_SAMPLES, post(samples::add))
        .route(routes::JOB_EVENTS, get(events::events))
        .route(routes::JOB_FRAMES, get(frames::list))
        .route(routes::JOB_ERRORS, get(errors::list))
        .route(routes::JOB_PNG, get(images::png))
        .route(routes::JOB_EXR, get(images::exr))
        .route(routes::ASSETS_MISSING, post(assets::missing))
        .route(routes::ASSET, get(assets::download).put(assets::upload))
        .route(routes::WORKERS, get(workers::list))
        .route(routes::WORKER_LEASES, post(leases::lease))
        .route(routes::WORKER_RESULTS, post(results::result))
        .route(routes::WORKER_HEARTBEAT, post(leases::heartbeat))
        .route(routes::WORKER_FAILURES, post(leases::failure))
        .route(routes::WORKER_RELEASE, post(leases::release))
        .route(routes::HEALTHZ, get(health::healthz))
        .route(routes::READYZ, get(health::readyz))
        .fallback(|| async { ApiError::NoRoute })
        .method_not_allowed_fallback(|| async { ApiError::Method })
        .layer(CatchPanicLayer::custom(problem::panicked))
        .layer(from_fn_with_state(Arc::clone(&app), suspect_stores))
        .with_state(app)
}

/// An answer that a store's failure may have caused is a reason to try the stores.
async fn suspect_stores(State(app): State<Arc<App>>, request: Request, next: Next) -> Response {
    let response = next.run(request).await;
    if response.status().is_server_error() {
        app.troubles.suspect();
    }
    response
}
