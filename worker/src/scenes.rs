//! Scenes: fetch and parse once, build what all frames share once and each frame
//! once, keep the last few.

use crate::assets::AssetCache;
use crate::built::Built;
use crate::client::{CallError, Client};
use crate::phase::{Phase, PhaseRx};
use crate::retry::{Ended, until_answered};
use shearwater_shared::api::{FailureKind, Lease, Problem};
use shearwater_shared::hash::ContentHash;
use shearwater_shared::job::{Manifest, RenderSettings};
use shearwater_shared::{limits, scene};
use shearwater_tracer::{Assets, BuildOptions, Scene, Stage};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Instant;

/// Damaged copies of one asset before it counts as damaged where it is stored:
/// a bad line damages one or two.
const DAMAGED_MAX: u32 = 5;

/// Why a scene cannot be rendered here.
#[derive(Debug)]
pub(crate) enum SceneFailure {
    /// To be reported with this text.
    Report(FailureKind, String),
    /// The worker's end came first.
    Stopped,
}

/// What tells two frames of one stage apart. The numbers of a job's frames and of
/// its samples are not in it: jobs that cut one film in another way share its
/// frames, and a job that was added to goes on with them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct FrameKey {
    width: u32,
    height: u32,
    seed: u64,
    /// The scene's number of the frame.
    frame: u32,
}

impl FrameKey {
    fn new(settings: &RenderSettings, frame: u32) -> Self {
        // Named one by one: a new setting must be thought of here.
        let RenderSettings {
            width,
            height,
            samples: _,
            seed,
            frames: _,
            first_frame: _,
            stop: _,
        } = *settings;
        Self {
            width,
            height,
            seed,
            frame: settings.absolute_frame(frame),
        }
    }
}

/// The built scenes of one worker.
pub(crate) struct Scenes {
    client: Client,
    cache: AssetCache,
    phase: PhaseRx,
    threads: usize,
    portable_simd: bool,
    built: Built<ContentHash, Stage, FrameKey, Scene>,
}

impl Scenes {
    /// None yet. Builds take at most `threads` threads.
    pub(crate) fn new(
        client: Client,
        cache: AssetCache,
        phase: PhaseRx,
        threads: usize,
        portable_simd: bool,
    ) -> Self {
        Self {
            client,
            cache,
            phase,
            threads,
            portable_simd,
            built: Built::new(),
        }
    }

    /// Get ready what all frames of a lease share: what fails here would fail for
    /// each of them.
    pub(crate) async fn prepare(&mut self, lease: &Lease) -> Result<(), SceneFailure> {
        let manifest = lease.manifest.key();
        self.stage(&lease.manifest, manifest).await.map(drop)
    }

    /// The scene of one frame of a lease; `frame` is the job's number of it.
    /// Failures name the scene's number.
    pub(crate) async fn get(
        &mut self,
        lease: &Lease,
        frame: u32,
    ) -> Result<Arc<Scene>, SceneFailure> {
        let manifest = lease.manifest.key();
        let key = FrameKey::new(&lease.settings, frame);
        if let Some(scene) = self.built.frame(&manifest, &key) {
            return Ok(scene);
        }
        let stage = self.stage(&lease.manifest, manifest).await?;
        let settings = lease.settings;
        let started = Instant::now();
        let scene = self
            .compute(format!("building frame {}", key.frame), move || {
                let scene = stage.frame(&settings, key.frame);
                // Behind the text: it begins with the file and the place.
                scene
                    .map_err(|error| (FailureKind::Scene, format!("{error} (frame {})", key.frame)))
            })
            .await?;
        let seconds = started.elapsed().as_secs_f64();
        tracing::info!(frame = key.frame, seconds, "frame built");
        let scene = Arc::new(scene);
        self.built.put_frame(&manifest, key, scene.clone());
        Ok(scene)
    }

    /// What all frames of a scene share.
    async fn stage(
        &mut self,
        manifest: &Manifest,
        key: ContentHash,
    ) -> Result<Arc<Stage>, SceneFailure> {
        if let Some(stage) = self.built.stage(&key) {
            return Ok(stage);
        }
        self.built.make_room();
        let (scene, assets) = self.fetch(manifest).await?;
        let portable_simd = self.portable_simd;
        let started = Instant::now();
        let build = move || {
            let options = BuildOptions { portable_simd };
            scene::parse(&scene)
                .and_then(|description| Stage::build(&description, &assets, options))
                .map_err(|error| (FailureKind::Scene, error.to_string()))
        };
        let (stage, report) = self.compute("building the scene".to_owned(), build).await?;
        let seconds = started.elapsed().as_secs_f64();
        let (triangles, particles) = (report.triangles, report.particles);
        tracing::info!(seconds, triangles, particles, portable_simd, "stage built");
        for note in &report.notes {
            tracing::warn!("{note}");
        }
        let stage = Arc::new(stage);
        self.built.put_stage(key, stage.clone());
        Ok(stage)
    }

    async fn fetch(&self, manifest: &Manifest) -> Result<(Arc<[u8]>, Assets), SceneFailure> {
        let bound = limits::SCENE_BYTES_MAX as u64;
        let scene = self.fetch_one(&manifest.scene, None, bound).await?;
        let mut assets = Assets::new();
        for (name, asset) in &manifest.files {
            if asset.size > limits::ASSET_BYTES_MAX {
                let text = format!(
                    "{name}: {} bytes: at most {}",
                    asset.size,
                    limits::ASSET_BYTES_MAX
                );
                return Err(SceneFailure::Report(FailureKind::Scene, text));
            }
            let bytes = self.fetch_one(&asset.hash, Some(asset.size), asset.size);
            assets.insert(name.clone(), bytes.await?);
        }
        Ok((scene, assets))
    }

    async fn fetch_one(
        &self,
        hash: &ContentHash,
        size: Option<u64>,
        bytes_max: u64,
    ) -> Result<Arc<[u8]>, SceneFailure> {
        let damaged = AtomicU32::new(0);
        let fetch = || async {
            let fetched = self.cache.fetch(&self.client, hash, size, bytes_max).await;
            match fetched {
                Err(CallError::Damaged(why))
                    if damaged.fetch_add(1, Ordering::Relaxed) + 1 >= DAMAGED_MAX =>
                {
                    Err(CallError::Refused(Problem {
                        kind: String::new(),
                        title: "Damaged asset".to_owned(),
                        status: 0,
                        detail: format!("{why}; damaged in the store, upload it again"),
                    }))
                }
                other => other,
            }
        };
        until_answered(&self.phase, Phase::Draining, "asset", fetch)
            .await
            .map_err(|ended| match ended {
                Ended::Stopped => SceneFailure::Stopped,
                Ended::Refused(problem) => SceneFailure::Report(
                    FailureKind::Worker,
                    format!("asset {hash}: {}", problem.detail),
                ),
            })
    }

    /// Compute off the asynchronous threads, with the threads that the user gave;
    /// a panic is a failure of this worker.
    async fn compute<T: Send + 'static>(
        &self,
        what: String,
        work: impl FnOnce() -> Result<T, Failure> + Send + 'static,
    ) -> Result<T, SceneFailure> {
        let threads = self.threads;
        let caught = move || {
            catch_unwind(AssertUnwindSafe(|| in_pool(threads, work))).unwrap_or_else(|panic| {
                let text = format!("{what}: {}", panic_text(&*panic));
                Err((FailureKind::Worker, text))
            })
        };
        tokio::task::spawn_blocking(caught)
            .await
            .map_err(|e| SceneFailure::Report(FailureKind::Worker, e.to_string()))?
            .map_err(|(kind, text)| SceneFailure::Report(kind, text))
    }
}

/// Whose fault, and what happened.
type Failure = (FailureKind, String);

/// Builds are parallel inside.
fn in_pool<T: Send>(
    threads: usize,
    build: impl FnOnce() -> Result<T, Failure> + Send,
) -> Result<T, Failure> {
    match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool.install(build),
        Err(error) => Err((
            FailureKind::Worker,
            format!("threads for the build: {error}"),
        )),
    }
}

/// What a panic said.
pub(crate) fn panic_text(panic: &(dyn Any + Send)) -> String {
    let text = panic
        .downcast_ref::<&str>()
        .map(|text| (*text).to_owned())
        .or_else(|| panic.downcast_ref::<String>().cloned());
    format!("panic: {}", text.as_deref().unwrap_or("without a text"))
}
