//! The time that a render thread has spent on a core.

use rustix::time::{ClockId, clock_gettime};

/// Seconds on a core, of the calling thread alone; only differences mean something.
/// What a job costs should not depend on what else its machines are doing, so jobs count
/// these and not the time by the clock, which leases are sized by.
pub(crate) fn thread_cpu_seconds() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waiting_costs_nothing() {
        let before = thread_cpu_seconds();
        std::thread::sleep(std::time::Duration::from_millis(60));
        let waited = thread_cpu_seconds();
        assert!(waited - before < 0.04, "{}", waited - before);
        let mut sum = 0u64;
        while thread_cpu_seconds() - waited < 0.01 {
            sum = std::hint::black_box(sum.wrapping_mul(31).wrapping_add(7));
        }
    }
}
