//! The API as a page for people. Everything it needs is in the binary: it works
//! without a network, and its policy forbids it any.

use super::extract::Segment;
use super::problem::ApiError;
use axum::Extension;
use axum::http::{HeaderName, StatusCode, header};
use axum::response::{IntoResponse, Response};
use shearwater_shared::routes;
use std::sync::Arc;
use utoipa_swagger_ui::Config;

/// Only this server's own files; the page sets styles from its script.
const POLICY: &str = "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; \
                      frame-ancestors 'none'";

/// The folder of the page's files, below [`routes::DOCS`].
pub(super) const FILES: &str = "/docs/{*file}";
/// The page itself, with the slash that its relative links need.
pub(super) const INDEX: &str = "/docs/";

/// What the page shows.
pub(super) fn config() -> Arc<Config<'static>> {
    Arc::new(Config::from(routes::OPENAPI))
}

/// This API as a page for people, without any need of a network.
#[utoipa::path(
    get,
    path = routes::DOCS,
    operation_id = "get_docs",
    tag = "service",
    responses((status = 308, description = "To `/docs/`, the page itself"))
)]
pub(super) async fn page() -> Response {
    (StatusCode::PERMANENT_REDIRECT, [(header::LOCATION, INDEX)]).into_response()
}

/// The page.
pub(super) async fn index(Extension(config): Extension<Arc<Config<'static>>>) -> Response {
    serve("index.html", config).into_response()
}

/// A file of the page.
pub(super) async fn file(
    Segment(name): Segment,
    Extension(config): Extension<Arc<Config<'static>>>,
) -> Response {
    serve(&name, config).into_response()
}

fn serve(name: &str, config: Arc<Config<'static>>) -> Result<Response, ApiError> {
    let file = utoipa_swagger_ui::serve(name, config);
    let file = file.map_err(|e| ApiError::Internal(e.to_string()))?;
    let file = file.ok_or(ApiError::NoRoute)?;
    let fields = [
        (header::CONTENT_TYPE, file.content_type),
        (header::CONTENT_SECURITY_POLICY, POLICY.to_owned()),
        (header::CACHE_CONTROL, "no-cache".to_owned()),
        (
            HeaderName::from_static("x-content-type-options"),
            "nosniff".to_owned(),
        ),
    ];
    let mut response = (fields, file.bytes.into_owned()).into_response();
    if file.gzpipped {
        let gzip = header::HeaderValue::from_static("gzip");
        response
            .headers_mut()
            .insert(header::CONTENT_ENCODING, gzip);
    }
    Ok(response)
}
