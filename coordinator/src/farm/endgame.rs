//! The end of a job: what to hand out once more when nothing is pending.

use shearwater_shared::limits::LEASE_RUNS_MAX;
use shearwater_shared::plan::Run;
use std::collections::BTreeMap;

/// Workers that may render one run at the same time.
const HOLDERS_MAX: usize = 2;
/// A lease is overdue when it takes this much longer than its worker's speed
/// says, plus [`OVERDUE_MS`]: speeds vary by the cost of tiles.
const OVERDUE_FACTOR: f64 = 1.5;
/// See [`OVERDUE_FACTOR`]; also what a helper must be able to win, so that
/// nothing is rendered twice for a moment's gain.
const OVERDUE_MS: f64 = 1000.0;

/// A lease that is waited for.
#[derive(Clone, Debug)]
pub struct OpenLease {
    /// Who holds it (instance).
    pub worker: String,
    /// When it was given.
    pub created_ms: i64,
    /// Samples per second of its worker; 0 when not known.
    pub samples_per_s: f64,
    /// All of its runs in the order of rendering: samples, and whether the run
    /// is still waited for.
    pub runs: Vec<(Run, u64, bool)>,
}

/// The worker that asks.
#[derive(Clone, Debug)]
pub struct Helper {
    /// Instance.
    pub worker: String,
    /// Samples per second; 0 when not known.
    pub samples_per_s: f64,
    /// How long its lease may take at most.
    pub target_ms: u64,
}

/// A run with the time at which its holder should have it.
struct Candidate {
    run: Run,
    samples: u64,
    expected_ms: f64,
    overdue: bool,
}

/// The runs to hand to `helper` too: first those that are overdue, the latest
/// first; then those that the helper would have before their holder, the ones
/// expected last first. Nothing it holds itself, nothing that two hold already.
#[must_use]
pub fn runs_to_reissue(leases: &[OpenLease], helper: &Helper, now_ms: i64) -> Vec<Run> {
    let mut candidates = candidates(leases, helper, now_ms);
    candidates.sort_by(|a, b| {
        let by_time = if a.overdue && b.overdue {
            a.expected_ms.total_cmp(&b.expected_ms)
        } else {
            b.expected_ms.total_cmp(&a.expected_ms)
        };
        (b.overdue.cmp(&a.overdue))
            .then(by_time)
            .then(a.run.cmp(&b.run))
    });
    let mut taken = Vec::new();
    let mut cost_ms = 0.0;
    for candidate in candidates {
        let first = taken.is_empty();
        cost_ms += duration_ms(candidate.samples, helper.samples_per_s).unwrap_or(f64::INFINITY);
        let wins = now_ms as f64 + cost_ms + OVERDUE_MS < candidate.expected_ms;
        let in_time = cost_ms <= helper.target_ms as f64 || first;
        // A helper of unknown speed may try one run that is overdue.
        let worth = wins || (candidate.overdue && (first || cost_ms.is_finite()));
        if !(worth && in_time) || taken.len() == LEASE_RUNS_MAX {
            break;
        }
        taken.push(candidate.run);
    }
    taken
}

fn candidates(leases: &[OpenLease], helper: &Helper, now_ms: i64) -> Vec<Candidate> {
    let mut holders: BTreeMap<Run, Vec<&str>> = BTreeMap::new();
    for lease in leases {
        for (run, _, _) in &lease.runs {
            holders.entry(*run).or_default().push(&lease.worker);
        }
    }
    let free = |run: &Run| {
        holders.get(run).is_none_or(|holders| {
            holders.len() < HOLDERS_MAX && holders.iter().all(|&holder| holder != helper.worker)
        })
    };
    let mut found = Vec::new();
    for lease in leases {
        let (start, mut samples_before) = (lease.created_ms as f64, 0u64);
        for (run, samples, waited_for) in &lease.runs {
            samples_before = samples_before.saturating_add(*samples);
            if !waited_for || !free(run) {
                continue;
            }
            let duration =
                duration_ms(samples_before, lease.samples_per_s).unwrap_or(helper.target_ms as f64);
            found.push(Candidate {
                run: *run,
                samples: *samples,
                expected_ms: start + duration,
                overdue: now_ms as f64 > start + duration * OVERDUE_FACTOR + OVERDUE_MS,
            });
        }
    }
    found
}

fn duration_ms(samples: u64, samples_per_s: f64) -> Option<f64> {
    (samples_per_s.is_finite() && samples_per_s > 0.0)
        .then(|| samples as f64 * 1000.0 / samples_per_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(tile: u32) -> Run {
        Run {
            frame: 0,
            tile,
            block0: 0,
            block1: 1,
        }
    }

    fn lease(worker: &str, samples_per_s: f64, tiles: std::ops::Range<u32>) -> OpenLease {
        OpenLease {
            worker: worker.to_owned(),
            created_ms: 0,
            samples_per_s,
            runs: tiles.map(|tile| (run(tile), 1000, true)).collect(),
        }
    }

    fn helper(samples_per_s: f64) -> Helper {
        Helper {
            worker: "helper".into(),
            samples_per_s,
            target_ms: 10_000,
        }
    }

    #[test]
    fn takes_the_runs_its_holder_reaches_last() {
        // The holder needs 1 s per run: run 9 is expected at 10 s. The helper
        // is as fast; at 2 s it can have 9 at 3 s, 8 at 4 s, 7 at 5 s, not 5.
        let leases = [lease("slow", 1000.0, 0..10)];
        let runs = runs_to_reissue(&leases, &helper(1000.0), 2000);
        assert_eq!(runs, [run(9), run(8), run(7)]);
        assert_eq!(runs_to_reissue(&leases, &helper(1.0), 2000), []);
    }

    #[test]
    fn overdue_runs_come_first_whoever_asks() {
        let mut busy = lease("busy", 1000.0, 10..40);
        busy.created_ms = 19_000;
        let leases = [lease("dead", 1000.0, 0..2), busy];
        let runs = runs_to_reissue(&leases, &helper(1000.0), 20_000);
        assert_eq!(runs[..2], [run(0), run(1)]);
        assert_eq!(runs_to_reissue(&leases, &helper(0.0), 20_000), [run(0)]);
    }

    #[test]
    fn nothing_of_its_own_nothing_twice_nothing_counted() {
        let own = [lease("helper", 1000.0, 0..3)];
        assert_eq!(runs_to_reissue(&own, &helper(1000.0), 90_000), []);
        let twice = [lease("a", 1000.0, 0..1), lease("b", 1000.0, 0..1)];
        assert_eq!(runs_to_reissue(&twice, &helper(1000.0), 90_000), []);
        let mut counted = lease("a", 1000.0, 0..2);
        counted.runs[0].2 = false;
        assert_eq!(
            runs_to_reissue(&[counted], &helper(1000.0), 90_000),
            [run(1)]
        );
    }

    #[test]
    fn a_lease_in_time_is_left_alone() {
        let leases = [lease("fine", 1000.0, 0..2)];
        assert_eq!(runs_to_reissue(&leases, &helper(1000.0), 1500), []);
        assert_eq!(runs_to_reissue(&leases, &helper(1000.0), 2500), []);
    }
}
