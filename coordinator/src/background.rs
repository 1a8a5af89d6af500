//! What a coordinator does unasked: expiry, folding, finishing, sweeping.

use crate::app::{App, Lines, now_ms};
use crate::audit;
use crate::beats;
use crate::counting;
use crate::dispatch;
use crate::farm::QUARANTINE_MS;
use crate::fold;
use crate::presence;
use crate::sweep::{Grace, Swept, finish_deletions, sweep};
use crate::trouble;
use crate::webhook;
use std::sync::Arc;
use std::time::Duration;
use tokio::task::JoinHandle;

/// How often the presence of workers is written and read.
const KNOW_EVERY: Duration = Duration::from_secs(1);
/// How often leases are looked through.
const REAP_EVERY: Duration = Duration::from_secs(1);
/// Longest wait of the folder when it is not woken: results that another
/// coordinator took.
const FOLD_EVERY: Duration = Duration::from_secs(1);
/// Between two passes of the folder: each looks through what waits, and results come
/// faster than that is worth. Short beside anything a person waits for.
const FOLD_PAUSE: Duration = Duration::from_millis(30);
/// Pause after an error, so that a broken disk does not fill the log.
const ERROR_PAUSE: Duration = Duration::from_secs(2);
/// How often the rest of jobs is looked for that another coordinator deleted.
const DELETIONS_EVERY: Duration = Duration::from_secs(60);
/// How often old rows and nameless objects are looked for.
const SWEEP_EVERY: Duration = Duration::from_secs(3600);

/// Start every background task; each ends when the coordinator stops.
pub(crate) fn start(app: &Arc<App>, lines: Lines) -> Vec<JoinHandle<()>> {
    vec![
        tokio::spawn(dispatch::answer_all(Arc::clone(app), lines.questions)),
        tokio::spawn(counting::count_all(Arc::clone(app), lines.results)),
        tokio::spawn(beats::hear_all(Arc::clone(app), lines.beats)),
        tokio::spawn(presence::welcome_all(Arc::clone(app), lines.newcomers)),
        tokio::spawn(know_workers(Arc::clone(app))),
        tokio::spawn(reap(Arc::clone(app))),
        tokio::spawn(fold_all(Arc::clone(app))),
        tokio::spawn(sweep_all(Arc::clone(app))),
        tokio::spawn(finish_all_deletions(Arc::clone(app))),
        tokio::spawn(trouble::watch(Arc::clone(app))),
        tokio::spawn(webhook::tell_all(Arc::clone(app))),
    ]
}

async fn know_workers(app: Arc<App>) {
    loop {
        tokio::time::sleep(KNOW_EVERY).await;
        if app.troubles.database_is_away() {
            continue;
        }
        if let Err(error) = app.presence.refresh(&app.store, now_ms()).await {
            tracing::error!(%error, "presence of workers");
            app.troubles.suspect();
        }
    }
}

async fn reap(app: Arc<App>) {
    loop {
        tokio::time::sleep(REAP_EVERY).await;
        // Nothing expires before everybody could be heard again.
        if app.troubles.database_is_away() {
            continue;
        }
        let now_ms = now_ms();
        let lease_ms = now_ms.saturating_add_unsigned(app.lease_ttl_ms());
        let cut = app
            .store
            .cut_future_times(now_ms, lease_ms, now_ms.saturating_add(QUARANTINE_MS))
            .await;
        if let Err(error) = cut {
            tracing::error!(%error, "reaper");
            app.troubles.suspect();
            continue;
        }
        match app.store.expire(now_ms).await {
            Ok(0) => {}
            Ok(ended) => {
                app.metrics.leases.expired.inc_by(ended as u64);
                tracing::info!(ended, "leases expired");
                app.work_came();
            }
            Err(error) => tracing::error!(%error, "reaper"),
        }
        if let Err(error) = audit::withdraw(&app).await {
            tracing::error!(%error, "withdrawal of wrong results");
        }
        match app.store.withhold_all(now_ms).await {
            Ok(0) => {}
            Ok(units) => {
                tracing::info!(units, "time is up");
                app.job_changed();
            }
            Err(error) => tracing::error!(%error, "time stop"),
        }
    }
}

async fn fold_all(app: Arc<App>) {
    let mut changes = app.change.subscribe();
    let mut watch = audit::Watch::default();
    loop {
        changes.borrow_and_update();
        match fold::pass(&app, &mut watch).await {
            Ok(done) => {
                if done == 0 {
                    // A closed channel means that the coordinator is gone.
                    let wait = tokio::time::timeout(FOLD_EVERY, changes.changed()).await;
                    if matches!(wait, Ok(Err(_))) {
                        return;
                    }
                }
                tokio::time::sleep(FOLD_PAUSE).await;
            }
            Err(error) => {
                tracing::error!(%error, "folding");
                app.troubles.suspect();
                tokio::time::sleep(ERROR_PAUSE).await;
            }
        }
    }
}

async fn sweep_all(app: Arc<App>) {
    loop {
        let grace = Grace {
            orphan_ms: app.config.orphan_grace_ms,
            asset_ms: app.config.asset_grace_ms,
        };
        match sweep(&app.store, &app.objects, grace, now_ms()).await {
            Ok(swept) if swept == Swept::default() => {}
            Ok(swept) => tracing::info!(?swept, "removed what nobody needs"),
            Err(error) => tracing::warn!(%error, "sweep"),
        }
        tokio::time::sleep(SWEEP_EVERY).await;
    }
}

async fn finish_all_deletions(app: Arc<App>) {
    loop {
        if let Err(error) = finish_deletions(&app.store, &app.objects).await {
            tracing::warn!(%error, "rest of a deleted job");
            tokio::time::sleep(ERROR_PAUSE).await;
            continue;
        }
        // Those of another coordinator, too, should that one be gone.
        let _ = tokio::time::timeout(DELETIONS_EVERY, app.deleted.notified()).await;
    }
}
