//! From a worker's question to a lease: snapshot, decision, transition.

use crate::app::{App, now_ms};
use crate::farm::{
    Helper, LiveJob, OpenLease, QUARANTINE_MS, Sizing, cut_runs, frame_deadline_ms,
    lease_target_ms, lease_units, next_job, runs_to_reissue,
};
use crate::store::{Claimed, JobRow, ReadyQuery, StoreError, WorkerRow};
use shearwater_shared::api::{Lease, LeaseRequest};
use shearwater_shared::job::JobId;
use std::collections::BTreeMap;

/// A worker counts as present when it was heard of within this time: longer
/// than the longest poll ([`shearwater_shared::limits::LEASE_WAIT_MS_MAX`]).
const PRESENT_MS: i64 = 30_000;
/// Leased units that the endgame looks at; more means that it is no endgame.
const ENDGAME_UNITS_MAX: u32 = 4096;

/// What a worker gets.
#[derive(Debug)]
pub(crate) enum Dispatch {
    /// Work.
    Lease(Box<Lease>),
    /// Nothing now.
    Nothing,
    /// Nothing until this time, and why.
    Quarantined(i64, String),
}

/// Find work for one worker.
pub(crate) async fn dispatch(app: &App, request: &LeaseRequest) -> Result<Dispatch, StoreError> {
    // A result that cannot be stored had better not be begun.
    if app.troubles.work_pauses() {
        return Ok(Dispatch::Nothing);
    }
    let now_ms = now_ms();
    let instance = &request.worker.instance;
    let present = app.store.workers(now_ms - PRESENT_MS).await?;
    let own = present.iter().find(|w| w.instance == *instance);
    if let Some(refused) = own.and_then(|own| refused(own, now_ms)) {
        return Ok(refused);
    }
    let until_ms = now_ms.saturating_add_unsigned(app.config.lease_ttl_ms);
    let audits = app
        .store
        .lease_audits(instance, &request.build, now_ms, until_ms);
    if let Some((job, claimed)) = audits.await? {
        app.metrics.leases.audit.inc();
        return lease(app, job, claimed).await;
    }
    let jobs = app.store.live_jobs(&request.build).await?;
    for job in next_job(&jobs) {
        if let Some(claimed) = claim(app, request, job, &present, now_ms).await? {
            app.metrics.leases.fresh.inc();
            return lease(app, job.id, claimed).await;
        }
    }
    let speeds: BTreeMap<&str, f64> = present
        .iter()
        .map(|w| (w.instance.as_str(), w.milli_samples_per_s as f64 / 1000.0))
        .collect();
    for job in jobs.iter().filter(|job| job.units_leased > 0) {
        if let Some(claimed) = reissue(app, request, job.id, &speeds, now_ms).await? {
            app.metrics.leases.reissued.inc();
            tracing::info!(
                job = job.id.0,
                worker = request.worker.name,
                runs = claimed.runs.len(),
                "handed out once more"
            );
            return lease(app, job.id, claimed).await;
        }
    }
    Ok(Dispatch::Nothing)
}

/// Whether a worker gets nothing now.
fn refused(worker: &WorkerRow, now_ms: i64) -> Option<Dispatch> {
    // As long as it runs; it may ask again as one in quarantine may.
    let until_ms = if worker.distrusted {
        now_ms.saturating_add(QUARANTINE_MS)
    } else {
        worker.quarantined_until_ms
    };
    let reason = worker.quarantine_reason.clone().unwrap_or_default();
    (until_ms > now_ms).then_some(Dispatch::Quarantined(until_ms, reason))
}

async fn claim(
    app: &App,
    request: &LeaseRequest,
    job: &LiveJob,
    present: &[WorkerRow],
    now_ms: i64,
) -> Result<Option<Claimed>, StoreError> {
    let others = present
        .iter()
        .filter(|w| w.instance != request.worker.instance && refused(w, now_ms).is_none());
    let (mut count, mut speed) = (0u64, 0.0);
    for other in others {
        count += 1;
        speed += other.milli_samples_per_s as f64 / 1000.0;
    }
    let Some(row) = app.store.job(job.id).await? else {
        return Ok(None);
    };
    let wanted = lease_units(&Sizing {
        target_ms: target_ms(app, &row, now_ms),
        unit_samples: job.unit_samples(),
        samples_per_s: request.samples_per_s,
        threads: request.threads,
        pending: job.units_pending(),
        others: count,
        others_samples_per_s: speed,
    });
    let units_max = usize::try_from(wanted).unwrap_or(usize::MAX);
    let query = ReadyQuery {
        job: job.id,
        worker: request.worker.instance.clone(),
        units_max,
        present: if count > 0 { count + 1 } else { 0 },
        timed: row.out_of_time(now_ms),
    };
    let (plan, threads) = (row.plan(), request.threads);
    let until_ms = now_ms.saturating_add_unsigned(app.config.lease_ttl_ms);
    app.store
        .claim(
            &query,
            move |ready| cut_runs(ready, &plan, threads),
            now_ms,
            until_ms,
        )
        .await
}

/// How long a lease of this job should take.
fn target_ms(app: &App, row: &JobRow, now_ms: i64) -> u64 {
    let target_ms = app.config.lease_target_ms;
    let (Some(seconds), Some(over)) = (row.settings.stop.seconds, row.out_of_time(now_ms)) else {
        return target_ms;
    };
    let from_ms = row.timed_from_ms.unwrap_or(now_ms);
    let deadline_ms = frame_deadline_ms(from_ms, seconds, over, row.settings.frames);
    lease_target_ms(target_ms, deadline_ms, now_ms)
}

async fn reissue(
    app: &App,
    request: &LeaseRequest,
    job: JobId,
    speeds: &BTreeMap<&str, f64>,
    now_ms: i64,
) -> Result<Option<Claimed>, StoreError> {
    let leased = app.store.leased_units(job, ENDGAME_UNITS_MAX).await?;
    let Some(row) = app.store.job(job).await? else {
        return Ok(None);
    };
    let plan = row.plan();
    let leases: Vec<OpenLease> = app
        .store
        .open_leases(job)
        .await?
        .into_iter()
        .map(|lease| OpenLease {
            samples_per_s: speeds.get(lease.worker.as_str()).copied().unwrap_or(0.0),
            worker: lease.worker,
            created_ms: lease.created_ms,
            runs: lease
                .runs
                .iter()
                .map(|run| {
                    let waited_for = (run.block0..run.block1)
                        .all(|block| leased.contains(&(run.frame, run.tile, block)));
                    (*run, plan.run_samples(run), waited_for)
                })
                .collect(),
        })
        .collect();
    let helper = Helper {
        worker: request.worker.instance.clone(),
        samples_per_s: request.samples_per_s,
        target_ms: app.config.lease_target_ms,
    };
    let runs = runs_to_reissue(&leases, &helper, now_ms);
    if runs.is_empty() {
        return Ok(None);
    }
    let until_ms = now_ms.saturating_add_unsigned(app.config.lease_ttl_ms);
    app.store
        .reissue(job, &runs, &helper.worker, now_ms, until_ms)
        .await
}

async fn lease(app: &App, job: JobId, claimed: Claimed) -> Result<Dispatch, StoreError> {
    app.job_changed();
    // Deleted between claim and now: the lease died with it.
    let Some(row) = app.store.job(job).await? else {
        return Ok(Dispatch::Nothing);
    };
    Ok(Dispatch::Lease(Box::new(Lease {
        id: claimed.id,
        job,
        manifest: row.manifest,
        settings: row.settings,
        runs: claimed.runs,
        heartbeat_ms: app.config.heartbeat_ms,
    })))
}
