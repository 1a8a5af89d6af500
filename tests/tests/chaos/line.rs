//! The network between a worker and its coordinator, in any weather.

use super::lies::Liars;
use axum::Router;
use axum::body::Bytes;
use axum::extract::State;
use axum::http::{HeaderMap, Method, StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use shearwater_shared::{limits, routes};
use std::net::Ipv4Addr;
use std::sync::{Arc, Mutex};
use std::time::Duration;
use tokio::runtime::Runtime;

/// Longest that a result is held back so that a later one overtakes it.
const OVERTAKING_MAX: Duration = Duration::from_secs(2);
/// Longer than any lease request may wait.
const ANSWER_MAX: Duration = Duration::from_secs(40);

/// How requests fare from now on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Weather {
    /// They arrive.
    Clear,
    /// Nothing arrives, and nothing is answered.
    Parted,
    /// Every message takes this long, both ways.
    Slow { ms: u64 },
    /// Results arrive twice, at once.
    Twice,
    /// Every other result is overtaken by the next one.
    Shuffled,
    /// Results arrive, their acknowledgements do not.
    Deaf,
}

/// What happens to the next result, once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Damage {
    /// Its end is missing.
    Truncated,
    /// One bit is another; which one follows from the number.
    Flipped(usize),
}

struct Conditions {
    weather: Weather,
    damage: Option<Damage>,
    lying: bool,
    results: usize,
    delivered: usize,
}

#[derive(Clone)]
struct Shared {
    coordinator: String,
    http: reqwest::Client,
    liars: Liars,
    now: Arc<Mutex<Conditions>>,
}

/// A line, and the threads that carry it.
pub(crate) struct Line {
    pub(crate) url: String,
    now: Arc<Mutex<Conditions>>,
    _runtime: Runtime,
}

impl Line {
    /// Lead to a coordinator, from an address of this machine.
    pub(crate) fn to(coordinator: &str, from: Ipv4Addr, liars: &Liars) -> Self {
        // Set already, if this is not the first line.
        let _ = rustls::crypto::ring::default_provider().install_default();
        let runtime = Runtime::new().expect("runtime");
        let http = reqwest::Client::builder()
            .no_proxy()
            .timeout(ANSWER_MAX)
            .build();
        let now = Arc::new(Mutex::new(Conditions {
            weather: Weather::Clear,
            damage: None,
            lying: false,
            results: 0,
            delivered: 0,
        }));
        let shared = Shared {
            coordinator: coordinator.to_owned(),
            http: http.expect("client"),
            liars: liars.clone(),
            now: Arc::clone(&now),
        };
        let limit = axum::extract::DefaultBodyLimit::max(limits::SUBMIT_BODY_BYTES_MAX);
        let app = Router::new()
            .fallback(carry)
            .layer(limit)
            .with_state(shared);
        let listener = runtime.block_on(tokio::net::TcpListener::bind((from, 0)));
        let listener = listener.expect("port");
        let url = format!("http://{}", listener.local_addr().expect("address"));
        runtime.spawn(async move { axum::serve(listener, app).await });
        Self {
            url,
            now,
            _runtime: runtime,
        }
    }

    /// Change the weather.
    pub(crate) fn weather(&self, weather: Weather) {
        self.now.lock().expect("conditions").weather = weather;
    }

    /// Let its worker compute wrongly, or rightly again.
    pub(crate) fn lie(&self, lying: bool) {
        self.now.lock().expect("conditions").lying = lying;
    }

    /// Damage the next result.
    pub(crate) fn damage(&self, damage: Damage) {
        self.now.lock().expect("conditions").damage = Some(damage);
    }
}

impl Shared {
    fn now(&self) -> Weather {
        self.now.lock().expect("conditions").weather
    }

    async fn send(&self, method: Method, uri: &Uri, headers: &HeaderMap, body: Bytes) -> Response {
        let mut request = self
            .http
            .request(method, format!("{}{uri}", self.coordinator));
        for name in [
            header::CONTENT_TYPE,
            header::AUTHORIZATION,
            header::RANGE,
            header::ACCEPT,
        ] {
            if let Some(value) = headers.get(&name) {
                request = request.header(name, value);
            }
        }
        let Ok(answer) = request.body(body).send().await else {
            return StatusCode::BAD_GATEWAY.into_response();
        };
        let status = answer.status();
        let kept = [
            header::CONTENT_TYPE,
            header::ETAG,
            header::CONTENT_RANGE,
            header::RETRY_AFTER,
        ];
        let kept: HeaderMap = kept
            .into_iter()
            .filter_map(|name| Some((name.clone(), answer.headers().get(&name)?.clone())))
            .collect();
        match answer.bytes().await {
            Ok(body) => (status, kept, body).into_response(),
            Err(_) => StatusCode::BAD_GATEWAY.into_response(),
        }
    }

    // What becomes of a result on its way, and its number.
    fn on_its_way(&self, body: Bytes) -> (Bytes, usize) {
        let mut now = self.now.lock().expect("conditions");
        now.results += 1;
        let body = if now.lying {
            self.liars.lie(body)
        } else {
            body
        };
        let body = match now.damage.take() {
            None => body,
            Some(Damage::Truncated) => body.slice(..body.len() / 2),
            Some(Damage::Flipped(bit)) => {
                let mut bytes = body.to_vec();
                let length = bytes.len();
                bytes[bit / 8 % length] ^= 1 << (bit % 8);
                bytes.into()
            }
        };
        (body, now.results)
    }

    async fn overtaken(&self, number: usize) {
        let started = std::time::Instant::now();
        while started.elapsed() < OVERTAKING_MAX {
            if self.now.lock().expect("conditions").delivered > number {
                return;
            }
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
    }

    async fn result(&self, uri: &Uri, headers: &HeaderMap, body: Bytes) -> Response {
        let (body, number) = self.on_its_way(body);
        let weather = self.now();
        if weather == Weather::Shuffled && number % 2 == 1 {
            self.overtaken(number).await;
        }
        let send = || self.send(Method::POST, uri, headers, body.clone());
        let answer = if weather == Weather::Twice {
            let (one, _) = tokio::join!(send(), send());
            one
        } else {
            send().await
        };
        let mut now = self.now.lock().expect("conditions");
        now.delivered = now.delivered.max(number);
        if now.weather == Weather::Deaf {
            return StatusCode::BAD_GATEWAY.into_response();
        }
        answer
    }
}

async fn carry(
    State(shared): State<Shared>,
    method: Method,
    uri: Uri,
    headers: HeaderMap,
    body: Bytes,
) -> Response {
    while shared.now() == Weather::Parted {
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    let slow = || async {
        if let Weather::Slow { ms } = shared.now() {
            tokio::time::sleep(Duration::from_millis(ms)).await;
        }
    };
    slow().await;
    let answer = if uri.path() == routes::WORKER_RESULTS {
        shared.result(&uri, &headers, body).await
    } else {
        shared.send(method, &uri, &headers, body).await
    };
    slow().await;
    // What was asked before the parting is not answered after it began.
    if shared.now() == Weather::Parted {
        return StatusCode::BAD_GATEWAY.into_response();
    }
    answer
}
