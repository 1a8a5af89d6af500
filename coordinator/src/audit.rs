//! The audit's part of what a coordinator does unasked: it gives up audits that nobody
//! can do, and takes back what a worker delivered that is not believed any more.

use crate::app::{App, now_ms};
use crate::farm::audit_waits;
use crate::store::{HoldingAudit, StoreError, WorkerRow};
use shearwater_shared::job::JobId;
use shearwater_shared::plan::Run;
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// A worker can be asked when it was heard of within this time: it asks for work more
/// often ([`shearwater_shared::limits::LEASE_WAIT_MS_MAX`]).
const PRESENT: Duration = Duration::from_secs(30);
/// How often workers are looked at while audits wait: a farm may have thousands.
const LOOK_EVERY: Duration = Duration::from_secs(1);
/// Tiles that one round takes back; the next round follows at once.
const TILES_PER_ROUND: u32 = 64;
/// Rounds of one pass; the next pass is a second later.
const ROUNDS_MAX: u32 = 64;

/// What this process has seen of waiting audits and of workers, by its own steady clock:
/// the clocks of other coordinators may be wrong, and so may its own. Bounded by the rows
/// that it mirrors.
#[derive(Debug, Default)]
pub(crate) struct Watch {
    audits: BTreeMap<(JobId, Run), SeenAudit>,
    /// When the time at which a worker was last heard of changed.
    workers: BTreeMap<String, (i64, Instant)>,
    looked: Option<Instant>,
}

#[derive(Clone, Copy, Debug)]
struct SeenAudit {
    changed_ms: i64,
    /// Since when it has been so.
    so: Instant,
    /// Since when it is known.
    known: Instant,
}

impl Watch {
    fn see_audits(&mut self, holding: &mut [HoldingAudit], now: Instant) {
        let mut seen = BTreeMap::new();
        let ms = |since| {
            let ms = now.saturating_duration_since(since).as_millis();
            i64::try_from(ms).unwrap_or(i64::MAX)
        };
        for audit in holding {
            let key = (audit.job, audit.run);
            let changed_ms = audit.changed_ms;
            let before = self.audits.get(&key);
            let known = before.map_or(now, |before| before.known);
            let so = match before {
                Some(before) if before.changed_ms == changed_ms => before.so,
                _ => now,
            };
            (audit.waiting.held_ms, audit.waiting.waited_ms) = (ms(known), ms(so));
            let audit = SeenAudit {
                changed_ms,
                so,
                known,
            };
            seen.insert(key, audit);
        }
        self.audits = seen;
    }

    fn see_workers(&mut self, workers: &[WorkerRow], now: Instant) {
        let known = std::mem::take(&mut self.workers);
        let seen = workers.iter().map(|worker| {
            let since = match known.get(&worker.instance) {
                Some(&(seen_ms, since)) if seen_ms == worker.seen_ms => since,
                _ => now,
            };
            (worker.instance.clone(), (worker.seen_ms, since))
        });
        self.workers = seen.collect();
        self.looked = Some(now);
    }

    /// Workers that are there: heard of lately, or never looked at before.
    fn present(&self, now: Instant) -> Vec<&str> {
        let lately = |since: Instant| now.saturating_duration_since(since) < PRESENT;
        let workers = self.workers.iter();
        workers
            .filter(|(_, (_, since))| lately(*since))
            .map(|(instance, _)| instance.as_str())
            .collect()
    }
}

/// Give up the audits that frames need not wait for; how many.
pub(crate) async fn give_up(app: &App, watch: &mut Watch) -> Result<usize, StoreError> {
    let mut holding = app.store.holding_audits().await?;
    let (now, now_ms) = (Instant::now(), now_ms());
    watch.see_audits(&mut holding, now);
    if holding.is_empty() {
        return Ok(0);
    }
    let is_due = |looked| now.saturating_duration_since(looked) >= LOOK_EVERY;
    if watch.looked.is_none_or(is_due) {
        let mut workers = app.store.workers(i64::MIN).await?;
        workers.retain(|worker| !worker.distrusted && worker.quarantined_until_ms <= now_ms);
        watch.see_workers(&workers, now);
    }
    let present = watch.present(now);
    let mut given_up = 0;
    for audit in holding {
        if audit_waits(&audit.waiting, &present) {
            continue;
        }
        if audit.waiting.claimants.len() > 1 {
            let (run, workers) = (audit.run, &audit.waiting.claimants);
            tracing::error!(
                job = audit.job.0,
                ?run,
                ?workers,
                "ALARM: these workers disagree and no other could be asked; the first result stays"
            );
        }
        let skipped = app.store.skip_audit(audit.job, &audit.run, now_ms).await?;
        given_up += usize::from(skipped);
    }
    Ok(given_up)
}

/// Take back what is in live jobs of workers that are not believed any more; how many
/// units. May be cut off anywhere: what is left is found by the next pass.
pub(crate) async fn withdraw(app: &App) -> Result<u64, StoreError> {
    for (lease, worker) in app.store.distrusted_leases().await? {
        app.store.release(&worker, lease, now_ms()).await?;
    }
    let mut units = 0;
    for _ in 0..ROUNDS_MAX {
        let tiles = app.store.tiles_to_withdraw(TILES_PER_ROUND).await?;
        if tiles.is_empty() {
            break;
        }
        for at in tiles {
            let Some(job) = app.store.job(at.job).await? else {
                continue;
            };
            let withdrawn = if job.settings.stop.error.is_some() {
                app.store.withdraw_frame(&job, at.frame, now_ms()).await?
            } else {
                app.store.withdraw_tile(&job, &at, now_ms()).await?
            };
            units += withdrawn.units;
            for name in &withdrawn.objects {
                if let Err(error) = app.objects.delete(name).await {
                    tracing::warn!(%error, "object stays until the sweep");
                }
            }
            let units = withdrawn.units;
            tracing::warn!(
                job = at.job.0,
                frame = at.frame,
                tile = at.tile,
                units,
                "results of a wrong worker are rendered again"
            );
        }
    }
    if units > 0 {
        app.work_came();
    }
    Ok(units)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heard(instance: &str, seen_ms: i64) -> WorkerRow {
        WorkerRow {
            instance: instance.to_owned(),
            name: instance.to_owned(),
            threads: 1,
            milli_samples_per_s: 0,
            seen_ms,
            distrusted: false,
            quarantined_until_ms: 0,
            quarantine_reason: None,
        }
    }

    // Times in rows are by other clocks, a day off in both directions.
    #[test]
    fn presence_is_by_what_changes_and_not_by_clocks() {
        let start = Instant::now();
        let at = |seconds| start + Duration::from_secs(seconds);
        let mut watch = Watch::default();
        watch.see_workers(&[heard("dead", 5), heard("alive", -86_400_000)], start);
        assert_eq!(watch.present(at(29)), ["alive", "dead"]);
        watch.see_workers(&[heard("dead", 5), heard("alive", -86_390_000)], at(25));
        assert_eq!(watch.present(at(31)), ["alive"]);
        watch.see_workers(&[heard("alive", -86_390_000)], at(56));
        assert!(watch.present(at(56)).is_empty());
        assert_eq!(watch.workers.len(), 1);
    }
}
