//! What becomes of a job's settings when samples are added to it.

use shearwater_shared::api::AddSamples;
use shearwater_shared::job::{RenderSettings, SettingsError};
use shearwater_shared::limits;
use shearwater_shared::plan::Plan;
use shearwater_shared::stop::{CutsError, ErrorTarget};

/// Nothing can be added in this way.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ExtendError {
    /// A total and a difference at once.
    #[error("samples: give the new total (`samples`) or what to add (`add`), not both")]
    Both,
    /// Less than what there is.
    #[error(
        "samples is {asked}: the job has {now} per pixel already, and what is rendered stays; expected more"
    )]
    Fewer {
        /// The job's samples per pixel.
        now: u32,
        /// What was asked for.
        asked: u32,
    },
    /// Nothing more than what there is.
    #[error(
        "nothing to add: the job's settings have {0} samples per pixel already; name more, or a smaller error for a job that \
         has an error target"
    )]
    Nothing(u32),
    /// A target for a job without one.
    #[error(
        "error: the job has no error target, its tiles go on together; submit it again with one, or add samples"
    )]
    NoTarget,
    /// A target that was reached before.
    #[error(
        "error is {asked}: the job stops at {now} already, and what is rendered stays; expected less"
    )]
    LargerTarget {
        /// The job's target.
        now: ErrorTarget,
        /// What was asked for.
        asked: ErrorTarget,
    },
    /// A value out of its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Too many additions at odd counts.
    #[error(
        "samples: the job was added to {max} times at counts that are no multiple of 128; it can go on no more. \
         Submit it again with all samples",
        max = limits::CUTS_MAX
    )]
    Cuts(#[from] CutsError),
    /// More units than a frame may have.
    #[error(
        "samples: {units} units of work per frame, at most {max}; fewer samples",
        max = limits::FRAME_UNITS_MAX
    )]
    Units {
        /// Units of a frame.
        units: u64,
    },
}

/// The settings of a job with settings `old` after `asked`. Every block of the old
/// plan is a block of the new one, with the same number.
///
/// # Errors
/// Nothing would be added, or too much.
pub fn extended(old: &RenderSettings, asked: &AddSamples) -> Result<RenderSettings, ExtendError> {
    let mut new = *old;
    new.samples = match (asked.samples, asked.add) {
        (Some(_), Some(_)) => return Err(ExtendError::Both),
        (Some(samples), None) => samples,
        (None, Some(add)) => old.samples.saturating_add(add),
        (None, None) => old.samples,
    };
    if new.samples < old.samples {
        return Err(ExtendError::Fewer {
            now: old.samples,
            asked: new.samples,
        });
    }
    new.stop.error = match (old.stop.error, asked.error) {
        (now, None) => now,
        (None, Some(_)) => return Err(ExtendError::NoTarget),
        (Some(now), Some(asked)) if asked > now => {
            return Err(ExtendError::LargerTarget { now, asked });
        }
        (Some(_), asked) => asked,
    };
    new.stop.seconds = asked.seconds;
    // A job that stopped by time lacks samples even of its old total.
    if new.samples == old.samples && new.stop.error == old.stop.error && old.stop.seconds.is_none()
    {
        return Err(ExtendError::Nothing(old.samples));
    }
    if new.samples > old.samples && !Plan::ends_block(old.samples / 2) {
        new.stop.cuts = old.stop.cuts.with(old.samples / 2)?;
    }
    new.validate()?;
    let units = Plan::new(&new).units_per_frame();
    if units > limits::FRAME_UNITS_MAX {
        return Err(ExtendError::Units { units });
    }
    Ok(new)
}

#[cfg(test)]
mod tests {
    use super::*;
    use shearwater_shared::stop::Stop;

    const OLD: RenderSettings = RenderSettings {
        width: 100,
        height: 100,
        samples: 128,
        seed: 0,
        frames: 1,
        first_frame: 0,
        stop: Stop::NONE,
    };

    fn to(samples: u32) -> AddSamples {
        AddSamples {
            samples: Some(samples),
            ..AddSamples::default()
        }
    }

    fn target(error: f64) -> Option<ErrorTarget> {
        ErrorTarget::new(error).ok()
    }

    #[test]
    fn totals_and_differences() {
        let new = extended(&OLD, &to(256)).expect("more");
        assert_eq!((new.samples, new.stop), (256, Stop::NONE));
        let add = AddSamples {
            add: Some(128),
            ..AddSamples::default()
        };
        assert_eq!(extended(&OLD, &add), Ok(new));
        let both = AddSamples {
            add: Some(2),
            ..to(256)
        };
        assert_eq!(extended(&OLD, &both), Err(ExtendError::Both));
        let fewer = ExtendError::Fewer {
            now: 128,
            asked: 64,
        };
        assert_eq!(extended(&OLD, &to(64)), Err(fewer));
        assert_eq!(extended(&OLD, &to(128)), Err(ExtendError::Nothing(128)));
        assert!(matches!(
            extended(&OLD, &to(129)),
            Err(ExtendError::Settings(_))
        ));
        let much = AddSamples {
            add: Some(u32::MAX),
            ..AddSamples::default()
        };
        assert!(matches!(
            extended(&OLD, &much),
            Err(ExtendError::Settings(_))
        ));
    }

    #[test]
    fn odd_counts_become_cuts() {
        let odd = RenderSettings {
            samples: 100,
            ..OLD
        };
        let new = extended(&odd, &to(256)).expect("more");
        assert_eq!(new.stop.cuts.ends(), [50]);
        let mut job = RenderSettings { samples: 2, ..OLD };
        for _ in 0..limits::CUTS_MAX {
            job = extended(&job, &to(job.samples + 2)).expect("more");
        }
        assert!(matches!(
            extended(&job, &to(job.samples + 2)),
            Err(ExtendError::Cuts(_))
        ));
    }

    #[test]
    fn targets_fall_and_time_stops_go_on() {
        let adaptive = RenderSettings {
            stop: Stop {
                error: target(0.01),
                ..Stop::NONE
            },
            ..OLD
        };
        let lower = |error| AddSamples {
            error: target(error),
            ..AddSamples::default()
        };
        let new = extended(&adaptive, &lower(0.005)).expect("less");
        assert_eq!((new.stop.error, new.samples), (target(0.005), 128));
        assert!(matches!(
            extended(&adaptive, &lower(0.02)),
            Err(ExtendError::LargerTarget { .. })
        ));
        assert_eq!(extended(&OLD, &lower(0.02)), Err(ExtendError::NoTarget));
        let timed = RenderSettings {
            stop: Stop {
                seconds: Some(9),
                ..Stop::NONE
            },
            ..OLD
        };
        assert_eq!(extended(&timed, &to(128)), Ok(OLD));
    }
}
