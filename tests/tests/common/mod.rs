//! What end-to-end tests share: real processes of the built program, a scene
//! made on the spot, and patience with an end.

#![allow(dead_code, reason = "each test binary uses its own part")]

pub(crate) mod disk;
pub(crate) mod farm;
pub(crate) mod http;
pub(crate) mod process;
pub(crate) mod relay;
pub(crate) mod scene;
pub(crate) mod stores;

use std::time::{Duration, Instant};

/// Longest that any one step may take: a minute of rendering on a machine that
/// does other things as well.
pub(crate) const PATIENCE: Duration = Duration::from_secs(240);

/// Wait until `look` finds something.
pub(crate) fn until<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let started = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(started.elapsed() < PATIENCE, "never: {what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}
