//! The lease loop: ask for work, prepare its scene, feed the threads.

use crate::client::Client;
use crate::error::WorkerError;
use crate::held::HeldLease;
use crate::phase::{Phase, sleep_unless};
use crate::render::{Queue, Task};
use crate::retry::{Ended, until_answered};
use crate::scenes::{SceneFailure, Scenes};
use crate::unit_log;
use crate::upload::{Failed, Uplink};
use shearwater_shared::api::{FailureKind, Lease, LeaseRequest};
use shearwater_shared::plan::{Plan, Run};
use shearwater_shared::{limits, wire};
use shearwater_tracer::Scene;
use std::sync::Arc;
use std::time::Duration;

/// What the lease loop needs.
pub(crate) struct Leasing {
    pub(crate) client: Client,
    pub(crate) uplink: Uplink,
    pub(crate) queue: Arc<Queue>,
    pub(crate) scenes: Scenes,
    pub(crate) threads: usize,
    pub(crate) leave_when_quarantined: bool,
}

/// Pause of a worker in quarantine before it asks again: someone may have
/// looked after it, and asking costs little.
const QUARANTINE_PAUSE: Duration = Duration::from_secs(30);
/// Least time between two questions that brought nothing: a coordinator that
/// shuts down answers at once.
const EMPTY_PAUSE: Duration = Duration::from_millis(100);

impl Leasing {
    /// Work until the worker drains (`Ok`) or is refused.
    ///
    /// The next lease is asked for when no thread has more than one run left to
    /// begin: early enough to hide the call, late enough not to hoard runs that
    /// another worker could do.
    pub(crate) async fn work(mut self) -> Result<(), WorkerError> {
        loop {
            self.queue.at_most(self.threads).await;
            match self.ask().await {
                Ok(Some(lease)) => {
                    if !self.take(&lease).await {
                        return Ok(());
                    }
                }
                Ok(None) => {
                    if !self.pause(EMPTY_PAUSE).await {
                        return Ok(());
                    }
                }
                Err(Ended::Stopped) => return Ok(()),
                Err(Ended::Refused(problem))
                    if problem.kind.ends_with(":quarantined") && !self.leave_when_quarantined =>
                {
                    tracing::warn!(problem.detail, "in quarantine; asking again later");
                    if !self.pause(QUARANTINE_PAUSE).await {
                        return Ok(());
                    }
                }
                Err(Ended::Refused(problem)) => {
                    return Err(WorkerError::Refused {
                        title: problem.title,
                        detail: problem.detail,
                    });
                }
            }
        }
    }

    /// Wait; `false` when the worker drains.
    async fn pause(&self, time: Duration) -> bool {
        sleep_unless(&self.uplink.phase, Phase::Draining, time).await
    }

    async fn ask(&self) -> Result<Option<Lease>, Ended> {
        let ask = || async {
            let request = LeaseRequest {
                worker: self.uplink.worker.clone(),
                protocol: wire::PROTOCOL_VERSION,
                build: shearwater_tracer::BUILD.to_owned(),
                threads: u32::try_from(self.threads).unwrap_or(u32::MAX),
                samples_per_s: self.uplink.meter.samples_per_s(self.threads),
                wait_ms: limits::LEASE_WAIT_MS_MAX,
            };
            self.client.lease(&request).await
        };
        until_answered(&self.uplink.phase, Phase::Draining, "lease", ask).await
    }

    /// Queue the runs of a lease; `false` when the worker drains.
    async fn take(&mut self, lease: &Lease) -> bool {
        if lease.runs.is_empty() {
            return true;
        }
        let (id, job, runs) = (lease.id, lease.job, lease.runs.len());
        let heartbeat = Duration::from_millis(lease.heartbeat_ms);
        let held = Arc::new(HeldLease::new(id, job, heartbeat, runs));
        self.uplink.held.insert(held.clone());
        for run in &lease.runs {
            unit_log::span(&held, run).in_scope(|| tracing::debug!("leased"));
        }
        match self.queue_runs(lease, &held).await {
            Ok(()) => true,
            Err(SceneFailure::Stopped) => false,
            Err(SceneFailure::Report(kind, reason)) => {
                let report = self.uplink.report(&held, Failed::Lease, kind, reason);
                let heard = self.uplink.send_failure(&report, Phase::Draining).await;
                self.uplink.held.abandon(id);
                heard
            }
        }
    }

    /// Queue the runs of a lease, frame by frame. A frame that cannot be rendered
    /// here is reported; the others are rendered all the same.
    ///
    /// A frame is built when no thread has more than one run left to begin. Every
    /// run that waits or renders holds its frame, so that at most two frames for
    /// each thread live besides those that are kept, however many frames a lease
    /// names.
    async fn queue_runs(
        &mut self,
        lease: &Lease,
        held: &Arc<HeldLease>,
    ) -> Result<(), SceneFailure> {
        let wrong = |text: String| SceneFailure::Report(FailureKind::Worker, text);
        lease
            .settings
            .validate()
            .map_err(|e| wrong(e.to_string()))?;
        let plan = Plan::new(&lease.settings);
        self.scenes.prepare(lease).await?;
        for runs in lease.runs.chunk_by(|a, b| a.frame == b.frame) {
            let Some(first) = runs.first() else { continue };
            self.queue.at_most(self.threads).await;
            if held.is_cancelled() {
                return Ok(());
            }
            match self
                .frame_tasks(lease, first.frame, runs, &plan, held)
                .await
            {
                Ok(tasks) => tasks.into_iter().for_each(|task| self.queue.push(task)),
                Err(SceneFailure::Report(FailureKind::Worker, reason)) => {
                    let what = Failed::Frame(first.frame);
                    let report = self.uplink.report(held, what, FailureKind::Worker, reason);
                    if !self.uplink.send_failure(&report, Phase::Draining).await {
                        return Err(SceneFailure::Stopped);
                    }
                    runs.iter().for_each(|_| self.uplink.held.settle_run(held));
                }
                // A wrong scene ends the job.
                Err(ends) => return Err(ends),
            }
        }
        Ok(())
    }

    /// The tasks of the runs of one frame.
    async fn frame_tasks(
        &mut self,
        lease: &Lease,
        frame: u32,
        runs: &[Run],
        plan: &Plan,
        held: &Arc<HeldLease>,
    ) -> Result<Vec<Task>, SceneFailure> {
        let scene = self.scenes.get(lease, frame).await?;
        let tasks = runs.iter().map(|run| {
            task(plan, run, held, &scene).ok_or_else(|| {
                let text = format!("{run:?} is not of the job's plan");
                SceneFailure::Report(FailureKind::Worker, text)
            })
        });
        tasks.collect()
    }
}

fn task(plan: &Plan, run: &Run, lease: &Arc<HeldLease>, scene: &Arc<Scene>) -> Option<Task> {
    Some(Task {
        lease: lease.clone(),
        run: *run,
        rect: plan.tile_rect(run.tile)?,
        samples: plan.sample_range(run)?,
        scene: scene.clone(),
    })
}
