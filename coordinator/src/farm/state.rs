//! Where a job stands, derived from its counts.

use shearwater_shared::job::JobState;

/// The counts that decide a job's state.
#[derive(Clone, Copy, Debug, Default)]
pub struct JobCounts {
    /// Stopped by a user.
    pub cancelled: bool,
    /// Stopped for a reason.
    pub failed: bool,
    /// Halted by a user.
    pub paused: bool,
    /// Frames of the job.
    pub frames: u64,
    /// Frames whose film is final.
    pub frames_done: u64,
    /// Units counted.
    pub units_done: u64,
    /// Units leased.
    pub units_leased: u64,
}

/// The state of a job. Only cancellation, failure and a pause are stored; nothing here
/// can be stranded by a crash.
#[must_use]
pub const fn job_state(counts: &JobCounts) -> JobState {
    if counts.cancelled {
        JobState::Cancelled
    } else if counts.failed {
        JobState::Failed
    } else if counts.frames_done >= counts.frames {
        JobState::Done
    } else if counts.paused {
        JobState::Paused
    } else if counts.units_done > 0 || counts.units_leased > 0 {
        JobState::Running
    } else {
        JobState::Queued
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_state_is_reached() {
        let queued = JobCounts {
            frames: 2,
            ..JobCounts::default()
        };
        assert_eq!(job_state(&queued), JobState::Queued);
        let leased = JobCounts {
            units_leased: 1,
            ..queued
        };
        assert_eq!(job_state(&leased), JobState::Running);
        let counted = JobCounts {
            units_done: 9,
            frames_done: 1,
            ..queued
        };
        assert_eq!(job_state(&counted), JobState::Running);
        let done = JobCounts {
            frames_done: 2,
            ..counted
        };
        assert_eq!(job_state(&done), JobState::Done);
        let paused = JobCounts {
            paused: true,
            ..counted
        };
        assert_eq!(job_state(&paused), JobState::Paused);
        let late = JobCounts {
            paused: true,
            ..done
        };
        assert_eq!(job_state(&late), JobState::Done, "what was leased came");
        let cancelled = JobCounts {
            cancelled: true,
            ..leased
        };
        assert_eq!(job_state(&cancelled), JobState::Cancelled);
        let failed = JobCounts {
            failed: true,
            ..leased
        };
        assert_eq!(job_state(&failed), JobState::Failed);
    }
}
