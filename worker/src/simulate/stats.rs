//! What the simulated workers saw, counted together.

use super::histogram::Histogram;
use super::units::Units;
use crate::traffic::{Traffic, TrafficSum};
use shearwater_shared::plan::{Plan, Run};
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Seconds of which the counted units are kept one by one: a week, 2.4 MB. What
/// comes later counts for the last one.
const SECONDS_MAX: usize = 7 * 86_400;

/// Counters; every unit counts where it is named.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Workers that were answered at least once, those that came instead of others
    /// left out.
    pub connected: u64,
    /// Leases given.
    pub leases: u64,
    /// Units given for the first time.
    pub units_given: u64,
    /// Units given again: audits, expired and failed ones, the endgame.
    pub units_given_again: u64,
    /// Results acknowledged, duplicates included.
    pub results: u64,
    /// Of these, results that were counted before.
    pub duplicates: u64,
    /// Units acknowledged as counted.
    pub units_counted: u64,
    /// Units acknowledged as counted more than once. Not zero is a fault, unless the
    /// coordinator withdrew results.
    pub units_counted_twice: u64,
    /// Results that the coordinator refused.
    pub refused: u64,
    /// Failures reported.
    pub failures: u64,
    /// Workers that vanished without a word.
    pub vanished: u64,
    /// Runs dropped since nobody waited for them any more.
    pub dropped: u64,
    /// Requests for work refused by quarantine.
    pub quarantined: u64,
    /// Leases of other jobs, handed back.
    pub foreign: u64,
}

/// What was seen up to one moment.
#[derive(Clone, Debug)]
pub struct Seen {
    /// Counters.
    pub counts: Counts,
    /// From the first asking to having work, retries and empty answers included:
    /// leases that came while there were units that nobody had been given yet.
    pub lease_waits: Histogram,
    /// Waits that began while there were such units and lasted until there were
    /// none any more, up to that moment.
    pub lease_waits_cut: Histogram,
    /// From the first sending of a result to its acknowledgement, retries included.
    pub result_waits: Histogram,
    /// Units counted in each second since the start.
    pub units_of_second: Vec<u32>,
    /// When every unit had been given once, since the start.
    pub all_given: Option<Duration>,
    /// When the last unit was counted, since the start.
    pub last_counted: Duration,
    /// Bytes and failures of calls.
    pub traffic: TrafficSum,
}

/// Shared by all workers of a simulation.
#[derive(Debug)]
pub struct Stats {
    started: Instant,
    pub(super) traffic: Arc<Traffic>,
    inner: Mutex<Inner>,
}

#[derive(Debug)]
struct Inner {
    seen: Seen,
    refusal: Option<String>,
    given: Units,
    counted: Units,
    /// Units that a worker failed on: none fails twice, so that no job fails.
    failed: BTreeSet<(u32, u32, u32)>,
}

impl Stats {
    pub(super) fn new(plan: &Plan, frames: u32) -> Self {
        Self {
            started: Instant::now(),
            traffic: Arc::default(),
            inner: Mutex::new(Inner {
                seen: Seen {
                    counts: Counts::default(),
                    lease_waits: Histogram::default(),
                    lease_waits_cut: Histogram::default(),
                    result_waits: Histogram::default(),
                    units_of_second: Vec::new(),
                    all_given: None,
                    last_counted: Duration::ZERO,
                    traffic: TrafficSum::default(),
                },
                refusal: None,
                given: Units::none(plan, frames),
                counted: Units::none(plan, frames),
                failed: BTreeSet::new(),
            }),
        }
    }

    fn inner(&self) -> MutexGuard<'_, Inner> {
        // Nothing that holds the lock can panic half-way through a change.
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What was seen so far.
    #[must_use]
    pub fn seen(&self) -> Seen {
        let mut seen = self.inner().seen.clone();
        seen.traffic = self.traffic.sum();
        seen
    }

    /// When the simulation began.
    #[must_use]
    pub const fn started(&self) -> Instant {
        self.started
    }

    /// Why a worker gave up, if one did: the coordinator's words.
    #[must_use]
    pub fn refusal(&self) -> Option<String> {
        self.inner().refusal.clone()
    }

    /// Change the counters.
    pub(super) fn count(&self, change: impl FnOnce(&mut Counts)) {
        change(&mut self.inner().seen.counts);
    }

    /// A worker was given `runs` after it had asked at `asked`.
    pub(super) fn given(&self, runs: &[Run], asked: Instant) {
        let now = Instant::now();
        let inner = &mut *self.inner();
        let left = !inner.given.is_full();
        let fresh = runs.iter().map(|run| inner.given.insert(run)).sum::<u64>();
        let units = runs.iter().map(|run| u64::from(run.block1 - run.block0));
        let seen = &mut inner.seen;
        seen.counts.leases += 1;
        seen.counts.units_given += fresh;
        seen.counts.units_given_again += units.sum::<u64>().saturating_sub(fresh);
        if left {
            seen.lease_waits.record(now - asked);
        }
        if left && inner.given.is_full() {
            seen.all_given = Some(now - self.started);
        }
        if !left {
            self.cut_short(seen, asked);
        }
    }

    /// A worker that asked at `asked` ends without work.
    pub(super) fn left_waiting(&self, asked: Instant) {
        let inner = &mut *self.inner();
        if inner.given.is_full() {
            self.cut_short(&mut inner.seen, asked);
        } else {
            inner.seen.lease_waits_cut.record(asked.elapsed());
        }
    }

    fn cut_short(&self, seen: &mut Seen, asked: Instant) {
        let Some(all_given) = seen.all_given else {
            return;
        };
        let asked = asked.saturating_duration_since(self.started);
        if let Some(wait) = all_given.checked_sub(asked) {
            seen.lease_waits_cut.record(wait);
        }
    }

    /// The result of `run` was acknowledged after `wait`.
    pub(super) fn acknowledged(&self, run: &Run, duplicate: bool, wait: Duration) {
        let at = self.started.elapsed();
        let inner = &mut *self.inner();
        let seen = &mut inner.seen;
        seen.result_waits.record(wait);
        seen.counts.results += 1;
        if duplicate {
            seen.counts.duplicates += 1;
            return;
        }
        let units = u64::from(run.block1 - run.block0);
        let fresh = inner.counted.insert(run);
        seen.counts.units_counted += fresh;
        seen.counts.units_counted_twice += units - fresh;
        seen.last_counted = at;
        let second = (at.as_secs() as usize).min(SECONDS_MAX - 1);
        if seen.units_of_second.len() <= second {
            seen.units_of_second.resize(second + 1, 0);
        }
        if let Some(count) = seen.units_of_second.get_mut(second) {
            *count = count.saturating_add(u32::try_from(fresh).unwrap_or(u32::MAX));
        }
    }

    /// Whether a worker may fail on this run: no unit of it has failed before.
    pub(super) fn may_fail(&self, run: &Run) -> bool {
        let inner = &mut *self.inner();
        let units = || (run.block0..run.block1).map(|block| (run.frame, run.tile, block));
        let first = units().all(|unit| !inner.failed.contains(&unit));
        inner.failed.extend(units().filter(|_| first));
        first
    }

    /// The coordinator wants nothing to do with a worker.
    pub(super) fn refused(&self, why: String) {
        self.inner().refusal.get_or_insert(why);
    }
}

impl Seen {
    /// Units a second over the worst and the best window of `window` seconds between
    /// the seconds `from` and `to`; `None` when there is no whole window.
    #[must_use]
    pub fn rates(&self, window: usize, from: usize, to: usize) -> Option<(f64, f64)> {
        let seconds = self
            .units_of_second
            .get(from..to.min(self.units_of_second.len()))?;
        let sums = seconds
            .windows(window.max(1))
            .map(|w| w.iter().map(|&n| u64::from(n)).sum::<u64>());
        let (least, most) = sums.fold((u64::MAX, 0), |(least, most), sum| {
            (least.min(sum), most.max(sum))
        });
        let rate = |sum| sum as f64 / window.max(1) as f64;
        (least <= most).then(|| (rate(least), rate(most)))
    }
}
