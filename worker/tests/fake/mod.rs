//! A coordinator that does what a test tells it, on a real socket.

use axum::Json;
use axum::Router;
use axum::body::{Body, Bytes};
use axum::extract::{Path, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use futures_util::StreamExt;
use shearwater_shared::api::{
    FailureReport, HeartbeatRequest, HeartbeatResponse, Lease, LeaseRequest, Problem,
    ReleaseRequest, ResultResponse,
};
use shearwater_shared::hash::ContentHash;
use shearwater_shared::job::{JobId, Manifest, RenderSettings};
use shearwater_shared::plan::Run;
use shearwater_shared::wire::{self, PartUpload};
use shearwater_shared::{limits, routes};
use shearwater_worker::{Config, Summary, WorkerError};
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex};
use std::time::Duration;
use tokio::sync::oneshot;
use tokio::task::JoinHandle;

/// Longest that anything in these tests may take.
const PATIENCE: Duration = Duration::from_secs(120);
/// Between what an asset brings and the break of its line.
const BEFORE_BREAK: Duration = Duration::from_millis(100);

/// What the fake does, and what it has seen.
#[derive(Default)]
pub(crate) struct Script {
    pub(crate) leases: VecDeque<Lease>,
    pub(crate) assets: BTreeMap<ContentHash, Vec<u8>>,
    /// Assets delivered damaged this many times first.
    pub(crate) damaged_first: u32,
    /// Break the line after so many bytes of the next assets.
    pub(crate) breaks: VecDeque<usize>,
    /// First bytes that were asked for of each asset request.
    pub(crate) asked_from: Vec<usize>,
    /// How long a lease request takes, in milliseconds.
    pub(crate) lease_ms: u64,
    /// Parts that had come when each lease was asked for.
    pub(crate) parts_at_request: Vec<usize>,
    /// Answer this to the next results instead of counting them.
    pub(crate) result_errors: VecDeque<u16>,
    /// Refuse lease requests.
    pub(crate) refuse: bool,
    /// Say that the worker is in quarantine, this many times.
    pub(crate) quarantine: u32,
    /// Drop these leases at the next heartbeat.
    pub(crate) drop: Vec<i64>,
    pub(crate) lease_requests: Vec<LeaseRequest>,
    pub(crate) parts: Vec<PartUpload>,
    pub(crate) tries: u32,
    pub(crate) heartbeats: Vec<HeartbeatRequest>,
    pub(crate) failures: Vec<FailureReport>,
    pub(crate) released: Vec<i64>,
}

/// A fake coordinator and a worker that works for it.
pub(crate) struct Fake {
    pub(crate) script: Shared,
    url: String,
}

type Shared = Arc<Mutex<Script>>;

/// A worker under way.
pub(crate) struct Working {
    stop: oneshot::Sender<()>,
    worker: JoinHandle<Result<Summary, WorkerError>>,
}

impl Working {
    /// Tell it to stop and wait for it.
    pub(crate) async fn stop(self) -> Result<Summary, WorkerError> {
        let _ = self.stop.send(());
        ended(self.worker).await
    }

    /// Wait for it to end by itself.
    pub(crate) async fn end(self) -> Result<Summary, WorkerError> {
        let ended = ended(self.worker).await;
        drop(self.stop);
        ended
    }
}

async fn ended(worker: JoinHandle<Result<Summary, WorkerError>>) -> Result<Summary, WorkerError> {
    tokio::time::timeout(PATIENCE, worker)
        .await
        .expect("the worker ends")
        .expect("the worker does not panic")
}

impl Fake {
    pub(crate) async fn start(script: Script) -> Self {
        let listener = tokio::net::TcpListener::bind("127.0.0.1:0")
            .await
            .expect("port");
        Self::start_on(listener, script)
    }

    pub(crate) fn start_on(listener: tokio::net::TcpListener, script: Script) -> Self {
        let script = Arc::new(Mutex::new(script));
        let app = Router::new()
            .route(routes::WORKER_LEASES, post(lease))
            .route(routes::WORKER_RESULTS, post(result))
            .route(routes::WORKER_HEARTBEAT, post(heartbeat))
            .route(routes::WORKER_FAILURES, post(failure))
            .route(routes::WORKER_RELEASE, post(release))
            .route(routes::ASSET, get(asset))
            .layer(axum::extract::DefaultBodyLimit::max(
                wire::MESSAGE_BYTES_MAX,
            ))
            .with_state(script.clone());
        let url = format!("http://{}", listener.local_addr().expect("address"));
        tokio::spawn(async move { axum::serve(listener, app).await });
        Self { script, url }
    }

    pub(crate) fn work(&self, threads: usize) -> Working {
        let mut config = Config::new(&self.url, "test");
        config.threads = threads;
        Self::work_with(config)
    }

    pub(crate) fn url(&self) -> &str {
        &self.url
    }

    pub(crate) fn work_with(config: Config) -> Working {
        let (stop, stopped) = oneshot::channel::<()>();
        let worker = tokio::spawn(shearwater_worker::run(config, async {
            let _ = stopped.await;
        }));
        Working { stop, worker }
    }

    /// Wait until the script is in some state.
    pub(crate) async fn until(&self, what: &str, reached: impl Fn(&Script) -> bool) {
        let started = std::time::Instant::now();
        while !reached(&self.script.lock().expect("script")) {
            assert!(started.elapsed() < PATIENCE, "never: {what}");
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
    }
}

/// A lease of `runs` over `scene`, uploaded to the script.
pub(crate) fn lease_of(script: &mut Script, id: i64, scene: &str, samples: u32, runs: Vec<Run>) {
    let hash = ContentHash::of(scene.as_bytes());
    script.assets.insert(hash, scene.as_bytes().to_vec());
    script.leases.push_back(Lease {
        id,
        job: JobId(1),
        manifest: Manifest {
            scene: hash,
            files: BTreeMap::new(),
        },
        settings: RenderSettings {
            width: 128,
            height: 64,
            samples,
            seed: 0,
            frames: 1,
            first_frame: 0,
            stop: shearwater_shared::stop::Stop::NONE,
        },
        runs,
        heartbeat_ms: 100,
    });
}

fn problem(status: StatusCode, name: &str) -> Response {
    let problem = Problem {
        kind: format!("urn:shearwater:problem:{name}"),
        title: name.to_owned(),
        status: status.as_u16(),
        detail: "because the test says so".to_owned(),
    };
    let kind = [(header::CONTENT_TYPE, "application/problem+json")];
    (status, kind, Json(problem)).into_response()
}

async fn lease(State(script): State<Shared>, Json(request): Json<LeaseRequest>) -> Response {
    let (lease, lease_ms) = {
        let mut script = script.lock().expect("script");
        assert!(request.wait_ms <= limits::LEASE_WAIT_MS_MAX);
        script.lease_requests.push(request);
        let parts = script.parts.len();
        script.parts_at_request.push(parts);
        if script.refuse {
            return problem(StatusCode::CONFLICT, "build");
        }
        if script.quarantine > 0 {
            script.quarantine -= 1;
            return problem(StatusCode::FORBIDDEN, "quarantined");
        }
        (script.leases.pop_front(), script.lease_ms)
    };
    tokio::time::sleep(Duration::from_millis(lease_ms)).await;
    if let Some(lease) = lease {
        return Json(lease).into_response();
    }
    tokio::time::sleep(Duration::from_millis(50)).await;
    StatusCode::NO_CONTENT.into_response()
}

async fn result(State(script): State<Shared>, body: Bytes) -> Response {
    let mut script = script.lock().expect("script");
    script.tries += 1;
    if let Some(status) = script.result_errors.pop_front() {
        let name = if status == 410 {
            "job-ended"
        } else {
            "scripted"
        };
        return problem(StatusCode::from_u16(status).expect("status"), name);
    }
    let part = wire::decode_part(&body).expect("a part");
    let duplicate = script.parts.iter().any(|other| other.run == part.run);
    script.parts.push(part);
    Json(ResultResponse { duplicate }).into_response()
}

async fn heartbeat(
    State(script): State<Shared>,
    Json(request): Json<HeartbeatRequest>,
) -> Json<HeartbeatResponse> {
    let mut script = script.lock().expect("script");
    script.heartbeats.push(request);
    let drop = std::mem::take(&mut script.drop);
    Json(HeartbeatResponse { drop })
}

async fn failure(State(script): State<Shared>, Json(report): Json<FailureReport>) -> StatusCode {
    script.lock().expect("script").failures.push(report);
    StatusCode::NO_CONTENT
}

async fn release(State(script): State<Shared>, Json(request): Json<ReleaseRequest>) -> StatusCode {
    let mut script = script.lock().expect("script");
    script.released.extend(request.leases);
    StatusCode::NO_CONTENT
}

async fn asset(
    State(script): State<Shared>,
    Path(hash): Path<String>,
    headers: header::HeaderMap,
) -> Response {
    let mut script = script.lock().expect("script");
    let hash: ContentHash = hash.parse().expect("a hash");
    let Some(mut bytes) = script.assets.get(&hash).cloned() else {
        return problem(StatusCode::NOT_FOUND, "no-asset");
    };
    if script.damaged_first > 0 {
        script.damaged_first -= 1;
        bytes[0] ^= 1;
    }
    let range = headers.get(header::RANGE);
    let from = range.map_or(0, |range| {
        let text = range.to_str().expect("text");
        let from = text
            .strip_prefix("bytes=")
            .and_then(|t| t.strip_suffix('-'));
        from.expect("an open range").parse().expect("a number")
    });
    script.asked_from.push(from);
    let whole = bytes.len();
    let rest = bytes.split_off(from);
    let mut response = match script.breaks.pop_front() {
        None => rest.into_response(),
        Some(at) => {
            let piece = rest[..at].to_vec();
            let pieces = [Ok(piece), Err(std::io::Error::other("the line breaks"))];
            // What is sent together with the break may never leave this machine.
            let slowly = futures_util::stream::iter(pieces).then(async |piece| {
                tokio::time::sleep(BEFORE_BREAK).await;
                piece
            });
            Body::from_stream(slowly).into_response()
        }
    };
    if from > 0 {
        *response.status_mut() = StatusCode::PARTIAL_CONTENT;
        let range = format!("bytes {from}-{}/{whole}", whole - 1);
        let range = range.parse().expect("a header");
        response.headers_mut().insert(header::CONTENT_RANGE, range);
    }
    response
}
