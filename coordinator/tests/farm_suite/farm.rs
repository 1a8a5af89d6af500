//! A farm with made-up workers, whose sums are a function of the run alone.

use reqwest::{Response, StatusCode};
use serde::Serialize;
use serde::de::DeserializeOwned;
use shearwater_coordinator::{Config, Coordinator};
use shearwater_shared::api::{
    JobView, Lease, LeaseRequest, Problem, ResultResponse, SettingsOverride, SubmitRequest,
    WorkerId,
};
use shearwater_shared::film::{TileFilm, TileSums, film_hash};
use shearwater_shared::hash::ContentHash;
use shearwater_shared::job::{AssetRef, JobId, Manifest, RenderSettings};
use shearwater_shared::plan::{Plan, Run};
use shearwater_shared::routes;
use shearwater_shared::wire::{self, PROTOCOL_VERSION, PartUpload};
use std::path::Path;
use std::time::{Duration, Instant};

pub(crate) const BUILD: &str = "test-build";

/// 96 x 80 pixels are 2 x 2 tiles of four sizes; 512 samples are 4 blocks.
pub(crate) const SCENE: &str = r#"{
  "version": 1, "name": "two by two", "image": { "width": 96, "height": 80 },
  "job": { "samples": 512 },
  "camera": { "position_m": [0, 0, 5], "target_m": [0, 0, 0], "vertical_fov_deg": 40 },
  "sky": { "type": "constant", "radiance": [1, 1, 1] }
}"#;

pub(crate) struct Farm {
    pub(crate) coordinator: Coordinator,
    pub(crate) http: reqwest::Client,
    pub(crate) dir: tempfile::TempDir,
}

pub(crate) fn config(dir: &Path) -> Config {
    let listen = "127.0.0.1:0".parse().expect("address");
    let mut config = Config::new(dir.to_owned(), listen, BUILD.to_owned());
    // Which runs are audited is random; tests of it ask for all or none.
    config.audit_ppm = 0;
    config
}

pub(crate) async fn start() -> Farm {
    start_with(|_| {}).await
}

pub(crate) async fn start_with(change: impl FnOnce(&mut Config)) -> Farm {
    let dir = tempfile::tempdir().expect("folder");
    let mut config = config(dir.path());
    change(&mut config);
    let coordinator = Coordinator::start(config).await.expect("start");
    let http = client().build().expect("client");
    Farm {
        coordinator,
        http,
        dir,
    }
}

/// A client of its own connections.
pub(crate) fn client() -> reqwest::ClientBuilder {
    // Only the first test of the process installs it.
    let _ = rustls::crypto::ring::default_provider().install_default();
    reqwest::Client::builder()
        .timeout(Duration::from_secs(30))
        // Plain HTTP needs no authorities, and a machine may have none.
        .tls_certs_only([])
}

pub(crate) fn worker(name: &str) -> WorkerId {
    WorkerId {
        name: name.to_owned(),
        instance: format!("{name}-instance"),
    }
}

pub(crate) fn lease_request(name: &str, samples_per_s: f64, wait_ms: u64) -> LeaseRequest {
    LeaseRequest {
        worker: worker(name),
        protocol: PROTOCOL_VERSION,
        build: BUILD.to_owned(),
        threads: 1,
        samples_per_s,
        wait_ms,
    }
}

/// What a run's sums are in this farm: any two runs differ, any cut agrees.
pub(crate) fn sums(plan: &Plan, run: &Run, seed: i64) -> TileSums {
    let range = plan.sample_range(run).expect("run of the plan");
    let pixels = plan.tile_rect(run.tile).expect("tile").pixels();
    let mut sums = TileSums::zero(pixels, &range);
    let salt = seed * 31 + i64::from(run.frame) * 17 + i64::from(run.tile) * 7;
    for (half, values) in sums.radiance.iter_mut().enumerate() {
        for (pixel, rgb) in values.chunks_exact_mut(3).enumerate() {
            for sample in range.clone() {
                let drift = salt + i64::from(sample) * (3 + half as i64);
                let light = [0, 1, 2].map(|c| (drift + 3 * pixel as i64 + c) % 4_000_037);
                sums.brightness.record(light.iter().sum());
                rgb.iter_mut().zip(light).for_each(|(sum, v)| *sum += v);
            }
        }
    }
    sums
}

/// The same sums as if one sample had been a step brighter.
pub(crate) fn brighten(sums: &mut TileSums) {
    sums.radiance[0][0] += 1;
    let bins = sums.brightness.bins.iter_mut();
    let fullest = bins.max_by_key(|bin| bin.samples).expect("bins");
    fullest.light += 1;
}

/// The same sums as if `bad` black samples had been bad ones.
pub(crate) fn spoil(sums: &mut TileSums, bad: u64) {
    sums.bad.not_a_number += bad;
    let bins = sums.brightness.bins.iter_mut();
    let fullest = bins.max_by_key(|bin| bin.samples).expect("bins");
    fullest.samples -= bad;
}

/// The film hash that a job must have, computed without any farm.
pub(crate) fn expected_hash(settings: &RenderSettings, frame: u32) -> ContentHash {
    let plan = Plan::new(settings);
    let films: Vec<TileFilm> = (0..plan.tiles())
        .map(|tile| {
            let mut film = TileFilm::zero(plan.tile_rect(tile).expect("tile").pixels());
            for block in 0..plan.blocks() {
                let run = Run {
                    frame,
                    tile,
                    block0: block,
                    block1: block + 1,
                };
                film.add(&sums(&plan, &run, 0)).expect("fits");
            }
            film
        })
        .collect();
    film_hash(&plan, |tile| &films[tile as usize]).expect("hash")
}

pub(crate) fn part(job: &JobView, lease: i64, run: &Run, name: &str) -> PartUpload {
    PartUpload {
        job: job.id,
        run: *run,
        lease,
        worker: worker(name).instance,
        build: BUILD.to_owned(),
        core_us: 1_000_000,
        sums: sums(&Plan::new(&job.settings), run, 0),
    }
}

impl Farm {
    pub(crate) fn url(&self, path: &str) -> String {
        format!("http://{}{path}", self.coordinator.addr())
    }

    pub(crate) async fn get(&self, path: &str) -> Response {
        self.http.get(self.url(path)).send().await.expect("answer")
    }

    pub(crate) async fn post<T: Serialize>(&self, path: &str, body: &T) -> Response {
        let request = self.http.post(self.url(path)).json(body);
        request.send().await.expect("answer")
    }

    pub(crate) async fn put_asset(&self, bytes: &[u8]) -> ContentHash {
        let hash = ContentHash::of(bytes);
        let path = routes::fill(routes::ASSET, &hash.to_string());
        let request = self.http.put(self.url(&path)).body(bytes.to_vec());
        let answer = request.send().await.expect("answer");
        assert!(answer.status().is_success(), "{answer:?}");
        hash
    }

    pub(crate) async fn scene_request(&self) -> SubmitRequest {
        SubmitRequest {
            name: None,
            manifest: Manifest {
                scene: self.put_asset(SCENE.as_bytes()).await,
                files: [].into(),
            },
            settings: SettingsOverride::default(),
            priority: 0,
            webhook: None,
        }
    }

    pub(crate) async fn submit(&self) -> JobView {
        let request = self.scene_request().await;
        let answer = self.post(routes::JOBS, &request).await;
        assert_eq!(answer.status(), StatusCode::CREATED);
        json(answer).await
    }

    pub(crate) async fn job(&self, id: JobId) -> JobView {
        let answer = self.get(&routes::fill(routes::JOB, &id.to_string())).await;
        assert_eq!(answer.status(), StatusCode::OK);
        json(answer).await
    }

    pub(crate) async fn lease(&self, name: &str, samples_per_s: f64) -> Option<Lease> {
        let request = lease_request(name, samples_per_s, 0);
        let answer = self.post(routes::WORKER_LEASES, &request).await;
        match answer.status() {
            StatusCode::NO_CONTENT => None,
            StatusCode::OK => Some(json(answer).await),
            other => panic!("{other}: {}", answer.text().await.unwrap_or_default()),
        }
    }

    pub(crate) async fn deliver_bytes(&self, body: Vec<u8>) -> Response {
        let request = self
            .http
            .post(self.url(routes::WORKER_RESULTS))
            .header("content-type", wire::CONTENT_TYPE)
            .body(body);
        request.send().await.expect("answer")
    }

    pub(crate) async fn deliver(&self, part: &PartUpload) -> Response {
        self.deliver_bytes(wire::encode_part(part).expect("encode"))
            .await
    }

    /// Deliver a run; whether it was a duplicate.
    pub(crate) async fn deliver_run(
        &self,
        job: &JobView,
        lease: i64,
        run: &Run,
        name: &str,
    ) -> bool {
        let answer = self.deliver(&part(job, lease, run, name)).await;
        assert_eq!(answer.status(), StatusCode::OK, "{answer:?}");
        json::<ResultResponse>(answer).await.duplicate
    }

    /// Lease and deliver until nothing is left.
    pub(crate) async fn work(&self, job: &JobView, name: &str) {
        while let Some(lease) = self.lease(name, 1e6).await {
            for run in &lease.runs {
                self.deliver_run(job, lease.id, run, name).await;
            }
        }
    }

    /// The job once `enough` holds.
    pub(crate) async fn wait(&self, id: JobId, enough: impl Fn(&JobView) -> bool) -> JobView {
        let started = Instant::now();
        loop {
            let job = self.job(id).await;
            if enough(&job) {
                return job;
            }
            assert!(started.elapsed() < Duration::from_secs(60), "{job:?}");
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    }
}

pub(crate) async fn json<T: DeserializeOwned>(answer: Response) -> T {
    let text = answer.text().await.expect("body");
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{e}: {text}"))
}

/// The answer is a problem of this kind and status, in every respect.
pub(crate) async fn problem(answer: Response, status: u16, kind: &str) -> Problem {
    let media_type = answer.headers()["content-type"]
        .to_str()
        .expect("text")
        .to_owned();
    let answered = answer.status().as_u16();
    let problem: Problem = json(answer).await;
    assert_eq!((answered, problem.status), (status, status), "{problem:?}");
    assert_eq!(media_type, "application/problem+json");
    assert_eq!(
        problem.kind,
        format!("urn:shearwater:problem:{kind}"),
        "{problem:?}"
    );
    assert!(!problem.detail.is_empty() && !problem.title.is_empty());
    problem
}

/// A job exists for tests that only need its settings.
pub(crate) fn asset_ref(bytes: &[u8]) -> AssetRef {
    AssetRef {
        hash: ContentHash::of(bytes),
        size: bytes.len() as u64,
    }
}

/// Every file below a folder.
pub(crate) fn files(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).expect("folder").flatten() {
        if entry.path().is_dir() {
            found.extend(files(&entry.path()));
        } else {
            found.push(entry.path().display().to_string());
        }
    }
    found
}
