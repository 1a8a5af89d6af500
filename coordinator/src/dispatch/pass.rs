//! One batch of questions is answered.

use super::snapshot::Snapshot;
use super::{Dispatch, Question, Waiting, endgame};
use crate::app::{App, now_ms};
use crate::farm::{
    LiveJob, QUARANTINE_MS, Sizing, Wish, cut_runs, frame_deadline_ms, lease_target_ms,
    lease_units, next_job,
};
use crate::presence::Present;
use crate::store::{ClaimQuery, Claimed, JobRow, StoreError, WorkerRow};
use shearwater_shared::api::Lease;
use shearwater_shared::job::JobId;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Answer whom there is something for; the others are returned, to wait.
pub(super) async fn pass(app: &App, snapshot: &mut Snapshot, batch: Vec<Waiting>) -> Vec<Waiting> {
    // A result that cannot be stored had better not be begun.
    if app.troubles.work_pauses() {
        return batch;
    }
    let mut waiting = batch;
    match serve(app, snapshot, &mut waiting).await {
        Ok(()) => waiting,
        Err(error) => {
            snapshot.forget();
            let error = Arc::new(error);
            for asked in waiting {
                let shared = StoreError::Shared(Arc::clone(&error));
                let _ = asked.answer.send(Err(shared));
            }
            Vec::new()
        }
    }
}

async fn serve(
    app: &App,
    snapshot: &mut Snapshot,
    waiting: &mut Vec<Waiting>,
) -> Result<(), StoreError> {
    let now_ms = now_ms();
    let present = app.presence.present();
    refuse(waiting, &present, now_ms);
    snapshot.renew(app).await?;
    serve_audits(app, snapshot, waiting, now_ms).await?;
    serve_units(app, snapshot, &present, waiting, now_ms).await?;
    endgame::help(app, snapshot, &present, waiting, now_ms).await
}

/// Samples per second of a worker that asks; 0 when not known.
pub(super) fn speed_of(question: &Question) -> f64 {
    question.request.samples_per_s
}

/// Until when a worker gets nothing.
fn refused_until_ms(worker: &WorkerRow, now_ms: i64) -> Option<i64> {
    // As long as it runs; it may ask again as one in quarantine may.
    let until_ms = if worker.distrusted {
        now_ms.saturating_add(QUARANTINE_MS)
    } else {
        worker.quarantined_until_ms
    };
    (until_ms > now_ms).then_some(until_ms)
}

fn refuse(waiting: &mut Vec<Waiting>, present: &Present, now_ms: i64) {
    let mut heard = Vec::with_capacity(waiting.len());
    for asked in waiting.drain(..) {
        let row = present.get(&asked.item.request.worker.instance);
        let refused = row.and_then(|row| Some((row, refused_until_ms(row, now_ms)?)));
        let Some((row, until_ms)) = refused else {
            heard.push(asked);
            continue;
        };
        let reason = row.quarantine_reason.clone().unwrap_or_default();
        let _ = asked
            .answer
            .send(Ok(Dispatch::Quarantined(until_ms, reason)));
    }
    *waiting = heard;
}

/// Runs to be compared go first: the end of their frames waits for them.
async fn serve_audits(
    app: &App,
    snapshot: &mut Snapshot,
    waiting: &mut Vec<Waiting>,
    now_ms: i64,
) -> Result<(), StoreError> {
    let until_ms = now_ms.saturating_add_unsigned(app.lease_ttl_ms());
    let mut at = 0;
    while snapshot.audits > 0
        && let Some(asked) = waiting.get(at)
    {
        let request = &asked.item.request;
        let claimed = app
            .store
            .lease_audits(&request.worker.instance, &request.build, now_ms, until_ms)
            .await?;
        if let Some((job, claimed)) = claimed {
            app.metrics.leases.audit.inc();
            snapshot.audits = snapshot.audits.saturating_sub(claimed.runs.len() as u64);
            let served = waiting.remove(at);
            answer_lease(app, served, job, claimed).await?;
        } else {
            // Its own: others may have them.
            at += 1;
        }
    }
    Ok(())
}

/// The others who are there, as the size of a lease sees them.
struct Others {
    count: u64,
    samples_per_s: f64,
}

fn all_workers(present: &Present, now_ms: i64) -> Others {
    let working = present
        .values()
        .filter(|worker| refused_until_ms(worker, now_ms).is_none());
    let mut all = Others {
        count: 0,
        samples_per_s: 0.0,
    };
    for worker in working {
        all.count += 1;
        all.samples_per_s += worker.milli_samples_per_s as f64 / 1000.0;
    }
    all
}

/// Who is to get what.
struct Assigned {
    job: JobId,
    units: u64,
}

/// Pending units, job by job, until nobody who waits can be served.
async fn serve_units(
    app: &App,
    snapshot: &mut Snapshot,
    present: &Present,
    waiting: &mut Vec<Waiting>,
    now_ms: i64,
) -> Result<(), StoreError> {
    let all = all_workers(present, now_ms);
    // What is pending may be withheld from a worker: it is tried with the next job.
    let mut tried: BTreeSet<(String, JobId)> = BTreeSet::new();
    while !waiting.is_empty() {
        let mut by_job: BTreeMap<JobId, Vec<(usize, u64)>> = BTreeMap::new();
        for (at, asked) in waiting.iter().enumerate() {
            let assigned = assign(app, snapshot, present, &all, &tried, &asked.item, now_ms);
            if let Some(assigned) = assigned.await? {
                let wishes = by_job.entry(assigned.job).or_default();
                wishes.push((at, assigned.units));
            }
        }
        if by_job.is_empty() {
            return Ok(());
        }
        let mut claims: BTreeMap<usize, (JobId, Claimed)> = BTreeMap::new();
        for (job, wishes) in by_job {
            let claimed = claim(app, &all, job, waiting, &wishes, now_ms).await?;
            for ((at, units), claimed) in wishes.into_iter().zip(claimed) {
                let got = claimed.as_ref().map_or(0, |claimed| {
                    let blocks = claimed.runs.iter().map(|run| run.block1 - run.block0);
                    u64::from(blocks.sum::<u32>())
                });
                note_leased(snapshot, job, units, got);
                if let Some(claimed) = claimed {
                    claims.insert(at, (job, claimed));
                } else if let Some(asked) = waiting.get(at) {
                    tried.insert((asked.item.request.worker.instance.clone(), job));
                }
            }
        }
        let mut left = Vec::new();
        for (at, asked) in waiting.drain(..).enumerate() {
            match claims.remove(&at) {
                Some((job, claimed)) => {
                    app.metrics.leases.fresh.inc();
                    answer_lease(app, asked, job, claimed).await?;
                }
                None => left.push(asked),
            }
        }
        *waiting = left;
    }
    Ok(())
}

/// A worker got `got` units of a job instead of the `assigned` ones.
fn note_leased(snapshot: &mut Snapshot, job: JobId, assigned: u64, got: u64) {
    if let Some(live) = snapshot.jobs.iter_mut().find(|live| live.id == job) {
        live.units_leased = live.units_leased.saturating_sub(assigned) + got;
    }
}

/// The best job for a worker and how many units of it; they are noted as leased.
async fn assign(
    app: &App,
    snapshot: &mut Snapshot,
    present: &Present,
    all: &Others,
    tried: &BTreeSet<(String, JobId)>,
    question: &Question,
    now_ms: i64,
) -> Result<Option<Assigned>, StoreError> {
    let request = &question.request;
    let instance = &request.worker.instance;
    let best = next_job(&snapshot.jobs).find(|job| !tried.contains(&(instance.clone(), job.id)));
    let Some(best) = best.cloned() else {
        return Ok(None);
    };
    let Some(row) = app.known.job(&app.store, best.id).await? else {
        snapshot.jobs.retain(|job| job.id != best.id);
        return Ok(None);
    };
    let own = present.get(instance);
    let own_speed = own.map_or(0.0, |own| own.milli_samples_per_s as f64 / 1000.0);
    let units = lease_units(&Sizing {
        target_ms: target_ms(app, &row, now_ms),
        unit_samples: best.unit_samples(),
        samples_per_s: request.samples_per_s,
        threads: request.threads,
        pending: best.units_pending(),
        others: all.count.saturating_sub(u64::from(own.is_some())),
        others_samples_per_s: (all.samples_per_s - own_speed).max(0.0),
    });
    note_assigned(&mut snapshot.jobs, &best, units);
    Ok(Some(Assigned {
        job: best.id,
        units,
    }))
}

/// The next who asks finds it leased, and another job with a longer wait before it.
fn note_assigned(jobs: &mut [LiveJob], best: &LiveJob, units: u64) {
    let latest = jobs.iter().map(|job| job.served).max().unwrap_or(0);
    if let Some(job) = jobs.iter_mut().find(|job| job.id == best.id) {
        job.units_leased += units;
        job.served = latest + 1;
    }
}

async fn claim(
    app: &App,
    all: &Others,
    job: JobId,
    waiting: &[Waiting],
    wishes: &[(usize, u64)],
    now_ms: i64,
) -> Result<Vec<Option<Claimed>>, StoreError> {
    let Some(row) = app.known.job(&app.store, job).await? else {
        return Ok(vec![None; wishes.len()]);
    };
    let of_wish = |&(at, units): &(usize, u64)| {
        let request = &waiting.get(at)?.item.request;
        Some(Wish {
            worker: request.worker.instance.clone(),
            units_max: usize::try_from(units).unwrap_or(usize::MAX),
            threads: request.threads,
        })
    };
    let query = ClaimQuery {
        job,
        wishes: wishes.iter().filter_map(of_wish).collect(),
        present: if all.count > 1 { all.count } else { 0 },
        timed: row.settings.stop.seconds.is_some(),
    };
    let plan = row.plan();
    let until_ms = now_ms.saturating_add_unsigned(app.lease_ttl_ms());
    app.store
        .claim(
            &query,
            |share, wish| cut_runs(share, &plan, wish.threads),
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

/// Give a worker its lease. If it went away meanwhile, others need not wait for it.
pub(super) async fn answer_lease(
    app: &App,
    asked: Waiting,
    job: JobId,
    claimed: Claimed,
) -> Result<(), StoreError> {
    app.job_changed();
    let instance = asked.item.request.worker.instance.clone();
    let known = app.known.job(&app.store, job).await?;
    // The runs are cut by the settings of now.
    let row = match known {
        Some(row) if row.extended == claimed.extended => Some(row),
        _ => app.known.job_now(&app.store, job).await?,
    };
    let Some(row) = row else {
        // Deleted between claim and now: the lease died with it.
        let _ = asked.answer.send(Ok(Dispatch::Nothing));
        return Ok(());
    };
    let id = claimed.id;
    let lease = Lease {
        id,
        job,
        manifest: row.manifest.clone(),
        settings: row.settings,
        runs: claimed.runs,
        heartbeat_ms: app.heartbeat_ms(),
    };
    let answer = Ok(Dispatch::Lease(Box::new(lease)));
    if asked.answer.send(answer).is_err() && app.store.release(&instance, id, now_ms()).await? {
        app.work_came();
    }
    Ok(())
}
