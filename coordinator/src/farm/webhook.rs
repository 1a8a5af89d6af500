//! When the end of a job is told, and when nobody tries any more.

use shearwater_shared::api::WebhookState;

/// Longest that one try lasts, in milliseconds: a receiver that needs longer should
/// take the message first and work afterwards.
pub const TRY_MS: i64 = 10_000;
/// How long tries go on after the end, in milliseconds: a day.
pub const TRIES_MS: i64 = 24 * 3600 * 1000;
/// First and longest pause between two tries, in milliseconds.
const PAUSE_MS: (i64, i64) = (1_000, 3_600_000);

/// What is stored of telling a job's end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Told {
    /// `finished_ms` of the end that the tries were about; 0 before the first.
    pub ended_ms: i64,
    /// The receiver took it.
    pub taken: bool,
}

/// The pause after the `attempt`th try (from 1) failed, in milliseconds: it doubles
/// from a second to an hour. With [`TRIES_MS`] there are at most 36 tries.
#[must_use]
pub fn pause_ms(attempt: u32) -> i64 {
    let (first, longest) = PAUSE_MS;
    // 2^12 s is more than an hour.
    let doublings = attempt.saturating_sub(1).min(12);
    (first << doublings).min(longest)
}

/// The latest that a next try can lie ahead; what lies further is of a clock that was
/// set back.
#[must_use]
pub const fn ahead_ms_max() -> i64 {
    TRY_MS + PAUSE_MS.1
}

/// Where telling stands at `now_ms`; `finished_ms` is the job's.
#[must_use]
pub fn webhook_state(finished_ms: Option<i64>, told: Told, now_ms: i64) -> WebhookState {
    match finished_ms {
        None => WebhookState::Waiting,
        Some(finished) if told.ended_ms == finished && told.taken => WebhookState::Delivered,
        Some(finished) if now_ms.saturating_sub(finished) >= TRIES_MS => WebhookState::GivenUp,
        Some(_) => WebhookState::Trying,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_double_up_to_an_hour_and_end_within_a_day() {
        assert_eq!([1, 2, 3, 4].map(pause_ms), [1_000, 2_000, 4_000, 8_000]);
        assert_eq!([13, 1000, u32::MAX].map(pause_ms), [3_600_000; 3]);
        let (mut at_ms, mut tries) = (0, 0u32);
        while at_ms < TRIES_MS {
            tries += 1;
            at_ms += pause_ms(tries);
        }
        assert_eq!(tries, 35);
    }

    #[test]
    fn a_new_end_is_told_anew() {
        let told = |ended_ms, taken| Told { ended_ms, taken };
        let state = |finished, told| webhook_state(finished, told, 1_000);
        assert_eq!(state(None, told(0, false)), WebhookState::Waiting);
        assert_eq!(state(Some(900), told(0, false)), WebhookState::Trying);
        assert_eq!(state(Some(900), told(900, true)), WebhookState::Delivered);
        // The job went on after its first end was told.
        assert_eq!(state(None, told(900, true)), WebhookState::Waiting);
        assert_eq!(state(Some(950), told(900, true)), WebhookState::Trying);
        let late = webhook_state(Some(900), told(900, false), 900 + TRIES_MS);
        assert_eq!(late, WebhookState::GivenUp);
    }
}
