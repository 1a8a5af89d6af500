//! Built scenes: fetch, parse and build once, keep the last few.

use crate::assets::AssetCache;
use crate::client::{CallError, Client};
use crate::phase::{Phase, PhaseRx};
use crate::retry::{Ended, until_answered};
use shearwater_shared::api::{FailureKind, Lease, Problem};
use shearwater_shared::hash::ContentHash;
use shearwater_shared::job::{Manifest, RenderSettings};
use shearwater_shared::{limits, scene};
use shearwater_tracer::{Assets, BuildOptions, BuildReport, Scene};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

/// Built scenes that are kept: the one that renders and the one that comes
/// next; each may take gigabytes.
const SCENES_KEPT: usize = 2;

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

#[derive(Debug, PartialEq)]
struct Key {
    manifest: ContentHash,
    settings: RenderSettings,
    frame: u32,
}

/// The built scenes of one worker.
pub(crate) struct Scenes {
    client: Client,
    cache: AssetCache,
    phase: PhaseRx,
    threads: usize,
    portable_simd: bool,
    // Most recently used last.
    built: Vec<(Key, Arc<Scene>)>,
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
            built: Vec::new(),
        }
    }

    /// The scene of one frame of a lease.
    pub(crate) async fn get(
        &mut self,
        lease: &Lease,
        frame: u32,
    ) -> Result<Arc<Scene>, SceneFailure> {
        let key = Key {
            manifest: lease.manifest.key(),
            settings: lease.settings,
            frame,
        };
        if let Some(at) = self.built.iter().position(|(other, _)| *other == key) {
            let entry = self.built.remove(at);
            let scene = entry.1.clone();
            self.built.push(entry);
            return Ok(scene);
        }
        // Make room first: two scenes of one job need not fit beside a third.
        while self.built.len() >= SCENES_KEPT {
            self.built.remove(0);
        }
        let files = self.fetch(&lease.manifest).await?;
        let scene = self.build(files, lease.settings, frame).await?;
        self.built.push((key, scene.clone()));
        Ok(scene)
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

    async fn build(
        &self,
        (scene, assets): (Arc<[u8]>, Assets),
        settings: RenderSettings,
        frame: u32,
    ) -> Result<Arc<Scene>, SceneFailure> {
        let (threads, portable_simd) = (self.threads, self.portable_simd);
        let started = std::time::Instant::now();
        let work = move || {
            let build = || build_scene(&scene, &assets, settings, frame, portable_simd);
            catch_unwind(AssertUnwindSafe(|| in_pool(threads, build))).unwrap_or_else(|panic| {
                let text = format!("building the scene: {}", panic_text(&*panic));
                Err((FailureKind::Worker, text))
            })
        };
        let (scene, report) = tokio::task::spawn_blocking(work)
            .await
            .map_err(|e| SceneFailure::Report(FailureKind::Worker, e.to_string()))?
            .map_err(|(kind, text)| SceneFailure::Report(kind, text))?;
        let seconds = started.elapsed().as_secs_f64();
        let (triangles, particles) = (report.triangles, report.particles);
        tracing::info!(
            frame,
            seconds,
            triangles,
            particles,
            portable_simd,
            "scene built"
        );
        for note in &report.notes {
            tracing::warn!("{note}");
        }
        Ok(Arc::new(scene))
    }
}

type Built = Result<(Scene, BuildReport), (FailureKind, String)>;

fn build_scene(
    scene: &[u8],
    assets: &Assets,
    settings: RenderSettings,
    frame: u32,
    portable_simd: bool,
) -> Built {
    let options = BuildOptions { portable_simd };
    scene::parse(scene)
        .and_then(|description| Scene::build(&description, assets, &settings, frame, options))
        .map_err(|error| (FailureKind::Scene, error.to_string()))
}

/// Builds are parallel inside; they get the threads that the user gave.
fn in_pool(threads: usize, build: impl FnOnce() -> Built + Send) -> Built {
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
