//! Fetched assets, verified and kept within a bound.

use crate::client::{CallError, Client};
use shearwater_shared::hash::ContentHash;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

#[derive(Debug)]
struct Entry {
    bytes: Arc<[u8]>,
    last_used: u64,
}

#[derive(Debug, Default)]
struct Inner {
    entries: BTreeMap<ContentHash, Entry>,
    bytes: u64,
    clock: u64,
}

/// Assets in memory, least recently used first out.
#[derive(Debug)]
pub(crate) struct AssetCache {
    inner: Mutex<Inner>,
    bytes_max: u64,
    /// What has come of an asset whose fetch broke off: one at a time, since assets
    /// are fetched one after the other.
    begun: Mutex<Option<(ContentHash, Vec<u8>)>>,
}

impl AssetCache {
    /// An empty cache of at most `bytes_max` bytes.
    pub(crate) fn new(bytes_max: u64) -> Self {
        Self {
            inner: Mutex::default(),
            bytes_max,
            begun: Mutex::default(),
        }
    }

    fn inner(&self) -> std::sync::MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn get(&self, hash: &ContentHash) -> Option<Arc<[u8]>> {
        let inner = &mut *self.inner();
        inner.clock += 1;
        let entry = inner.entries.get_mut(hash)?;
        entry.last_used = inner.clock;
        Some(entry.bytes.clone())
    }

    fn put(&self, hash: ContentHash, bytes: &Arc<[u8]>) {
        let length = bytes.len() as u64;
        if length > self.bytes_max {
            return;
        }
        let inner = &mut *self.inner();
        if inner.entries.contains_key(&hash) {
            return;
        }
        while inner.bytes + length > self.bytes_max {
            let oldest = inner.entries.iter().min_by_key(|(_, e)| e.last_used);
            let Some(oldest) = oldest.map(|(hash, _)| *hash) else {
                break;
            };
            if let Some(entry) = inner.entries.remove(&oldest) {
                inner.bytes -= entry.bytes.len() as u64;
            }
        }
        inner.clock += 1;
        let entry = Entry {
            bytes: bytes.clone(),
            last_used: inner.clock,
        };
        inner.bytes += length;
        inner.entries.insert(hash, entry);
    }

    /// What has come of `hash` before its fetch broke off; whatever else had is dropped.
    fn take_begun(&self, hash: &ContentHash) -> Vec<u8> {
        let mut begun = self.begun.lock().unwrap_or_else(PoisonError::into_inner);
        match begun.take() {
            Some((of, bytes)) if of == *hash => bytes,
            _ => Vec::new(),
        }
    }

    fn keep_begun(&self, hash: ContentHash, bytes: Vec<u8>) {
        let mut begun = self.begun.lock().unwrap_or_else(PoisonError::into_inner);
        *begun = (!bytes.is_empty()).then_some((hash, bytes));
    }

    /// The asset `hash`, from memory or from the coordinator. `size` is its
    /// length where the manifest says it; `bytes_max` bounds it in any case.
    ///
    /// A fetch that broke off goes on where it stood. A body that is not what its hash
    /// says is [`CallError::Damaged`].
    pub(crate) async fn fetch(
        &self,
        client: &Client,
        hash: &ContentHash,
        size: Option<u64>,
        bytes_max: u64,
    ) -> Result<Arc<[u8]>, CallError> {
        if let Some(bytes) = self.get(hash) {
            return Ok(bytes);
        }
        let mut bytes = self.take_begun(hash);
        let fetched = client.asset(hash, size.unwrap_or(bytes_max), &mut bytes);
        if let Err(error) = fetched.await {
            if matches!(error, CallError::Unavailable(_)) {
                self.keep_begun(*hash, bytes);
            }
            return Err(error);
        }
        if size.is_some_and(|size| size != bytes.len() as u64) || ContentHash::of(&bytes) != *hash {
            return Err(CallError::Damaged(format!(
                "asset {hash}: {} bytes that have another hash or length",
                bytes.len()
            )));
        }
        let bytes: Arc<[u8]> = bytes.into();
        self.put(*hash, &bytes);
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asset(byte: u8, length: usize) -> (ContentHash, Arc<[u8]>) {
        let bytes: Arc<[u8]> = vec![byte; length].into();
        (ContentHash::of(&bytes), bytes)
    }

    #[test]
    fn keeps_within_its_bound_and_drops_the_oldest() {
        let cache = AssetCache::new(100);
        let (a, b, c) = (asset(1, 40), asset(2, 40), asset(3, 40));
        cache.put(a.0, &a.1);
        cache.put(b.0, &b.1);
        assert!(cache.get(&a.0).is_some());
        cache.put(c.0, &c.1);
        assert!(cache.get(&a.0).is_some() && cache.get(&c.0).is_some());
        assert!(cache.get(&b.0).is_none());
        assert_eq!(cache.inner().bytes, 80);
        cache.put(c.0, &c.1);
        assert_eq!(cache.inner().bytes, 80);
        let huge = asset(4, 101);
        cache.put(huge.0, &huge.1);
        assert!(cache.get(&huge.0).is_none() && cache.get(&a.0).is_some());
    }
}
