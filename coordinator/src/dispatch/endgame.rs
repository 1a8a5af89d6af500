//! Nothing is pending: what others hold is handed out once more.

use super::pass::{answer_lease, speed_of};
use super::snapshot::Snapshot;
use super::{Waiting, is_heard};
use crate::app::App;
use crate::farm::{Helper, runs_to_reissue};
use crate::presence::Present;
use crate::store::StoreError;
use shearwater_shared::job::JobId;

/// Workers of one batch that may find nothing: the fastest come first, and where they
/// win nothing, nobody does.
const TRIES_MAX: usize = 8;

/// Serve those who can help at the end of a job; the others are left.
pub(super) async fn help(
    app: &App,
    snapshot: &mut Snapshot,
    present: &Present,
    waiting: &mut Vec<Waiting>,
    now_ms: i64,
) -> Result<(), StoreError> {
    let jobs: Vec<JobId> = snapshot
        .jobs
        .iter()
        .filter(|job| job.units_leased > 0)
        .map(|job| job.id)
        .collect();
    if jobs.is_empty() {
        return Ok(());
    }
    waiting.sort_by(|a, b| speed_of(&b.item).total_cmp(&speed_of(&a.item)));
    let mut tries = 0;
    let mut at = 0;
    while at < waiting.len() && tries < TRIES_MAX {
        let Some(waiter) = waiting.get(at).filter(|waiter| is_heard(waiter)) else {
            at += 1;
            continue;
        };
        let helper = Helper {
            worker: waiter.item.request.worker.instance.clone(),
            samples_per_s: waiter.item.request.samples_per_s,
            target_ms: app.config.lease_target_ms,
        };
        match reissue(app, snapshot, present, &jobs, &helper, now_ms).await? {
            Some((job, claimed)) => {
                let worker = &waiter.item.request.worker.name;
                let runs = claimed.runs.len();
                app.metrics.leases.reissued.inc();
                tracing::info!(job = job.0, worker, runs, "handed out once more");
                let served = waiting.remove(at);
                answer_lease(app, served, job, claimed).await?;
            }
            None => {
                tries += 1;
                at += 1;
            }
        }
    }
    Ok(())
}

async fn reissue(
    app: &App,
    snapshot: &mut Snapshot,
    present: &Present,
    jobs: &[JobId],
    helper: &Helper,
    now_ms: i64,
) -> Result<Option<(JobId, crate::store::Claimed)>, StoreError> {
    for &job in jobs {
        let leases = snapshot.endgame(app, present, job).await?;
        let runs = runs_to_reissue(&leases, helper, now_ms);
        if runs.is_empty() {
            continue;
        }
        let until_ms = now_ms.saturating_add_unsigned(app.lease_ttl_ms());
        snapshot.forget_endgame(job);
        let claimed = app
            .store
            .reissue(job, &runs, &helper.worker, now_ms, until_ms)
            .await?;
        if let Some(claimed) = claimed {
            return Ok(Some((job, claimed)));
        }
    }
    Ok(None)
}
