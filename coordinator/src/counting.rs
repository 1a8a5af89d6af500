//! Results that came at the same time are counted together.

use crate::app::{App, now_ms};
use crate::gather::{Asked, Gathered};
use crate::store::{CommitOutcome, PartRecord, StoreError};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Results of one transaction: it holds its job's row for some milliseconds.
const BATCH_MAX: usize = 64;

/// What became of a result.
pub(crate) type Answer = Result<CommitOutcome, StoreError>;

/// Count results until nobody delivers any.
pub(crate) async fn count_all(app: Arc<App>, mut results: Gathered<PartRecord, Answer>) {
    while let Some(batch) = results.batch(BATCH_MAX).await {
        // Of one job and one build each.
        let mut alike: BTreeMap<_, Vec<Asked<PartRecord, Answer>>> = BTreeMap::new();
        for asked in batch {
            let key = (asked.item.job, asked.item.build.clone());
            alike.entry(key).or_default().push(asked);
        }
        for batch in alike.into_values() {
            count(&app, batch).await;
        }
    }
}

async fn count(app: &Arc<App>, batch: Vec<Asked<PartRecord, Answer>>) {
    let parts: Vec<PartRecord> = batch.iter().map(|asked| asked.item.clone()).collect();
    match count_together(app, parts).await {
        Ok(counted) => {
            let (done, left): (Vec<_>, Vec<_>) = batch
                .into_iter()
                .partition(|asked| counted.contains(&asked.item));
            for asked in done {
                let _ = asked.answer.send(Ok(CommitOutcome::Counted));
            }
            one_by_one(app, left);
        }
        Err(error) => {
            let error = Arc::new(error);
            for asked in batch {
                let shared = StoreError::Shared(Arc::clone(&error));
                let _ = asked.answer.send(Err(shared));
            }
        }
    }
}

/// Those that could be counted together: all, or all that are not repetitions, or none.
async fn count_together(app: &App, parts: Vec<PartRecord>) -> Result<Vec<PartRecord>, StoreError> {
    if app.store.commit_all(&parts, now_ms()).await? {
        return Ok(parts);
    }
    let all = parts.len();
    let open = app.store.uncounted(parts).await?;
    if open.len() < all && app.store.commit_all(&open, now_ms()).await? {
        return Ok(open);
    }
    Ok(Vec::new())
}

/// Something about one of them is unusual, and the others are not to wait for it.
fn one_by_one(app: &Arc<App>, batch: Vec<Asked<PartRecord, Answer>>) {
    for asked in batch {
        let app = Arc::clone(app);
        tokio::spawn(async move {
            let outcome = app.store.commit(&asked.item, now_ms()).await;
            let _ = asked.answer.send(outcome);
        });
    }
}
