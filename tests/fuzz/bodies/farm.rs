//! A coordinator in this process, with a little of everything that can be asked for.

use axum::Router;
use axum::body::{Body, to_bytes};
use axum::http::{Method, StatusCode};
use axum::response::Response;
use serde_json::{Value, json};
use shearwater_coordinator::access::Role;
use shearwater_coordinator::{Config, Coordinator, GivenToken};
use shearwater_shared::api::{JobView, Lease};
use shearwater_shared::film::TileSums;
use shearwater_shared::hash::ContentHash;
use shearwater_shared::plan::Plan;
use shearwater_shared::routes;
use shearwater_shared::wire::{self, PartUpload};
use std::time::Duration;
use tempfile::TempDir;
use tokio::runtime::Runtime;
use tower::ServiceExt;

/// The numeric build of its made-up workers.
pub(super) const BUILD: &str = "fuzz";
/// The scene of its jobs.
pub(super) const SCENE: &str = r#"{
  "version": 1, "name": "one tile", "image": { "width": 4, "height": 3 }, "job": { "samples": 4 },
  "camera": { "position_m": [0, 0, 5], "target_m": [0, 0, 0], "vertical_fov_deg": 40 },
  "sky": { "type": "constant", "radiance": [1, 1, 1] },
  "animation": { "fps": 24, "frames": 3 },
  "post": { "bloom": { "threshold": 1, "strength": 0.5, "radius": 0.1, "passes": 1 } }
}"#;
/// How long an answer may take. Long polls and streams are left before.
const ANSWER_TIMEOUT: Duration = Duration::from_millis(50);
/// Looks at a job that is about to be finished, 10 ms apart.
const LOOKS_MAX: u32 = 1_000;
/// Longest answer.
const ANSWER_BYTES_MAX: usize = 4 << 20;

/// A token of one letter: `a` is an admin's, `b` a client's, `c` a worker's.
pub(super) fn token(letter: &str) -> String {
    format!("sw_{}_{}", letter.repeat(8), letter.repeat(64))
}

/// A running coordinator; its requests need no socket.
pub(super) struct Farm {
    routes: Router,
    _coordinator: Coordinator,
    _folder: TempDir,
}

impl Farm {
    /// One that answers everybody, or one that demands tokens. Job 1 is finished,
    /// job 2 is leased in part, job 3 waits.
    pub(super) fn start(runtime: &Runtime, guarded: bool) -> Self {
        let folder = tempfile::tempdir().expect("folder");
        let listen = "127.0.0.1:0".parse().expect("address");
        let mut config = Config::new(folder.path().to_owned(), listen, BUILD.to_owned());
        config.audit_ppm = 0;
        if guarded {
            let roles = [("a", Role::Admin), ("b", Role::Client), ("c", Role::Worker)];
            config.tokens = roles
                .map(|(letter, role)| GivenToken {
                    role,
                    token: token(letter),
                })
                .to_vec();
        }
        runtime.block_on(async {
            let coordinator = Coordinator::start(config).await.expect("start");
            let farm = Self {
                routes: coordinator.router().expect("routes"),
                _coordinator: coordinator,
                _folder: folder,
            };
            farm.fill().await;
            farm
        })
    }

    async fn fill(&self) {
        let scene = ContentHash::of(SCENE.as_bytes()).to_string();
        let path = routes::fill(routes::ASSET, &scene);
        let put = self.ask(Method::PUT, &path, "application/octet-stream", SCENE.into());
        assert_eq!(put.await.0, StatusCode::CREATED);
        let body = json!({ "manifest": { "scene": scene, "files": {} } });
        let submit =
            async || assert_eq!(self.post(routes::JOBS, &body).await.0, StatusCode::CREATED);
        submit().await;
        while let Some(lease) = self.lease().await {
            self.deliver(&lease).await;
        }
        self.wait_for_job_1().await;
        submit().await;
        self.lease().await.expect("a run of job 2");
        submit().await;
    }

    async fn lease(&self) -> Option<Lease> {
        let worker = json!({ "name": "w", "instance": "w" });
        let ask = json!({ "worker": worker, "protocol": wire::PROTOCOL_VERSION, "build": BUILD,
            "threads": 1, "samples_per_s": 1.0, "wait_ms": 0 });
        let (status, lease) = self.post(routes::WORKER_LEASES, &ask).await;
        assert!(status.is_success(), "{lease}");
        serde_json::from_value(lease).ok()
    }

    async fn wait_for_job_1(&self) {
        let path = routes::fill(routes::JOB, "1");
        for _ in 0..LOOKS_MAX {
            let job = self.ask(Method::GET, &path, "", Vec::new()).await.1;
            let job: JobView = serde_json::from_value(job).expect("job");
            if job.done {
                return;
            }
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
        panic!("job 1 does not come to its end");
    }

    /// Black sums for all runs of a lease.
    async fn deliver(&self, lease: &Lease) {
        let plan = Plan::new(&lease.settings);
        for &run in &lease.runs {
            let samples = plan.sample_range(&run).expect("run");
            let pixels = plan.tile_rect(run.tile).expect("tile").pixels();
            let mut sums = TileSums::zero(pixels, &samples);
            for _ in 0..pixels * samples.len() * 2 {
                sums.brightness.record(0);
            }
            let part = PartUpload {
                job: lease.job,
                run,
                lease: lease.id,
                worker: "w".to_owned(),
                build: BUILD.to_owned(),
                core_us: 1,
                sums,
            };
            let body = wire::encode_part(&part).expect("part");
            let put = self.ask(
                Method::POST,
                routes::WORKER_RESULTS,
                wire::CONTENT_TYPE,
                body,
            );
            assert_eq!(put.await.0, StatusCode::OK);
        }
    }

    async fn post(&self, path: &str, body: &Value) -> (StatusCode, Value) {
        self.ask(
            Method::POST,
            path,
            "application/json",
            body.to_string().into(),
        )
        .await
    }

    /// A request of our own, with every right.
    async fn ask(
        &self,
        method: Method,
        path: &str,
        kind: &str,
        body: Vec<u8>,
    ) -> (StatusCode, Value) {
        let worker = path.starts_with("/v1/worker/");
        let token = token(if worker { "c" } else { "a" });
        let request = axum::http::Request::builder()
            .method(method)
            .uri(path)
            .header("content-type", kind)
            .header("authorization", format!("Bearer {token}"))
            .body(Body::from(body))
            .expect("request");
        let answer = self.routes.clone().oneshot(request).await;
        let answer = answer.unwrap_or_else(|never| match never {});
        let status = answer.status();
        let body = to_bytes(answer.into_body(), ANSWER_BYTES_MAX).await;
        let body = body.expect("body");
        (status, serde_json::from_slice(&body).unwrap_or_default())
    }

    /// The answer to a request and its body, as far as they come in time.
    pub(super) async fn answer(
        &self,
        request: axum::http::Request<Body>,
    ) -> Option<(Response<()>, Option<Vec<u8>>)> {
        let answer = self.routes.clone().oneshot(request);
        let answer = tokio::time::timeout(ANSWER_TIMEOUT, answer).await.ok()?;
        let (parts, body) = answer.unwrap_or_else(|never| match never {}).into_parts();
        let body = tokio::time::timeout(ANSWER_TIMEOUT, to_bytes(body, ANSWER_BYTES_MAX)).await;
        let body = body.ok().and_then(Result::ok).map(Vec::from);
        Some((Response::from_parts(parts, ()), body))
    }
}
