//! The audit's part of what a coordinator does unasked: it gives up audits that nobody
//! can do, and takes back what a worker delivered that is not believed any more.

use crate::app::{App, now_ms};
use crate::farm::audit_waits;
use crate::store::StoreError;

/// A worker can be asked when it was heard of within this time: it asks for work more
/// often ([`shearwater_shared::limits::LEASE_WAIT_MS_MAX`]).
const PRESENT_MS: i64 = 30_000;
/// Tiles that one round takes back; the next round follows at once.
const TILES_PER_ROUND: u32 = 64;
/// Rounds of one pass; the next pass is a second later.
const ROUNDS_MAX: u32 = 64;

/// Give up the audits that frames need not wait for; how many.
pub(crate) async fn give_up(app: &App) -> Result<usize, StoreError> {
    let now_ms = now_ms();
    let holding = app.store.holding_audits(now_ms).await?;
    if holding.is_empty() {
        return Ok(0);
    }
    let workers = app.store.workers(now_ms - PRESENT_MS).await?;
    let present: Vec<&str> = workers
        .iter()
        .filter(|worker| !worker.distrusted && worker.quarantined_until_ms <= now_ms)
        .map(|worker| worker.instance.as_str())
        .collect();
    let mut given_up = 0;
    for audit in holding {
        if audit_waits(&audit.waiting, &present, now_ms) {
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
