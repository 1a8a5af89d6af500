//! Every request is named, counted, timed and logged.

use super::request_id::{RequestIds, X_REQUEST_ID, header};
use crate::app::App;
use crate::metrics::{Answered, Route};
use axum::extract::{MatchedPath, Request, State};
use axum::middleware::Next;
use axum::response::Response;
use std::sync::Arc;
use std::time::Instant;
use tracing::Instrument;

/// What it takes.
#[derive(Clone, Debug)]
pub(super) struct Watched {
    app: Arc<App>,
    ids: Arc<RequestIds>,
}

impl Watched {
    /// For this coordinator.
    pub(super) fn new(app: &Arc<App>) -> Self {
        let (app, ids) = (Arc::clone(app), Arc::new(RequestIds::new()));
        Self { app, ids }
    }
}

/// Name a request (`X-Request-Id`, the client's own if it is a sane one), and note how it
/// ends. The log names the template of its path, not the path: what a client sends is not
/// for the log.
pub(super) async fn watched(
    State(watched): State<Watched>,
    request: Request,
    next: Next,
) -> Response {
    let id = watched.ids.of(request.headers());
    let template = request.extensions().get::<MatchedPath>();
    let route = Route::new(request.method(), template.map(MatchedPath::as_str));
    let span = tracing::info_span!("request", id);
    let mut watch = Watch::begin(watched.app, route);
    let answer = async {
        let answer = next.run(request).await;
        watch.answered = Answered::With(answer.status());
        // Within the span.
        drop(watch);
        answer
    };
    let mut response = answer.instrument(span).await;
    if let Some(value) = header(&id) {
        response.headers_mut().insert(X_REQUEST_ID, value);
    }
    response
}

/// A request under way. Dropped before its answer, its client has left.
struct Watch {
    app: Arc<App>,
    route: Route,
    began: Instant,
    answered: Answered,
}

impl Watch {
    fn begin(app: Arc<App>, route: Route) -> Self {
        app.metrics.requests.in_flight.inc();
        Self {
            app,
            route,
            began: Instant::now(),
            answered: Answered::Left,
        }
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        let requests = &self.app.metrics.requests;
        requests.in_flight.dec();
        let took = self.began.elapsed();
        requests.ended(&self.route, self.answered, took);
        let status = match self.answered {
            Answered::With(status) => status.as_u16(),
            Answered::Left => 0,
        };
        let (method, route) = (self.route.method(), self.route.template());
        let ms = took.as_secs_f64() * 1e3;
        tracing::debug!(method, route, status, ms, "answered");
    }
}
