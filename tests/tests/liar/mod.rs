//! A proxy before a worker that changes a bit of every result and seals it again: to the
//! coordinator its worker computes wrongly.

use axum::Router;
use axum::body::Bytes;
use axum::extract::State;
use axum::http::{Method, StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use shearwater_shared::{limits, routes, wire};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use tokio::runtime::Runtime;

#[derive(Clone)]
struct Shared {
    coordinator: String,
    http: reqwest::Client,
    lies: Arc<AtomicUsize>,
}

/// The proxy and the threads it runs on.
pub(crate) struct Liar {
    url: String,
    shared: Shared,
    _runtime: Runtime,
}

impl Liar {
    /// Start it on a port of its own.
    pub(crate) fn start(coordinator: &str) -> Self {
        let runtime = Runtime::new().expect("runtime");
        // Only the first test of the process installs it.
        let _ = rustls::crypto::ring::default_provider().install_default();
        let http = reqwest::Client::builder().no_proxy().tls_certs_only([]);
        let http = http.build();
        let shared = Shared {
            coordinator: coordinator.to_owned(),
            http: http.expect("client"),
            lies: Arc::default(),
        };
        let app = Router::new()
            .fallback(forward)
            .layer(axum::extract::DefaultBodyLimit::max(
                limits::SUBMIT_BODY_BYTES_MAX,
            ))
            .with_state(shared.clone());
        let listener = runtime
            .block_on(tokio::net::TcpListener::bind("127.0.0.1:0"))
            .expect("port");
        let url = format!("http://{}", listener.local_addr().expect("address"));
        runtime.spawn(async move { axum::serve(listener, app).await });
        Self {
            url,
            shared,
            _runtime: runtime,
        }
    }

    pub(crate) fn url(&self) -> &str {
        &self.url
    }

    /// Results that were changed.
    pub(crate) fn lies(&self) -> usize {
        self.shared.lies.load(Ordering::Relaxed)
    }
}

/// The lowest bit of the light of one pixel, and of the histogram that must agree.
fn changed(body: &[u8]) -> Bytes {
    let mut part = wire::decode_part(body).expect("a part");
    part.sums.radiance[0][0] += 1;
    let bins = part.sums.brightness.bins.iter_mut();
    bins.max_by_key(|bin| bin.samples).expect("bins").light += 1;
    wire::encode_part(&part).expect("a message").into()
}

async fn forward(
    State(shared): State<Shared>,
    method: Method,
    uri: Uri,
    headers: header::HeaderMap,
    mut body: Bytes,
) -> Response {
    if uri.path() == routes::WORKER_RESULTS {
        body = changed(&body);
        shared.lies.fetch_add(1, Ordering::Relaxed);
    }
    let url = format!("{}{uri}", shared.coordinator);
    let mut request = shared.http.request(method, url).body(body);
    if let Some(kind) = headers.get(header::CONTENT_TYPE) {
        request = request.header(header::CONTENT_TYPE, kind);
    }
    let Ok(answer) = request.send().await else {
        return StatusCode::BAD_GATEWAY.into_response();
    };
    let (status, kind) = (
        answer.status(),
        answer.headers().get(header::CONTENT_TYPE).cloned(),
    );
    let mut response = (status, answer.bytes().await.unwrap_or_default()).into_response();
    if let Some(kind) = kind {
        response.headers_mut().insert(header::CONTENT_TYPE, kind);
    }
    response
}
