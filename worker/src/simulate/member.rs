//! One simulated worker: the real protocol, with sleep in the place of rendering.

use super::dice::{self, Draw};
use super::queue::{Queue, Task};
use super::stats::Stats;
use super::{CrowdConfig, light};
use crate::client::Client;
use crate::error::WorkerError;
use crate::held::{Held, HeldLease};
use crate::phase::{Phase, PhaseRx, sleep_unless};
use crate::retry::{Ended, until_answered};
use crate::speed::Meter;
use crate::{heartbeat, random};
use shearwater_shared::api::{
    FailureKind, FailureReport, Lease, LeaseRequest, ReleaseRequest, WorkerId,
};
use shearwater_shared::limits;
use shearwater_shared::plan::{Plan, Run};
use shearwater_shared::wire::{self, PartUpload};
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::sync::Semaphore;
use tokio::task::JoinSet;

/// Uploads under way at once, as of the real worker.
const UPLOADS_MAX: usize = 4;
/// Pauses of the real worker's lease loop.
const QUARANTINE_PAUSE: Duration = Duration::from_secs(30);
const EMPTY_PAUSE: Duration = Duration::from_millis(100);
/// How often a sleep looks whether its lease was dropped.
const SLICE: Duration = Duration::from_millis(500);

/// How the life of a simulated worker ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Life {
    /// As a machine that lost its power: another one comes in its place.
    Vanished,
    /// With the simulation.
    Over,
}

/// What all members share.
#[derive(Debug)]
pub(super) struct Common {
    pub(super) config: CrowdConfig,
    pub(super) plan: Plan,
    pub(super) stats: Arc<Stats>,
}

/// One process that is not one.
struct Member {
    common: Arc<Common>,
    number: u32,
    client: Client,
    worker: WorkerId,
    held: Held,
    queue: Queue,
    meter: Meter,
    phase: PhaseRx,
    uploads: Arc<Semaphore>,
}

/// Live once, as worker `number`, for the `life`th time.
pub(super) async fn live(
    common: &Arc<Common>,
    number: u32,
    life: u32,
    phase: PhaseRx,
) -> Result<Life, WorkerError> {
    let config = &common.config;
    let client = Client::new(&config.coordinator_url, &config.access)?
        .counted_in(common.stats.traffic.clone());
    let member = Arc::new(Member {
        common: common.clone(),
        number,
        client,
        worker: WorkerId {
            name: format!("simulated-{number}"),
            instance: random::instance(),
        },
        held: Held::default(),
        queue: Queue::default(),
        meter: Meter::default(),
        phase: phase.clone(),
        uploads: Arc::new(Semaphore::new(UPLOADS_MAX)),
    });
    // Dropped, and with it every connection, whichever ends first.
    let mut threads = JoinSet::new();
    for thread in 0..config.habits.threads.max(1) {
        let member = member.clone();
        threads.spawn(async move { member.render(life, thread).await });
    }
    let beat = heartbeat::beat(
        member.client.clone(),
        member.worker.clone(),
        &member.held,
        phase.clone(),
    );
    tokio::select! {
        // The lease loop first: it notes for how long it has waited.
        biased;
        () = member.lease(life) => Ok(Life::Over),
        () = beat => Ok(Life::Over),
        _ = threads.join_next() => {
            common.stats.count(|counts| counts.vanished += 1);
            Ok(Life::Vanished)
        }
    }
}

impl Member {
    fn threads(&self) -> usize {
        self.common.config.habits.threads.max(1) as usize
    }

    /// The lease loop of the real worker.
    async fn lease(&self, life: u32) {
        let mut asked = None;
        let mut known = life > 0;
        let stats = &self.common.stats;
        loop {
            self.queue.at_most(self.threads()).await;
            let since = *asked.get_or_insert_with(Instant::now);
            let answer = self.ask().await;
            if !known && !matches!(answer, Err(Ended::Stopped)) {
                stats.count(|counts| counts.connected += 1);
                known = true;
            }
            let pause = match answer {
                Ok(Some(lease)) if !lease.runs.is_empty() => {
                    asked = None;
                    self.take(&lease, since).await;
                    continue;
                }
                Ok(_) => EMPTY_PAUSE,
                Err(Ended::Stopped) => {
                    stats.left_waiting(since);
                    return;
                }
                Err(Ended::Refused(problem)) if problem.kind.ends_with(":quarantined") => {
                    stats.count(|counts| counts.quarantined += 1);
                    asked = None;
                    QUARANTINE_PAUSE
                }
                Err(Ended::Refused(problem)) => {
                    stats.refused(format!("{}: {}", problem.title, problem.detail));
                    return;
                }
            };
            if !sleep_unless(&self.phase, Phase::Draining, pause).await {
                stats.left_waiting(since);
                return;
            }
        }
    }

    async fn ask(&self) -> Result<Option<Lease>, Ended> {
        let ask = || async {
            let request = LeaseRequest {
                worker: self.worker.clone(),
                protocol: wire::PROTOCOL_VERSION,
                build: shearwater_tracer::BUILD.to_owned(),
                threads: self.common.config.habits.threads.max(1),
                samples_per_s: self.meter.samples_per_s(self.threads()),
                wait_ms: limits::LEASE_WAIT_MS_MAX,
            };
            // Boxed: a waiting member should cost little.
            Box::pin(self.client.lease(&request)).await
        };
        until_answered(&self.phase, Phase::Draining, "lease", ask).await
    }

    /// Queue the runs of a lease of the simulation's own job.
    async fn take(&self, lease: &Lease, asked: Instant) {
        let stats = &self.common.stats;
        // Work may come before whoever submitted the job has heard its number.
        let mut job = self.common.config.job.clone();
        let known = job.wait_for(Option::is_some).await.map(|job| *job);
        if known.ok().flatten() != Some(lease.job) {
            stats.count(|counts| counts.foreign += 1);
            let request = ReleaseRequest {
                worker: self.worker.clone(),
                leases: vec![lease.id],
            };
            // If it is not heard, the lease expires.
            let _ = self.client.release(&request).await;
            return;
        }
        stats.given(&lease.runs, asked);
        let heartbeat = Duration::from_millis(lease.heartbeat_ms);
        let held = HeldLease::new(lease.id, lease.job, heartbeat, lease.runs.len());
        let held = Arc::new(held);
        self.held.insert(held.clone());
        let tasks = lease.runs.iter().map(|run| (held.clone(), *run));
        self.queue.extend(tasks);
    }

    /// One render thread; ends only when the worker vanishes.
    async fn render(self: Arc<Self>, life: u32, thread: u32) {
        let habits = &self.common.config.habits;
        let mut uploads = JoinSet::new();
        for turn in 0u64.. {
            let task = self.queue.next().await;
            let place = [
                self.number.into(),
                u64::from(life) << 32 | u64::from(thread),
                turn,
            ];
            let time = habits.time(self.number, &task.1, place);
            if !self.sleep(&task, time).await {
                self.common.stats.count(|counts| counts.dropped += 1);
                self.held.settle_run(&task.0);
                continue;
            }
            if dice::share(habits.seed, Draw::Vanish, place) < habits.vanish_rate {
                return;
            }
            let samples = self.common.plan.run_samples(&task.1);
            self.meter.rendered(samples, time.as_secs_f64());
            let fails = dice::share(habits.seed, Draw::Failure, place) < habits.failure_rate
                && self.common.stats.may_fail(&task.1);
            while uploads.try_join_next().is_some() {}
            // The semaphore is never closed.
            let permit = self.uploads.clone().acquire_owned().await;
            let member = self.clone();
            uploads.spawn(async move {
                let _permit = permit;
                let done = if fails {
                    member.fail(&task).await
                } else {
                    member.deliver(&task, time).await
                };
                if done {
                    member.held.settle_run(&task.0);
                }
            });
        }
    }

    /// Sleep as long as a run takes; `false` when its lease is dropped.
    async fn sleep(&self, (lease, _): &Task, time: Duration) -> bool {
        let end = tokio::time::Instant::now() + time;
        loop {
            if lease.is_cancelled() {
                return false;
            }
            let slice = (tokio::time::Instant::now() + SLICE).min(end);
            tokio::time::sleep_until(slice).await;
            if slice == end {
                return true;
            }
        }
    }

    async fn deliver(&self, (lease, run): &Task, time: Duration) -> bool {
        let Some(body) = self.message(lease, run, time) else {
            self.common
                .stats
                .refused(format!("{run:?} is not of the job's plan"));
            return true;
        };
        let since = Instant::now();
        let send = || async { Box::pin(self.client.result(body.clone())).await };
        let stats = &self.common.stats;
        match until_answered(&self.phase, Phase::Stopped, "result", send).await {
            Ok(answer) => stats.acknowledged(run, answer.duplicate, since.elapsed()),
            Err(Ended::Refused(problem)) => {
                tracing::debug!(?run, problem.detail, "result is not wanted");
                stats.count(|counts| counts.refused += 1);
            }
            Err(Ended::Stopped) => return false,
        }
        true
    }

    fn message(&self, lease: &HeldLease, run: &Run, time: Duration) -> Option<Vec<u8>> {
        let part = PartUpload {
            job: lease.job,
            run: *run,
            lease: lease.id,
            worker: self.worker.instance.clone(),
            build: shearwater_tracer::BUILD.to_owned(),
            core_us: u64::try_from(time.as_micros()).unwrap_or(u64::MAX),
            sums: light::sums(&self.common.plan, run)?,
        };
        wire::encode_part(&part).ok()
    }

    async fn fail(&self, (lease, run): &Task) -> bool {
        let report = FailureReport {
            worker: self.worker.clone(),
            job: lease.job,
            lease: lease.id,
            run: Some(*run),
            frame: None,
            kind: FailureKind::Worker,
            reason: "simulated".to_owned(),
        };
        self.common.stats.count(|counts| counts.failures += 1);
        let send = || async { Box::pin(self.client.failure(&report)).await };
        !matches!(
            until_answered(&self.phase, Phase::Stopped, "failure report", send).await,
            Err(Ended::Stopped)
        )
    }
}
