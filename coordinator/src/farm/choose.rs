//! Which job is served next.
//!
//! Priority is strict: as long as a job of higher priority has pending units, no
//! other is served. Jobs of equal priority share the farm evenly in core time: the
//! next lease goes to the job for which least core time is under way, and among
//! those with equally much, as when one worker takes lease after lease, to the one
//! that was served longest ago.

use shearwater_shared::job::JobId;

/// A job that has not ended and is not paused, as the decision sees it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LiveJob {
    /// Number; smaller is older.
    pub id: JobId,
    /// Higher is served first.
    pub priority: i32,
    /// Units of all frames.
    pub units_total: u64,
    /// Units counted.
    pub units_done: u64,
    /// Units leased.
    pub units_leased: u64,
    /// Samples of all frames.
    pub samples_total: u64,
    /// Samples counted.
    pub samples_done: u64,
    /// Microseconds of cores that they took.
    pub core_us: u64,
    /// Number of its last lease, 0 before the first; rises with time.
    pub served: i64,
}

impl LiveJob {
    /// Units that nobody holds, whether their rows are made or not.
    #[must_use]
    pub const fn units_pending(&self) -> u64 {
        self.units_total
            .saturating_sub(self.units_done)
            .saturating_sub(self.units_leased)
    }

    /// Samples of an average unit, at least 1.
    #[must_use]
    pub fn unit_samples(&self) -> u64 {
        self.samples_total
            .checked_div(self.units_total)
            .unwrap_or(0)
            .max(1)
    }

    /// Microseconds of a core for one sample, once there is a result.
    fn sample_us(&self) -> Option<f64> {
        (self.samples_done > 0 && self.core_us > 0)
            .then(|| self.core_us as f64 / self.samples_done as f64)
    }

    /// Microseconds of cores under way, a sample of unknown cost taken as `unknown_us`.
    fn under_way_us(&self, unknown_us: f64) -> f64 {
        let samples = self.units_leased as f64 * self.unit_samples() as f64;
        samples * self.sample_us().unwrap_or(unknown_us)
    }
}

/// The jobs to try, best first; those with pending units only. More than one, since
/// what is pending may be withheld from the asking worker.
pub fn next_job(jobs: &[LiveJob]) -> impl Iterator<Item = &LiveJob> {
    let known: Vec<f64> = jobs.iter().filter_map(LiveJob::sample_us).collect();
    // As the others cost; any number, when nothing is known of any.
    let unknown_us = if known.is_empty() {
        1.0
    } else {
        known.iter().sum::<f64>() / known.len() as f64
    };
    let mut order: Vec<(f64, &LiveJob)> = jobs
        .iter()
        .filter(|job| job.units_pending() > 0)
        .map(|job| (job.under_way_us(unknown_us), job))
        .collect();
    order.sort_by(|(a_us, a), (b_us, b)| {
        (b.priority.cmp(&a.priority))
            .then(a_us.total_cmp(b_us))
            .then((a.served, a.id).cmp(&(b.served, b.id)))
    });
    order.into_iter().map(|(_, job)| job)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::VecDeque;

    fn job(id: i64, priority: i32, done: u64, leased: u64) -> LiveJob {
        LiveJob {
            id: JobId(id),
            priority,
            units_total: 10,
            units_done: done,
            units_leased: leased,
            samples_total: 1000,
            samples_done: 0,
            core_us: 0,
            served: 0,
        }
    }

    #[test]
    fn priority_then_least_under_way_then_only_with_work() {
        let jobs = [
            job(1, 0, 0, 0),
            job(2, 5, 4, 6),
            job(3, 5, 4, 5),
            job(4, 5, 0, 0),
            job(5, 5, 0, 0),
            job(6, -5, 0, 0),
        ];
        let order: Vec<i64> = next_job(&jobs).map(|job| job.id.0).collect();
        assert_eq!(order, [4, 5, 3, 1, 6]);
        assert_eq!(jobs[0].unit_samples(), 100);
    }

    #[test]
    fn equal_jobs_take_turns() {
        let mut jobs = [job(1, 0, 0, 0), job(2, 0, 0, 0), job(3, 0, 0, 0)];
        let mut order = Vec::new();
        // One worker whose lease is always back before it asks again.
        for lease in 1..=6 {
            let next = next_job(&jobs).next().expect("work").id;
            order.push(next.0);
            jobs[next.0 as usize - 1].served = lease;
        }
        assert_eq!(order, [1, 2, 3, 1, 2, 3]);
    }

    // Four workers, leases of one second of work; a unit of job n takes `seconds[n]`.
    fn core_seconds(seconds: &[f64], from: &[usize], leases: usize) -> Vec<f64> {
        let mut jobs: Vec<LiveJob> = Vec::new();
        let mut under_way: VecDeque<(usize, u64)> = VecDeque::new();
        let mut spent = vec![0.0; seconds.len()];
        for lease in 0..leases {
            for (at, _) in from.iter().enumerate().filter(|(_, from)| **from == lease) {
                let mut new = job(at as i64 + 1, 0, 0, 0);
                new.units_total = 1_000_000;
                new.samples_total = 100_000_000;
                jobs.push(new);
            }
            if under_way.len() == 4
                && let Some((at, units)) = under_way.pop_front()
            {
                let done = &mut jobs[at];
                done.units_leased -= units;
                done.units_done += units;
                done.samples_done += units * 100;
                done.core_us += (units as f64 * seconds[at] * 1e6) as u64;
                spent[at] += units as f64 * seconds[at];
            }
            let at = next_job(&jobs).next().expect("work").id.0 as usize - 1;
            let units = (1.0 / seconds[at]).max(1.0) as u64;
            jobs[at].units_leased += units;
            jobs[at].served = lease as i64;
            under_way.push_back((at, units));
        }
        spent
    }

    #[test]
    fn core_time_is_shared_evenly_whatever_a_unit_costs() {
        let spent = core_seconds(&[0.01, 1.0], &[0, 0], 2000);
        assert!((spent[0] / spent[1] - 1.0).abs() < 0.05, "{spent:?}");
        let spent = core_seconds(&[0.1, 0.1, 0.1], &[0, 0, 0], 3000);
        for one in &spent {
            assert!((one / spent[0] - 1.0).abs() < 0.05, "{spent:?}");
        }
    }

    #[test]
    fn who_comes_later_shares_from_then_on() {
        let spent = core_seconds(&[0.1, 0.1], &[0, 1000], 2000);
        // All of the first half and half of the second, not all until it has caught up.
        assert!((spent[0] / spent[1] - 3.0).abs() < 0.1, "{spent:?}");
    }
}
