//! How often workers are heard of, and how long a lease lives without.

/// Heartbeats are spread so that a farm has at most one in this time, over all its
/// workers: each costs the coordinator a fifth of a millisecond. Workers beat twice as
/// often as they are told at least.
const SPREAD_MS: u64 = 2;
/// Heartbeats that may be missed by a lease of a large farm.
const BEATS_PER_LEASE: u64 = 3;

/// Milliseconds between heartbeats, for a farm of so many workers: what is configured,
/// or longer.
#[must_use]
pub fn heartbeat_ms(configured_ms: u64, workers: usize) -> u64 {
    configured_ms.max(SPREAD_MS.saturating_mul(workers as u64))
}

/// Milliseconds that a lease lives without a heartbeat: what is configured, or as many
/// heartbeats as it may miss.
#[must_use]
pub fn lease_ttl_ms(configured_ms: u64, heartbeat_ms: u64) -> u64 {
    configured_ms.max(BEATS_PER_LEASE.saturating_mul(heartbeat_ms))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_farms_beat_slower_and_wait_longer() {
        assert_eq!(heartbeat_ms(3000, 8), 3000);
        assert_eq!(heartbeat_ms(3000, 1500), 3000);
        assert_eq!(heartbeat_ms(3000, 5000), 10_000);
        assert_eq!(lease_ttl_ms(15_000, 3000), 15_000);
        assert_eq!(lease_ttl_ms(15_000, 10_000), 30_000);
    }
}
