//! How often anybody may ask.

use super::role::Role;
use governor::clock::{Clock, DefaultClock};
use governor::{DefaultKeyedRateLimiter, Quota, RateLimiter};
use std::net::{IpAddr, Ipv6Addr};
use std::num::NonZeroU32;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

/// Requests of one worker token, a second and at once. One token may serve a
/// whole farm: 5,000 workers beat 1,700 times a second, and ask and deliver no
/// more than twice that.
const WORKER_PER_S: u32 = 10_000;
const WORKER_BURST: u32 = 20_000;
/// Requests of one client or admin token. A scene of 10,000 files uploads them
/// one after the other, each with a durable write.
const CLIENT_PER_S: u32 = 500;
const CLIENT_BURST: u32 = 5_000;
/// Requests of one address without a token that is known: each may cost a look
/// into the store. Behind one address there may be 5,000 workers with a token
/// each, of which every one is looked up every five seconds.
const ADDRESS_PER_S: u32 = 2_000;
const ADDRESS_BURST: u32 = 4_000;
/// The same from this machine, where no token may be demanded: more than a
/// coordinator answers.
const LOOPBACK_PER_S: u32 = 50_000;
const LOOPBACK_BURST: u32 = 100_000;
/// Checks between two looks for keys that are idle.
const CLEAN_EVERY: u32 = 10_000;
/// Keys of one kind that may be kept though idle, about 100 bytes each.
const KEYS_MAX: usize = 20_000;

/// Who is counted.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum Key {
    /// A token that the store knows.
    Token(String),
    /// An address; of IPv6 the network, since a host has as many addresses as it
    /// likes.
    Address(IpAddr),
}

/// The rates of one coordinator; each counts for itself.
#[derive(Debug)]
pub(crate) struct Rates {
    workers: DefaultKeyedRateLimiter<Key>,
    clients: DefaultKeyedRateLimiter<Key>,
    addresses: DefaultKeyedRateLimiter<Key>,
    loopback: DefaultKeyedRateLimiter<Key>,
    checks: AtomicU32,
    clock: DefaultClock,
}

/// Come back later.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TooSoon(pub(super) Duration);

impl Default for Rates {
    fn default() -> Self {
        let limiter = |per_s, burst| RateLimiter::keyed(quota(per_s, burst));
        Self {
            workers: limiter(WORKER_PER_S, WORKER_BURST),
            clients: limiter(CLIENT_PER_S, CLIENT_BURST),
            addresses: limiter(ADDRESS_PER_S, ADDRESS_BURST),
            loopback: limiter(LOOPBACK_PER_S, LOOPBACK_BURST),
            checks: AtomicU32::new(0),
            clock: DefaultClock::default(),
        }
    }
}

fn quota(per_s: u32, burst: u32) -> Quota {
    let at_least_one = |n| NonZeroU32::new(n).unwrap_or(NonZeroU32::MIN);
    Quota::per_second(at_least_one(per_s)).allow_burst(at_least_one(burst))
}

impl Rates {
    /// Count a request of a token that the store knows.
    pub(super) fn token(&self, id: &str, role: Role) -> Result<(), TooSoon> {
        let limiter = match role {
            Role::Worker => &self.workers,
            Role::Client | Role::Admin => &self.clients,
        };
        self.count(limiter, &Key::Token(id.to_owned()))
    }

    /// Count a request from an address.
    pub(super) fn address(&self, address: IpAddr) -> Result<(), TooSoon> {
        let address = address.to_canonical();
        let limiter = if address.is_loopback() {
            &self.loopback
        } else {
            &self.addresses
        };
        self.count(limiter, &Key::Address(network(address)))
    }

    fn count(&self, limiter: &DefaultKeyedRateLimiter<Key>, key: &Key) -> Result<(), TooSoon> {
        if self
            .checks
            .fetch_add(1, Ordering::Relaxed)
            .is_multiple_of(CLEAN_EVERY)
        {
            self.clean();
        }
        let soon = limiter.check_key(key).err();
        soon.map_or(Ok(()), |soon| {
            Err(TooSoon(soon.wait_time_from(self.clock.now())))
        })
    }

    /// Forget who has been idle for so long that it makes no difference.
    fn clean(&self) {
        for limiter in [
            &self.workers,
            &self.clients,
            &self.addresses,
            &self.loopback,
        ] {
            if limiter.len() > KEYS_MAX {
                limiter.retain_recent();
                limiter.shrink_to_fit();
            }
        }
    }
}

/// What one customer of a network usually has: an IPv4 address, an IPv6 network
/// of 64 bits.
fn network(address: IpAddr) -> IpAddr {
    match address {
        IpAddr::V4(_) => address,
        IpAddr::V6(address) => {
            let [a, b, c, d, ..] = address.segments();
            IpAddr::V6(Ipv6Addr::new(a, b, c, d, 0, 0, 0, 0))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Requests that pass, of `tries` at once.
    fn passed(tries: u32, check: impl Fn(u32) -> Result<(), TooSoon>) -> u32 {
        (0..tries).filter(|&n| check(n).is_ok()).count() as u32
    }

    fn ip(text: &str) -> IpAddr {
        text.parse().expect("address")
    }

    #[test]
    fn each_is_counted_for_itself() {
        let rates = Rates::default();
        let tries = 2 * CLIENT_BURST;
        let client = passed(tries, |_| rates.token("a", Role::Client));
        assert!((CLIENT_BURST..tries).contains(&client), "{client}");
        assert!(rates.token("b", Role::Client).is_ok());
        let soon = rates.token("a", Role::Client).expect_err("spent");
        assert!(soon.0 <= Duration::from_secs(1), "{soon:?}");
        // A farm's whole protocol through one token.
        assert_eq!(passed(tries, |_| rates.token("a", Role::Worker)), tries);
    }

    #[test]
    fn a_network_is_one_and_this_machine_is_hardly_limited() {
        let rates = Rates::default();
        let tries = 3 * ADDRESS_BURST;
        let host = |n: u32| IpAddr::V6(Ipv6Addr::from((0x2001_0db8_u128 << 96) + u128::from(n)));
        let remote = passed(tries, |n| rates.address(host(n)));
        assert!((ADDRESS_BURST..tries).contains(&remote), "{remote}");
        assert!(rates.address(ip("2001:db9::1")).is_ok());
        assert!(rates.address(ip("192.0.2.1")).is_ok());
        for local in ["127.0.0.1", "::1", "::ffff:127.0.0.1"] {
            assert_eq!(
                passed(tries, |_| rates.address(ip(local))),
                tries,
                "{local}"
            );
        }
    }

    #[test]
    fn idle_keys_are_forgotten() {
        let rates = Rates::default();
        let keys = 2 * KEYS_MAX as u32;
        for n in 0..keys {
            let _ = rates.address(IpAddr::V4(n.into()));
        }
        std::thread::sleep(Duration::from_millis(20));
        rates.clean();
        assert!(
            rates.addresses.len() < KEYS_MAX,
            "{}",
            rates.addresses.len()
        );
    }
}
