//! Results on their way to the coordinator: kept until acknowledged.

use crate::client::{CallError, Client};
use crate::held::{Held, HeldLease};
use crate::phase::{Phase, PhaseRx};
use crate::retry::{Ended, until_answered};
use crate::speed::Meter;
use crate::unit_log;
use shearwater_shared::api::{FailureKind, FailureReport, WorkerId};
use shearwater_shared::plan::Run;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use tokio::sync::mpsc;
use tokio::task::JoinSet;
use tracing::Instrument;

/// Uploads under way at once: hides the coordinator's write and the line's
/// round trip without opening many connections.
const UPLOADS_MAX: usize = 4;
/// Results that wait for an upload (half a megabyte each); beyond that, render
/// threads wait.
pub(crate) const RESULTS_WAITING_MAX: usize = 64;

/// Times that a result may arrive damaged before it counts as refused.
const DAMAGED_MAX: u32 = 3;
/// Refusals after which nobody waits for the run from this worker.
const SETTLED_KINDS: [&str; 6] = [
    ":quarantined",
    ":job-ended",
    ":not-found",
    ":unequal-result",
    ":build",
    ":protocol",
];

/// How a run ended on this worker.
#[derive(Debug)]
pub(crate) enum Outcome {
    /// Rendered: the message to deliver.
    Part(Vec<u8>),
    /// Cannot be rendered here: the reason.
    Failed(String),
    /// Cancelled meanwhile; nothing to say.
    Unwanted,
}

/// What of a lease failed.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Failed {
    /// All of it.
    Lease,
    /// All runs of a frame (the job's number).
    Frame(u32),
    /// One run.
    Run(Run),
}

/// A run that left its render thread.
#[derive(Debug)]
pub(crate) struct Settled {
    pub(crate) lease: Arc<HeldLease>,
    pub(crate) run: Run,
    pub(crate) outcome: Outcome,
}

/// What every upload needs.
#[derive(Clone)]
pub(crate) struct Uplink {
    pub(crate) client: Client,
    pub(crate) worker: WorkerId,
    pub(crate) held: Arc<Held>,
    pub(crate) meter: Arc<Meter>,
    pub(crate) phase: PhaseRx,
}

/// Deliver everything that arrives; ends when all render threads have ended
/// and everything is settled.
pub(crate) async fn upload_all(uplink: Uplink, mut finished: mpsc::Receiver<Settled>) {
    let mut uploads = JoinSet::new();
    while let Some(settled) = finished.recv().await {
        while uploads.len() >= UPLOADS_MAX {
            uploads.join_next().await;
        }
        let uplink = uplink.clone();
        let span = unit_log::span(&settled.lease, &settled.run);
        uploads.spawn(async move { uplink.settle(settled).await }.instrument(span));
    }
    while uploads.join_next().await.is_some() {}
}

impl Uplink {
    async fn settle(&self, settled: Settled) {
        let Settled {
            lease,
            run,
            outcome,
        } = settled;
        let done = match outcome {
            Outcome::Part(body) => self.deliver(&lease, &run, body).await,
            Outcome::Failed(reason) => {
                let report = self.report(&lease, Failed::Run(run), FailureKind::Worker, reason);
                self.send_failure(&report, Phase::Stopped).await
            }
            Outcome::Unwanted => true,
        };
        // What is not settled stays held, to be released at the end.
        if done {
            self.held.settle_run(&lease);
        }
    }

    async fn deliver(&self, lease: &HeldLease, run: &Run, body: Vec<u8>) -> bool {
        let damaged = AtomicU32::new(0);
        let send = || async {
            match self.client.result(body.clone()).await {
                // Our own message is whole: something on the way spoiled it.
                Err(CallError::Refused(problem))
                    if problem.status == 400
                        && damaged.fetch_add(1, Ordering::Relaxed) < DAMAGED_MAX =>
                {
                    Err(CallError::Damaged(problem.detail))
                }
                other => other,
            }
        };
        match until_answered(&self.phase, Phase::Stopped, "result", send).await {
            Ok(answer) => {
                tracing::debug!(duplicate = answer.duplicate, "delivered");
                self.meter.count(|summary| {
                    summary.runs += 1;
                    summary.duplicates += u64::from(answer.duplicate);
                });
            }
            Err(Ended::Refused(problem)) => {
                let detail = problem.detail;
                tracing::warn!(detail, "result is not wanted");
                self.meter.count(|summary| summary.refused += 1);
                if !SETTLED_KINDS
                    .iter()
                    .any(|kind| problem.kind.ends_with(kind))
                {
                    // Said aloud, or the run would be leased again without end.
                    let reason = format!("the coordinator refuses the result: {detail}");
                    let report = self.report(lease, Failed::Run(*run), FailureKind::Worker, reason);
                    return self.send_failure(&report, Phase::Stopped).await;
                }
            }
            Err(Ended::Stopped) => return false,
        }
        true
    }

    /// A failure of `lease`, of one frame of it (the job's number), or of one run.
    pub(crate) fn report(
        &self,
        lease: &HeldLease,
        what: Failed,
        kind: FailureKind,
        reason: String,
    ) -> FailureReport {
        let (frame, run) = match what {
            Failed::Lease => (None, None),
            Failed::Frame(frame) => (Some(frame), None),
            Failed::Run(run) => (None, Some(run)),
        };
        FailureReport {
            worker: self.worker.clone(),
            job: lease.job,
            lease: lease.id,
            run,
            frame,
            kind,
            reason,
        }
    }

    /// Send it until it is heard or the worker reaches `end`.
    pub(crate) async fn send_failure(&self, report: &FailureReport, end: Phase) -> bool {
        let (job, lease, reason) = (report.job.0, report.lease, &report.reason);
        // A wrong scene is told to its user by the job; nothing is wrong here.
        match report.kind {
            FailureKind::Scene => tracing::info!(job, lease, reason, "the scene is wrong"),
            FailureKind::Worker => tracing::error!(job, lease, reason, "cannot render"),
        }
        self.meter.count(|summary| summary.failures += 1);
        let send = || self.client.failure(report);
        !matches!(
            until_answered(&self.phase, end, "failure report", send).await,
            Err(Ended::Stopped)
        )
    }
}
