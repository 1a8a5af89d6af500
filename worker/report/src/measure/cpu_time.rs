//! The time that the calling thread has spent on a core.

use rustix::time::{ClockId, clock_gettime};

/// Seconds on a core, of the calling thread alone; only differences mean something.
/// What other programs do on the machine is not in it.
#[must_use]
pub fn thread_cpu_seconds() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sleep_costs_nothing_and_work_does() {
        let before = thread_cpu_seconds();
        std::thread::sleep(std::time::Duration::from_millis(60));
        let slept = thread_cpu_seconds();
        assert!(slept - before < 0.04, "{}", slept - before);
        let mut sum = 0u64;
        while thread_cpu_seconds() - slept < 0.02 {
            sum = std::hint::black_box(sum.wrapping_mul(31).wrapping_add(7));
        }
        assert!(thread_cpu_seconds() > slept);
    }
}
