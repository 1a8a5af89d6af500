//! What a coordinator does unasked: expiry, folding, finishing, sweeping.

use crate::app::{App, now_ms};
use crate::farm::QUARANTINE_MS;
use crate::fold;
use crate::objects::{FILMS, PARTS};
use crate::webhook;
use futures_util::StreamExt;
use std::sync::Arc;
use std::time::Duration;
use tokio::task::JoinHandle;

/// How often leases are looked through.
const REAP_EVERY: Duration = Duration::from_secs(1);
/// Longest wait of the folder when it is not woken: results that another
/// coordinator took.
const FOLD_EVERY: Duration = Duration::from_secs(1);
/// Pause after an error, so that a broken disk does not fill the log.
const ERROR_PAUSE: Duration = Duration::from_secs(2);
/// How often old rows and nameless objects are looked for.
const SWEEP_EVERY: Duration = Duration::from_secs(3600);

/// Start every background task; each ends when the coordinator stops.
pub(crate) fn start(app: &Arc<App>) -> Vec<JoinHandle<()>> {
    vec![
        tokio::spawn(reap(Arc::clone(app))),
        tokio::spawn(fold_all(Arc::clone(app))),
        tokio::spawn(sweep(Arc::clone(app))),
        tokio::spawn(webhook::tell_all(Arc::clone(app))),
    ]
}

async fn reap(app: Arc<App>) {
    loop {
        tokio::time::sleep(REAP_EVERY).await;
        let now_ms = now_ms();
        let lease_ms = now_ms.saturating_add_unsigned(app.config.lease_ttl_ms);
        let cut = app
            .store
            .cut_future_times(now_ms, lease_ms, now_ms.saturating_add(QUARANTINE_MS))
            .await;
        if let Err(error) = cut {
            tracing::error!(%error, "reaper");
        }
        match app.store.expire(now_ms).await {
            Ok(0) => {}
            Ok(ended) => {
                tracing::info!(ended, "leases expired");
                app.work_came();
            }
            Err(error) => tracing::error!(%error, "reaper"),
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
    loop {
        changes.borrow_and_update();
        match fold::pass(&app).await {
            Ok(0) => {
                // A closed channel means that the coordinator is gone.
                let wait = tokio::time::timeout(FOLD_EVERY, changes.changed()).await;
                if matches!(wait, Ok(Err(_))) {
                    return;
                }
            }
            Ok(_) => {}
            Err(error) => {
                tracing::error!(%error, "folding");
                tokio::time::sleep(ERROR_PAUSE).await;
            }
        }
    }
}

async fn sweep(app: Arc<App>) {
    loop {
        if let Err(error) = app.store.purge(now_ms()).await {
            tracing::error!(%error, "purge");
        }
        for prefix in [PARTS, FILMS] {
            sweep_prefix(&app, prefix).await;
        }
        tokio::time::sleep(SWEEP_EVERY).await;
    }
}

/// Remove objects that no row names and that are older than the grace time: a
/// crash between object and row, or between row and removal.
pub(crate) async fn sweep_prefix(app: &App, prefix: &str) {
    let before_ms = now_ms().saturating_sub_unsigned(app.config.orphan_grace_ms);
    let mut objects = app.objects.list(prefix);
    let mut removed = 0u64;
    while let Some(object) = objects.next().await {
        let name = match object {
            Ok(object) if object.last_modified.timestamp_millis() < before_ms => {
                object.location.to_string()
            }
            Ok(_) => continue,
            Err(error) => {
                tracing::warn!(%error, "sweep");
                continue;
            }
        };
        match app.store.names_object(&name).await {
            Ok(true) => {}
            Ok(false) => match app.objects.delete(&name).await {
                Ok(()) => removed += 1,
                Err(error) => tracing::warn!(%error, "sweep"),
            },
            Err(error) => {
                tracing::error!(%error, "sweep");
                return;
            }
        }
    }
    if removed > 0 {
        tracing::info!(removed, prefix, "removed objects that nobody names");
    }
}

/// Remove every object of a deleted job.
pub(crate) async fn remove_job_objects(app: Arc<App>, job: shearwater_shared::job::JobId) {
    for prefix in [PARTS, FILMS] {
        let mut objects = app.objects.list(&format!("{prefix}/{job}"));
        while let Some(object) = objects.next().await {
            let removal = match object {
                Ok(object) => app.objects.delete(object.location.as_ref()).await,
                Err(error) => Err(error),
            };
            if let Err(error) = removal {
                tracing::warn!(%error, %job, "object of a deleted job stays until the sweep");
            }
        }
    }
}
