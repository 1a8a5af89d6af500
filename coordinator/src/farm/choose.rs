//! Which job is served next.

use shearwater_shared::job::JobId;

/// A job that has not ended, as the decision sees it.
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
}

/// The jobs to try, best first: by priority, then the oldest; those with
/// pending units only. More than one, since what is pending may be withheld
/// from the asking worker.
pub fn next_job(jobs: &[LiveJob]) -> impl Iterator<Item = &LiveJob> {
    let mut order: Vec<&LiveJob> = jobs.iter().filter(|job| job.units_pending() > 0).collect();
    order.sort_by_key(|job| (std::cmp::Reverse(job.priority), job.id));
    order.into_iter()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn job(id: i64, priority: i32, done: u64, leased: u64) -> LiveJob {
        LiveJob {
            id: JobId(id),
            priority,
            units_total: 10,
            units_done: done,
            units_leased: leased,
            samples_total: 1000,
        }
    }

    #[test]
    fn priority_then_age_then_only_with_work() {
        let jobs = [
            job(1, 0, 0, 0),
            job(2, 5, 4, 6),
            job(3, 5, 4, 5),
            job(4, 5, 0, 0),
        ];
        let order: Vec<i64> = next_job(&jobs).map(|job| job.id.0).collect();
        assert_eq!(order, [3, 4, 1]);
        assert_eq!(jobs[0].unit_samples(), 100);
    }
}
