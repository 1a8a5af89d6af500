//! `GET /metrics`: for Prometheus and whoever reads its formats.

use super::openapi::Fails;
use super::problem::ApiError;
use crate::app::App;
use crate::metrics::Form;
use axum::extract::State;
use axum::http::{HeaderMap, header};
use axum::response::{IntoResponse, Response};
use shearwater_shared::routes;
use std::sync::Arc;

const OPENMETRICS: &str = "application/openmetrics-text; version=1.0.0; charset=utf-8";
const PLAIN: &str = "text/plain; version=0.0.4; charset=utf-8";

/// What this coordinator has counted and measured, and how many jobs, units and workers
/// the farm has.
///
/// Prometheus' text format, or OpenMetrics for whoever says in `Accept` that it reads it.
/// Answers also while the database is away; `shearwater_farm_known` is 0 then.
#[utoipa::path(
    get,
    path = routes::METRICS,
    operation_id = "get_metrics",
    tag = "service",
    responses(
        (status = 200, description = "The numbers", content(
            (String = "text/plain"),
            (String = "application/openmetrics-text")
        )),
        Fails<500>
    )
)]
pub(crate) async fn metrics(
    State(app): State<Arc<App>>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    let (form, media_type) = if takes_openmetrics(&headers) {
        (Form::OpenMetrics, OPENMETRICS)
    } else {
        (Form::Plain, PLAIN)
    };
    let text = app.metrics.text(&app, form).await;
    let text = text.map_err(|e| ApiError::Internal(format!("metrics: {e}")))?;
    let fields = [
        (header::CONTENT_TYPE, media_type),
        (header::CACHE_CONTROL, "no-store"),
        (header::VARY, "accept"),
    ];
    Ok((fields, text).into_response())
}

/// Whether OpenMetrics is among what is accepted, and not refused by a weight of 0.
fn takes_openmetrics(headers: &HeaderMap) -> bool {
    let accepted = headers.get_all(header::ACCEPT).into_iter();
    let mut ranges = accepted
        .filter_map(|value| value.to_str().ok())
        .flat_map(|value| value.split(','));
    ranges.any(|range| {
        let mut parts = range.split(';').map(str::trim);
        let named = parts.next() == Some("application/openmetrics-text");
        named && !parts.any(|part| matches!(part, "q=0" | "q=0.0" | "q=0.00" | "q=0.000"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::HeaderValue;

    #[test]
    fn who_says_nothing_gets_the_older_format() {
        let takes = |accept: &'static str| {
            let value = HeaderValue::from_static(accept);
            takes_openmetrics(&HeaderMap::from_iter([(header::ACCEPT, value)]))
        };
        let prometheus = "application/openmetrics-text;version=1.0.0,\
                          text/plain;version=0.0.4;q=0.5,*/*;q=0.1";
        assert!(takes(prometheus));
        assert!(takes("text/plain, application/openmetrics-text"));
        for other in [
            "*/*",
            "text/plain;version=0.0.4",
            "application/openmetrics-text;q=0",
            "",
        ] {
            assert!(!takes(other), "{other}");
        }
        assert!(!takes_openmetrics(&HeaderMap::new()));
    }
}
