//! Heartbeats that came at the same time are heard together.

use crate::app::{App, now_ms};
use crate::gather::Gathered;
use crate::store::{Beat, StoreError};
use std::collections::BTreeSet;
use std::sync::Arc;

/// Heartbeats of one batch; each names a lease or two.
const BATCH_MAX: usize = 256;

/// Of the leases of a heartbeat, those that are wanted.
pub(crate) type Answer = Result<BTreeSet<i64>, StoreError>;

/// Hear heartbeats until there are none.
pub(crate) async fn hear_all(app: Arc<App>, mut beats: Gathered<Vec<Beat>, Answer>) {
    while let Some(batch) = beats.batch(BATCH_MAX).await {
        let all: Vec<Beat> = batch.iter().flat_map(|asked| asked.item.clone()).collect();
        let until_ms = now_ms().saturating_add_unsigned(app.lease_ttl_ms());
        match app.store.hear(&all, until_ms).await {
            Ok(wanted) => {
                for asked in batch {
                    let own = asked.item.iter().map(|beat| beat.lease);
                    let own = own.filter(|id| wanted.contains(id)).collect();
                    let _ = asked.answer.send(Ok(own));
                }
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
}
