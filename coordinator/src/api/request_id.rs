//! A name for every request, by which its lines are found in the logs of all who had to do
//! with it.

use axum::http::{HeaderMap, HeaderName, HeaderValue};
use std::hash::{BuildHasher, RandomState};
use std::sync::atomic::{AtomicU64, Ordering};

/// The header that brings a name in and takes it out.
pub(super) const X_REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");
/// Longest name that is taken over: that of every usual generator, and no story.
const ID_BYTES_MAX: usize = 64;
/// What tokens begin with: one that was sent in the wrong header must not be logged.
const TOKEN: &str = "sw_";

/// Makes names that no other process makes.
#[derive(Debug)]
pub(super) struct RequestIds {
    process: u32,
    serial: AtomicU64,
}

impl RequestIds {
    /// For this process.
    pub(super) fn new() -> Self {
        Self {
            // Seeded by the system.
            process: RandomState::new().hash_one(std::process::id()) as u32,
            serial: AtomicU64::new(0),
        }
    }

    /// The name that a request brought, if it is one; otherwise a new one.
    pub(super) fn of(&self, headers: &HeaderMap) -> String {
        let given = headers
            .get(X_REQUEST_ID)
            .and_then(|value| value.to_str().ok());
        match given {
            Some(id) if is_sane(id) => id.to_owned(),
            _ => {
                let serial = self.serial.fetch_add(1, Ordering::Relaxed);
                format!("{:08x}-{serial:x}", self.process)
            }
        }
    }
}

/// As it goes out again.
pub(super) fn header(id: &str) -> Option<HeaderValue> {
    HeaderValue::from_str(id).ok()
}

fn is_sane(id: &str) -> bool {
    (1..=ID_BYTES_MAX).contains(&id.len())
        && !id.starts_with(TOKEN)
        && id
            .bytes()
            .all(|b| b.is_ascii_alphanumeric() || b"-_.:".contains(&b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sane_names_are_taken_over_and_all_others_replaced() {
        let ids = RequestIds::new();
        let of = |id: &str| {
            let value = HeaderValue::from_str(id).expect("value");
            ids.of(&HeaderMap::from_iter([(X_REQUEST_ID, value)]))
        };
        let longest = "a".repeat(ID_BYTES_MAX);
        for id in [
            "7",
            "0af7651916cd43dd8448eb211c80319c",
            "a-b_c.d:e",
            &longest,
        ] {
            assert_eq!(of(id), id);
        }
        let long = "a".repeat(ID_BYTES_MAX + 1);
        for id in ["", "two words", "a\"b", "{}", "sw_01234567_0", &long] {
            assert_ne!(of(id), id);
        }
        assert_ne!(ids.of(&HeaderMap::new()), ids.of(&HeaderMap::new()));
    }
}
