//! What nobody needs any more goes: old rows, nameless objects, unused assets.
//!
//! Every step may be cut off and done again, by any coordinator or by
//! `shearwater gc` beside them.

use crate::objects::{ASSETS, FILMS, ObjectError, Objects, PARTS, PROBES};
use crate::store::{Store, StoreError};
use futures_util::StreamExt;
use shearwater_shared::hash::ContentHash;
use shearwater_shared::job::JobId;

/// How old things must be.
#[derive(Clone, Copy, Debug)]
pub struct Grace {
    /// Objects that no row names, in milliseconds: longer than any upload lasts.
    pub orphan_ms: u64,
    /// Assets that no job needs, in milliseconds since their last use.
    pub asset_ms: u64,
}

/// What a sweep removed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Swept {
    /// Deleted jobs of which nothing is left now.
    pub jobs: u64,
    /// Parts that no row named.
    pub parts: u64,
    /// Films that no row named.
    pub films: u64,
    /// Assets that no job needed.
    pub assets: u64,
    /// Files of writers that were killed, and empty folders.
    pub leavings: u64,
}

/// A sweep was cut off; what it had removed is gone.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// The database failed.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The object store failed.
    #[error(transparent)]
    Objects(#[from] ObjectError),
}

/// One sweep of everything.
///
/// # Errors
/// Database or object store failed.
pub async fn sweep(
    store: &Store,
    objects: &Objects,
    grace: Grace,
    now_ms: i64,
) -> Result<Swept, SweepError> {
    store.purge(now_ms).await?;
    // These first: on a full disk they make room for what follows.
    let jobs = finish_deletions(store, objects).await?;
    let asset_ms = now_ms.saturating_sub_unsigned(grace.asset_ms);
    let unused = unused_assets(store, objects, asset_ms, now_ms).await?;
    let orphan_ms = objects.clock_ms().await?;
    let orphan_ms = orphan_ms.saturating_sub_unsigned(grace.orphan_ms);
    Ok(Swept {
        jobs,
        parts: nameless(store, objects, PARTS, orphan_ms).await?,
        films: nameless(store, objects, FILMS, orphan_ms).await?,
        assets: unused + nameless_assets(store, objects, orphan_ms).await?,
        leavings: probes(objects, orphan_ms).await? + objects.remove_leavings(orphan_ms).await?,
    })
}

/// Remove what is left of deleted jobs; how many are gone now.
///
/// # Errors
/// Database or object store failed.
pub async fn finish_deletions(store: &Store, objects: &Objects) -> Result<u64, SweepError> {
    let mut gone = 0;
    loop {
        let jobs = store.deletions().await?;
        if jobs.is_empty() {
            return Ok(gone);
        }
        for job in jobs {
            finish_deletion(store, objects, job).await?;
            gone += 1;
        }
    }
}

async fn finish_deletion(store: &Store, objects: &Objects, job: JobId) -> Result<(), SweepError> {
    // Small steps: results of other jobs come in between.
    while store.delete_some(job).await? > 0 {
        tokio::task::yield_now().await;
    }
    for prefix in [PARTS, FILMS] {
        let mut found = objects.list(&format!("{prefix}/{job}"));
        while let Some(object) = found.next().await {
            objects.delete(object?.location.as_ref()).await?;
        }
    }
    store.deletion_done(job).await?;
    tracing::info!(job = job.0, "nothing is left of the deleted job");
    Ok(())
}

/// Remove objects that no row names and that are older than `before_ms`: a crash
/// between object and row, or between row and removal.
async fn nameless(
    store: &Store,
    objects: &Objects,
    prefix: &str,
    before_ms: i64,
) -> Result<u64, SweepError> {
    let mut found = objects.list(prefix);
    let mut removed = 0;
    while let Some(object) = found.next().await {
        let object = object?;
        let name = object.location.as_ref();
        if object.last_modified.timestamp_millis() < before_ms && !store.names_object(name).await? {
            objects.delete(name).await?;
            removed += 1;
        }
    }
    Ok(removed)
}

/// Remove assets that no job needs and nobody has used since `before_ms`.
async fn unused_assets(
    store: &Store,
    objects: &Objects,
    before_ms: i64,
    now_ms: i64,
) -> Result<u64, SweepError> {
    while store.note_old_manifests(now_ms).await? > 0 {}
    let mut removed = 0;
    loop {
        let doomed = store.doom_assets(before_ms).await?;
        if doomed.is_empty() {
            return Ok(removed);
        }
        for hash in doomed {
            objects.delete(&Objects::asset_name(&hash)).await?;
            store.forget_asset(&hash).await?;
            removed += 1;
        }
    }
}

/// Remove assets whose upload was cut off between object and row.
async fn nameless_assets(
    store: &Store,
    objects: &Objects,
    before_ms: i64,
) -> Result<u64, SweepError> {
    let mut found = objects.list(ASSETS);
    let mut removed = 0;
    while let Some(object) = found.next().await {
        let object = object?;
        let hash = object
            .location
            .filename()
            .and_then(|name| name.parse().ok());
        let hash: ContentHash = match hash {
            Some(hash) if object.last_modified.timestamp_millis() < before_ms => hash,
            _ => continue,
        };
        if store.doom_nameless(&hash).await? {
            objects.delete(&Objects::asset_name(&hash)).await?;
            store.forget_asset(&hash).await?;
            removed += 1;
        }
    }
    Ok(removed)
}

/// Remove what tries at writing have left behind.
async fn probes(objects: &Objects, before_ms: i64) -> Result<u64, SweepError> {
    let mut found = objects.list(PROBES);
    let mut removed = 0;
    while let Some(object) = found.next().await {
        let object = object?;
        if object.last_modified.timestamp_millis() < before_ms {
            objects.delete(object.location.as_ref()).await?;
            removed += 1;
        }
    }
    Ok(removed)
}
