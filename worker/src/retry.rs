//! Calls that are repeated until somebody answers.

use crate::client::CallError;
use crate::phase::{Phase, PhaseRx, sleep_unless};
use crate::random;
use shearwater_shared::api::Problem;
use std::time::Duration;

/// First pause: a restarting coordinator is back within a second or so.
const FIRST: Duration = Duration::from_millis(100);
/// Longest pause: a farm finds a coordinator again within this time.
const LONGEST: Duration = Duration::from_secs(5);
/// Doublings until [`LONGEST`] is surely exceeded.
const DOUBLINGS: u32 = 6;

/// How a repeated call ended without success.
#[derive(Debug)]
pub(crate) enum Ended {
    /// The coordinator said no.
    Refused(Problem),
    /// The worker's end came first.
    Stopped,
}

/// The pause before try number `tries + 1`: doubled each time, a random half
/// of it, so that a farm does not return in one wave.
pub(crate) fn pause(tries: u32) -> Duration {
    let whole = FIRST.saturating_mul(1 << tries.min(DOUBLINGS)).min(LONGEST);
    let share = (random::bits() >> 40) as f64 / (1u64 << 24) as f64;
    whole.mul_f64(0.5 + 0.5 * share)
}

/// Repeat `call` until it is answered or the worker reaches `end`.
pub(crate) async fn until_answered<T, F>(
    phase: &PhaseRx,
    end: Phase,
    what: &str,
    call: impl Fn() -> F,
) -> Result<T, Ended>
where
    F: Future<Output = Result<T, CallError>>,
{
    let mut tries = 0;
    loop {
        match call().await {
            Ok(answer) => {
                if tries > 0 {
                    tracing::info!(what, tries, "coordinator answers again");
                }
                return Ok(answer);
            }
            Err(CallError::Refused(problem)) => return Err(Ended::Refused(problem)),
            Err(CallError::Unavailable(why) | CallError::Damaged(why)) => {
                if tries == 0 {
                    tracing::warn!(what, why, "coordinator does not answer; trying again");
                } else {
                    tracing::debug!(what, why, tries, "still no answer");
                }
            }
        }
        if !sleep_unless(phase, end, pause(tries)).await {
            return Err(Ended::Stopped);
        }
        tries = tries.saturating_add(1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_grow_and_stay_bounded() {
        for tries in 0..100 {
            let whole = FIRST.saturating_mul(1 << tries.min(DOUBLINGS)).min(LONGEST);
            let pause = pause(tries);
            assert!(pause >= whole / 2 && pause <= whole, "{tries}: {pause:?}");
        }
    }
}
