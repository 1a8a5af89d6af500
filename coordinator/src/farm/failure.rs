//! When to give up a unit, a worker, a job.

use shearwater_shared::limits::BAD_SAMPLE_SHARE_MAX;

/// Different workers that may fail on a unit before the job does.
const POISON_WORKERS: u64 = 3;
/// Failures of one unit before the job fails, when there are too few workers to
/// ask: twice as many, since one worker may just be unwell.
const POISON_TIMES: u64 = 6;
/// Different units in a row that a worker may fail on before it gets no more.
const QUARANTINE_STREAK: u64 = 3;
/// Bad samples that any job may have, however small it is: a single one says
/// little about a preview of half a million samples.
const BAD_SAMPLES_BORNE: u64 = 16;
/// How long a worker gets nothing: long enough for someone to look, short
/// enough that a repaired machine comes back by itself.
pub const QUARANTINE_MS: i64 = 10 * 60 * 1000;

/// Failures of the unit of a run that fared worst.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UnitFailures {
    /// Different workers that failed on it.
    pub workers: u64,
    /// Failures in all.
    pub times: u64,
}

/// Different runs that a worker failed on since its last counted result.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WorkerStreak(pub u64);

/// Whether nobody can render this unit, so that its job fails.
#[must_use]
pub const fn unit_is_poison(failures: UnitFailures) -> bool {
    failures.workers >= POISON_WORKERS || failures.times >= POISON_TIMES
}

/// Whether the worker itself seems to be at fault.
#[must_use]
pub const fn should_quarantine(streak: WorkerStreak) -> bool {
    streak.0 >= QUARANTINE_STREAK
}

/// Whether so many samples of one frame were no light that the picture is
/// worthless. The share is of all samples that the frame will have: the verdict
/// does not depend on the order in which results come, nor on how many frames
/// its job has.
#[must_use]
pub fn too_many_bad(bad_samples: u64, frame_samples: u64) -> bool {
    bad_samples > BAD_SAMPLES_BORNE
        && bad_samples as f64 > frame_samples as f64 * BAD_SAMPLE_SHARE_MAX
}

/// What is said of a job with [`too_many_bad`] samples in `frame` (the scene's
/// number).
#[must_use]
pub fn bad_samples_reason(frame: u32, bad_samples: u64, frame_samples: u64) -> String {
    format!(
        "{bad_samples} of {frame_samples} samples of frame {frame} are no light (NaN, infinite, negative or too \
         large): the scene or the tracer is at fault; the coordinator's log names the first ones"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_workers_or_six_tries_poison_a_unit() {
        let failures = |workers, times| UnitFailures { workers, times };
        assert!(!unit_is_poison(failures(2, 5)));
        assert!(unit_is_poison(failures(3, 3)));
        assert!(unit_is_poison(failures(1, 6)));
        assert!(!should_quarantine(WorkerStreak(2)));
        assert!(should_quarantine(WorkerStreak(3)));
    }

    #[test]
    fn one_bad_sample_in_a_million_is_borne_and_sixteen_always() {
        assert!(!too_many_bad(0, 0));
        assert!(!too_many_bad(16, 1));
        assert!(too_many_bad(17, 16_999_999));
        assert!(!too_many_bad(17, 17_000_000));
        assert!(too_many_bad(18, 17_999_999));
    }
}
