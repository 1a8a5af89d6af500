//! The worker process: lease, fetch, render, upload.
//!
//! One asynchronous side talks to the coordinator (leases, heartbeats, uploads);
//! `threads` render threads do nothing but render. A worker pulls: it
//! needs no open port and no address of its own. It survives its coordinator
//! for ever, keeps every result until it is acknowledged, and hands back what
//! it cannot finish. No choice made here changes a pixel.

mod assets;
mod built;
mod client;
mod config;
pub mod connection;
mod cpu_time;
mod error;
mod heartbeat;
mod held;
mod lease;
mod phase;
mod random;
mod render;
mod retry;
mod scenes;
pub mod simulate;
mod speed;
mod traffic;
mod unit_log;
mod upload;

pub use config::Config;
pub use error::WorkerError;
/// The numeric build of this worker: coordinators refuse any other than theirs.
pub use shearwater_tracer::{BUILD, export, water};
pub use speed::Summary;

use client::Client;
use held::Held;
use phase::Phase;
use render::{Origin, Queue};
use shearwater_shared::api::{ReleaseRequest, WorkerId};
use shearwater_shared::limits;
use speed::Meter;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{mpsc, watch};
use tokio::task::JoinHandle;
use upload::{RESULTS_WAITING_MAX, Settled, Uplink};

/// Most render threads: the largest machines have some hundreds of cores.
const THREADS_MAX: usize = 1024;
/// A cancelled run ends within one batch of paths; tasks see it at once.
const CANCEL_TIME: Duration = Duration::from_secs(5);
/// One attempt to hand leases back; without it they expire by themselves.
const RELEASE_TIME: Duration = Duration::from_secs(2);

/// Work for a coordinator until `shutdown` completes.
///
/// Then the runs that have begun are finished and delivered within
/// [`Config::shutdown_grace`]; everything else is released.
///
/// # Errors
/// A setting is out of range, or the coordinator refuses this worker. A
/// coordinator that is away is no error: it is tried again for ever.
pub async fn run(
    config: Config,
    shutdown: impl Future<Output = ()>,
) -> Result<Summary, WorkerError> {
    check(&config)?;
    let client = Client::new(&config.coordinator_url, &config.access)?;
    let worker = WorkerId {
        name: config.name.clone(),
        instance: random::instance(),
    };
    let (phase_tx, phase) = watch::channel(Phase::Working);
    let uplink = Uplink {
        client: client.clone(),
        worker: worker.clone(),
        held: Arc::new(Held::default()),
        meter: Arc::new(Meter::default()),
        phase: phase.clone(),
    };
    let queue = Arc::new(Queue::default());
    let (finished, results) = mpsc::channel(RESULTS_WAITING_MAX);
    let mut uploads = tokio::spawn(upload::upload_all(uplink.clone(), results));
    start_threads(&config, &uplink, &queue, finished).inspect_err(|_| queue.close())?;
    let heart = {
        let (uplink, client, worker) = (uplink.clone(), client.clone(), worker.clone());
        tokio::spawn(async move {
            heartbeat::beat(client, worker, &uplink.held, uplink.phase.clone()).await;
        })
    };
    let leasing = lease::Leasing {
        client: client.clone(),
        uplink: uplink.clone(),
        queue: queue.clone(),
        scenes: scenes::Scenes::new(
            client.clone(),
            assets::AssetCache::new(config.asset_cache_bytes),
            phase,
            config.threads,
            config.portable_simd,
        ),
        threads: config.threads,
        leave_when_quarantined: config.leave_when_quarantined,
    };
    tracing::info!(
        coordinator = config.coordinator_url,
        threads = config.threads,
        name = worker.name,
        worker = worker.instance,
        "worker starts"
    );
    let ended = tokio::select! {
        ended = leasing.work() => ended,
        () = shutdown => Ok(()),
    };
    phase_tx.send_replace(Phase::Draining);
    queue.close();
    drain(&uplink.held, &phase_tx, &mut uploads, config.shutdown_grace).await;
    phase_tx.send_replace(Phase::Stopped);
    release(&client, &worker, uplink.held.abandon_all()).await;
    let _ = heart.await;
    ended.map(|()| uplink.meter.summary())
}

fn check(config: &Config) -> Result<(), WorkerError> {
    let wrong = |field, expected| Err(WorkerError::Config { field, expected });
    if !(1..=THREADS_MAX).contains(&config.threads) {
        return wrong("threads", format!("1 to {THREADS_MAX}"));
    }
    if !(1..=limits::NAME_BYTES_MAX).contains(&config.name.len()) {
        return wrong("name", format!("1 to {} bytes", limits::NAME_BYTES_MAX));
    }
    Ok(())
}

fn start_threads(
    config: &Config,
    uplink: &Uplink,
    queue: &Arc<Queue>,
    finished: mpsc::Sender<Settled>,
) -> Result<(), WorkerError> {
    let origin = Origin {
        worker: uplink.worker.instance.clone(),
        build: BUILD.to_owned(),
    };
    for number in 0..config.threads {
        let (queue, meter) = (queue.clone(), uplink.meter.clone());
        let (origin, finished) = (origin.clone(), finished.clone());
        // Not joined: the uploads end when every thread has dropped its sender.
        std::thread::Builder::new()
            .name(format!("render-{number}"))
            .spawn(move || render::render_thread(&queue, &meter, &origin, &finished))
            .map_err(WorkerError::Thread)?;
    }
    drop(finished);
    Ok(())
}

/// Wait for the runs that have begun and their uploads; beyond `grace`, give up.
async fn drain(
    held: &Held,
    phase: &watch::Sender<Phase>,
    uploads: &mut JoinHandle<()>,
    grace: Duration,
) {
    if tokio::time::timeout(grace, &mut *uploads).await.is_ok() {
        return;
    }
    let given_up = held.ids();
    tracing::warn!(
        ?given_up,
        "results not delivered in time; leases given back"
    );
    held.cancel_all();
    phase.send_replace(Phase::Stopped);
    let _ = tokio::time::timeout(CANCEL_TIME, &mut *uploads).await;
}

async fn release(client: &Client, worker: &WorkerId, leases: Vec<i64>) {
    if leases.is_empty() {
        return;
    }
    let request = ReleaseRequest {
        worker: worker.clone(),
        leases,
    };
    if let Ok(Err(why)) = tokio::time::timeout(RELEASE_TIME, client.release(&request)).await {
        tracing::debug!(?why, "release not heard");
    }
}
