//! A time stop: until when each frame of a job may be worked on.

/// When the time of the job's frame `frame` is up, in milliseconds since 1970, for
/// a job of `frames` frames and `seconds` from `from_ms` on. Each frame may take
/// its share of the time and what those before it left.
#[must_use]
pub fn frame_deadline_ms(from_ms: i64, seconds: u32, frame: u32, frames: u32) -> i64 {
    let share = u64::from(seconds) * 1000 * (u64::from(frame) + 1) / u64::from(frames.max(1));
    from_ms.saturating_add_unsigned(share)
}

/// How many of the job's frames, from the first on, are out of time at `now_ms`.
#[must_use]
pub fn frames_out_of_time(from_ms: i64, seconds: u32, frames: u32, now_ms: i64) -> u32 {
    let late = |frame: u32| frame_deadline_ms(from_ms, seconds, frame, frames) <= now_ms;
    // The deadlines rise: look for the first that is to come.
    let (mut low, mut high) = (0, frames);
    while low < high {
        let middle = low + (high - low) / 2;
        if late(middle) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    low
}

/// How long a lease of a job with a time stop should take at most: half of what is
/// left to its next deadline, so that little comes after it, and at least
/// `LEASE_MS_MIN`.
#[must_use]
pub fn lease_target_ms(target_ms: u64, deadline_ms: i64, now_ms: i64) -> u64 {
    let left = u64::try_from(deadline_ms.saturating_sub(now_ms)).unwrap_or(0);
    target_ms.min((left / 2).max(LEASE_MS_MIN))
}

/// Shorter leases cost more in questions than they save.
const LEASE_MS_MIN: u64 = 500;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_frame_has_its_share() {
        assert_eq!(frame_deadline_ms(1000, 10, 0, 1), 11_000);
        assert_eq!(frame_deadline_ms(1000, 10, 0, 4), 3500);
        assert_eq!(frame_deadline_ms(1000, 10, 3, 4), 11_000);
        let late = |now_ms| frames_out_of_time(1000, 10, 4, now_ms);
        assert_eq!(
            [late(0), late(3499), late(3500), late(11_000)],
            [0, 0, 1, 4]
        );
        for now_ms in (0..20_000).step_by(77) {
            let slow = (0..7).filter(|&f| frame_deadline_ms(1000, 13, f, 7) <= now_ms);
            assert_eq!(frames_out_of_time(1000, 13, 7, now_ms), slow.count() as u32);
        }
    }

    #[test]
    fn leases_shrink_towards_the_end() {
        assert_eq!(lease_target_ms(10_000, 100_000, 0), 10_000);
        assert_eq!(lease_target_ms(10_000, 4000, 0), 2000);
        assert_eq!(lease_target_ms(10_000, 4000, 9000), 500);
    }
}
