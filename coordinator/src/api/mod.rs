//! The REST API and the worker protocol.
//!
//! Every answer that is no success is `application/problem+json`, also those
//! for unknown paths and methods; [`problem`] alone maps errors to HTTP.

// The macros that make the document write full paths.
#![allow(unused_qualifications)]

mod assets;
mod conditional;
mod docs;
mod errors;
mod events;
mod extract;
mod frames;
mod health;
mod idempotency;
mod images;
mod jobs;
mod kinds;
mod leases;
mod log;
mod metrics;
mod openapi;
mod pace;
mod page;
mod problem;
mod request_id;
mod results;
mod samples;
mod settings;
mod steer;
mod submit;
mod view;
mod watched;
mod workers;

pub(crate) use problem::ApiError;
pub(crate) use view::job_view;

use crate::access::guard;
use crate::app::App;
use axum::extract::{Request, State};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::Response;
use axum::routing::get;
use axum::{Extension, Router};
use openapi::Document;
use std::sync::Arc;
use tower_http::catch_panic::CatchPanicLayer;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use watched::{Watched, watched};

/// Every route, and the document that describes them all.
///
/// # Errors
/// The document cannot be written: a fault of the program.
pub(crate) fn router(app: Arc<App>) -> Result<Router, serde_json::Error> {
    let (router, api) = described().split_for_parts();
    Ok(router
        // Files of the page, which no client asks for by name.
        .route(docs::INDEX, get(docs::index))
        .route(docs::FILES, get(docs::file))
        .fallback(|| async { ApiError::NoRoute })
        .method_not_allowed_fallback(|| async { ApiError::Method })
        .layer(Extension(Document::new(&api)?))
        .layer(Extension(docs::config()))
        .layer(from_fn_with_state(Arc::clone(&app), guard))
        .layer(CatchPanicLayer::custom(problem::panicked))
        .layer(from_fn_with_state(Watched::new(&app), watched))
        .layer(from_fn_with_state(Arc::clone(&app), suspect_stores))
        .with_state(app))
}

/// The routes with their descriptions.
fn described() -> OpenApiRouter<Arc<App>> {
    OpenApiRouter::with_openapi(openapi::base())
        .routes(routes!(jobs::list, submit::submit))
        .routes(routes!(jobs::get_job, steer::change, jobs::delete))
        .routes(routes!(jobs::cancel))
        .routes(routes!(steer::pause))
        .routes(routes!(steer::resume))
        .routes(routes!(steer::retry))
        .routes(routes!(log::list))
        .routes(routes!(samples::add))
        .routes(routes!(events::events))
        .routes(routes!(frames::list))
        .routes(routes!(errors::list))
        .routes(routes!(images::png))
        .routes(routes!(images::exr))
        .routes(routes!(assets::missing))
        .routes(routes!(assets::download, assets::upload))
        .routes(routes!(workers::list))
        .routes(routes!(leases::lease))
        .routes(routes!(results::result))
        .routes(routes!(leases::heartbeat))
        .routes(routes!(leases::failure))
        .routes(routes!(leases::release))
        .routes(routes!(health::healthz))
        .routes(routes!(health::readyz))
        .routes(routes!(metrics::metrics))
        .routes(routes!(openapi::document))
        .routes(routes!(docs::page))
}

/// An answer that a store's failure may have caused is a reason to try the stores.
async fn suspect_stores(State(app): State<Arc<App>>, request: Request, next: Next) -> Response {
    let response = next.run(request).await;
    if response.status().is_server_error() {
        app.troubles.suspect();
    }
    response
}
