//! What a worker needs to know before it starts.

use crate::connection::Access;
use std::time::Duration;

/// Memory that fetched assets may take, in bytes: ten times the assets of a
/// common scene, and small beside a built one.
const ASSET_CACHE_BYTES: u64 = 256 << 20;
/// Time that a leaving worker gives its last runs and uploads: a few units.
const SHUTDOWN_GRACE: Duration = Duration::from_secs(10);

/// Settings of one worker process. None of them changes a pixel.
#[derive(Clone, Debug)]
pub struct Config {
    /// Where the coordinator listens, `http://host:port` or `https://host:port`.
    pub coordinator_url: String,
    /// With what right, and whom to trust.
    pub access: Access,
    /// Name for people, at most
    /// [`NAME_BYTES_MAX`](shearwater_shared::limits::NAME_BYTES_MAX) bytes.
    pub name: String,
    /// Threads that render, at least 1.
    pub threads: usize,
    /// Memory that fetched assets may take, in bytes; one larger asset is used
    /// and not kept.
    pub asset_cache_bytes: u64,
    /// Take the traversal without AVX2 even where the machine has it. The bits
    /// are the same; tests say so.
    pub portable_simd: bool,
    /// End when the coordinator has this worker in quarantine, instead of
    /// waiting for its end: for whoever has no other worker.
    pub leave_when_quarantined: bool,
    /// How long a worker that is told to stop waits for its last results to be
    /// acknowledged before it hands its leases back.
    pub shutdown_grace: Duration,
}

impl Config {
    /// The defaults: one thread per core that this process may use.
    #[must_use]
    pub fn new(coordinator_url: impl Into<String>, name: impl Into<String>) -> Self {
        Self {
            coordinator_url: coordinator_url.into(),
            access: Access::default(),
            name: name.into(),
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            asset_cache_bytes: ASSET_CACHE_BYTES,
            portable_simd: false,
            leave_when_quarantined: false,
            shutdown_grace: SHUTDOWN_GRACE,
        }
    }
}
