//! Randomness of the process: its identity and the jitter of its retries.
//! Nothing that is rendered ever sees it.

use std::hash::{BuildHasher, RandomState};

/// 64 bits that no other process has, from the standard library's hash keys.
pub(crate) fn bits() -> u64 {
    RandomState::new().hash_one(std::process::id())
}

/// A text for [`WorkerId::instance`](shearwater_shared::api::WorkerId::instance).
pub(crate) fn instance() -> String {
    let now = std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)
        .map_or(0, |since| since.as_nanos());
    let seed = [bits(), bits(), std::process::id().into()];
    let mut hasher = blake3::Hasher::new();
    hasher.update(&now.to_le_bytes());
    for word in seed {
        hasher.update(&word.to_le_bytes());
    }
    hasher.finalize().to_hex()[..32].to_owned()
}

#[cfg(test)]
mod tests {
    #[test]
    fn instances_differ() {
        assert_ne!(super::instance(), super::instance());
        assert_eq!(super::instance().len(), 32);
    }
}
