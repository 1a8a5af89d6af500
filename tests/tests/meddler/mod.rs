//! A proxy between worker and coordinator that holds back every other result
//! until a later one has overtaken it, and delivers each one twice.

use axum::Router;
use axum::body::Bytes;
use axum::extract::State;
use axum::http::{Method, StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use shearwater_shared::{limits, routes, wire};
use std::sync::{Arc, Mutex};
use std::time::Duration;
use tokio::runtime::Runtime;

/// Longest that a result is held back: several times what a run takes.
const OVERTAKING_MAX: Duration = Duration::from_secs(5);

/// What went through.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Seen {
    /// Different results.
    pub(crate) results: usize,
    /// Answers that said "counted already".
    pub(crate) duplicates: usize,
    /// Results that were overtaken by a later one.
    pub(crate) shuffled: usize,
}

#[derive(Default)]
struct Log {
    seen: Seen,
    bodies: Vec<Bytes>,
    last_delivered: usize,
}

#[derive(Clone)]
struct Shared {
    coordinator: String,
    http: reqwest::Client,
    log: Arc<Mutex<Log>>,
}

/// The proxy and the threads it runs on.
pub(crate) struct Meddler {
    url: String,
    shared: Shared,
    runtime: Runtime,
}

impl Meddler {
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
            log: Arc::default(),
        };
        let app = Router::new()
            .fallback(meddle)
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
            runtime,
        }
    }

    pub(crate) fn url(&self) -> &str {
        &self.url
    }

    pub(crate) fn seen(&self) -> Seen {
        self.shared.log.lock().expect("log").seen
    }

    /// Deliver every result once more, last first.
    pub(crate) fn send_all_again(&self) {
        let bodies = self.shared.log.lock().expect("log").bodies.clone();
        for body in bodies.into_iter().rev() {
            let answer = self.runtime.block_on(self.shared.result(body));
            let (status, text) = answer.expect("an answer");
            let late = status.is_success() && text.contains("true");
            assert!(late || status.is_client_error(), "{status}: {text}");
        }
    }

    /// Deliver a result with one bit changed: it must not be taken for equal.
    pub(crate) fn send_one_altered(&self) {
        let body = self.shared.log.lock().expect("log").bodies[0].clone();
        let mut part = wire::decode_part(&body).expect("a part");
        // One step of light more, in the sums and in their histogram: what arithmetic
        // that differs would give.
        part.sums.radiance[0][0] += 1;
        let bins = part.sums.brightness.bins.iter_mut();
        bins.max_by_key(|bin| bin.samples).expect("bins").light += 1;
        let body = wire::encode_part(&part).expect("a message").into();
        let answer = self.runtime.block_on(self.shared.result(body));
        let (status, text) = answer.expect("an answer");
        assert!(status.is_client_error(), "{status}: {text}");
    }
}

impl Shared {
    async fn result(&self, body: Bytes) -> reqwest::Result<(StatusCode, String)> {
        let url = format!("{}{}", self.coordinator, routes::WORKER_RESULTS);
        let request = self.http.post(url);
        let answer = request
            .header(header::CONTENT_TYPE, wire::CONTENT_TYPE)
            .body(body)
            .send()
            .await?;
        Ok((answer.status(), answer.text().await?))
    }

    async fn result_twice(&self, body: Bytes) -> reqwest::Result<(StatusCode, String)> {
        let number = {
            let mut log = self.log.lock().expect("log");
            log.bodies.push(body.clone());
            log.seen.results += 1;
            log.seen.results
        };
        if number % 2 == 1 {
            self.overtaken(number).await;
        }
        let (one, other) = tokio::join!(self.result(body.clone()), self.result(body));
        let (one, other) = (one?, other?);
        let mut log = self.log.lock().expect("log");
        log.seen.shuffled += usize::from(number < log.last_delivered);
        log.last_delivered = number.max(log.last_delivered);
        for (status, text) in [&one, &other] {
            if status.is_success() && text.contains("true") {
                log.seen.duplicates += 1;
            }
        }
        Ok(one)
    }

    /// Wait until a later result has been delivered; the last one of all waits
    /// in vain.
    async fn overtaken(&self, number: usize) {
        let started = std::time::Instant::now();
        while started.elapsed() < OVERTAKING_MAX {
            if self.log.lock().expect("log").last_delivered > number {
                return;
            }
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
    }

    async fn forward(
        &self,
        method: Method,
        uri: &Uri,
        kind: Option<&header::HeaderValue>,
        body: Bytes,
    ) -> reqwest::Result<(StatusCode, Bytes)> {
        let url = format!("{}{uri}", self.coordinator);
        let mut request = self.http.request(method, url).body(body);
        if let Some(kind) = kind {
            request = request.header(header::CONTENT_TYPE, kind);
        }
        let answer = request.send().await?;
        Ok((answer.status(), answer.bytes().await?))
    }
}

async fn meddle(
    State(shared): State<Shared>,
    method: Method,
    uri: Uri,
    headers: header::HeaderMap,
    body: Bytes,
) -> Response {
    if uri.path() == routes::WORKER_RESULTS {
        return match shared.result_twice(body).await {
            Ok(answer) => answer.into_response(),
            Err(_) => StatusCode::BAD_GATEWAY.into_response(),
        };
    }
    let kind = headers.get(header::CONTENT_TYPE);
    match shared.forward(method, &uri, kind, body).await {
        Ok(answer) => answer.into_response(),
        Err(_) => StatusCode::BAD_GATEWAY.into_response(),
    }
}
