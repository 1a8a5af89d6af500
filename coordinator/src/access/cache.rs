//! Tokens as the store had them a moment ago.

use crate::store::{Store, StoreError, TokenRow};
use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How long a row is taken for granted: a revoked token ends within this time on
/// every coordinator.
const FRESH: Duration = Duration::from_secs(5);
/// Rows in memory, about 300 bytes each; more than a store may have.
const ENTRIES_MAX: usize = 16_384;

#[derive(Clone, Debug)]
struct Entry {
    /// `None`: the store has no such token.
    row: Option<Arc<TokenRow>>,
    read: Instant,
}

/// The tokens of a store.
#[derive(Debug)]
pub(crate) struct Tokens {
    store: Store,
    entries: Mutex<HashMap<String, Entry>>,
    /// The store has had a token: it always will have.
    any: AtomicBool,
    none_since: Mutex<Option<Instant>>,
    /// One question at a time: a thousand requests with one token ask once.
    asking: tokio::sync::Mutex<()>,
}

impl Tokens {
    /// The tokens of `store`.
    pub(crate) fn new(store: Store) -> Self {
        Self {
            store,
            entries: Mutex::default(),
            any: AtomicBool::new(false),
            none_since: Mutex::default(),
            asking: tokio::sync::Mutex::default(),
        }
    }

    /// Whether the store ever had a token. A first one counts within [`FRESH`].
    pub(crate) async fn any(&self) -> Result<bool, StoreError> {
        let known = || {
            let none = *self
                .none_since
                .lock()
                .unwrap_or_else(PoisonError::into_inner);
            let none = none.is_some_and(|since| since.elapsed() < FRESH);
            self.any
                .load(Ordering::Relaxed)
                .then_some(true)
                .or(none.then_some(false))
        };
        if let Some(any) = known() {
            return Ok(any);
        }
        let _asking = self.asking.lock().await;
        if let Some(any) = known() {
            return Ok(any);
        }
        let asked = Instant::now();
        let any = self.store.has_token().await?;
        self.any.fetch_or(any, Ordering::Relaxed);
        *self
            .none_since
            .lock()
            .unwrap_or_else(PoisonError::into_inner) = Some(asked);
        Ok(any)
    }

    /// What is known of a token without a question; `None` when that is nothing,
    /// or too old.
    pub(crate) fn known(&self, id: &str) -> Option<Option<Arc<TokenRow>>> {
        let entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        let entry = entries.get(id)?;
        (entry.read.elapsed() < FRESH).then(|| entry.row.clone())
    }

    /// The row of a token.
    pub(crate) async fn find(&self, id: &str) -> Result<Option<Arc<TokenRow>>, StoreError> {
        if let Some(row) = self.known(id) {
            return Ok(row);
        }
        let _asking = self.asking.lock().await;
        if let Some(row) = self.known(id) {
            return Ok(row);
        }
        // Before the question: what is revoked meanwhile is not kept longer.
        let read = Instant::now();
        let row = self.store.token(id).await?.map(Arc::new);
        let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        if entries.len() >= ENTRIES_MAX {
            entries.retain(|_, entry| entry.read.elapsed() < FRESH);
        }
        if entries.len() < ENTRIES_MAX {
            let row = row.clone();
            entries.insert(id.to_owned(), Entry { row, read });
        }
        Ok(row)
    }
}
