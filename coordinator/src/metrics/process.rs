//! The process itself, by the names that every Prometheus client gives.

use prometheus_client::metrics::counter::ConstCounter;
use prometheus_client::metrics::gauge::ConstGauge;
use prometheus_client::registry::Registry;
use rustix::time::{ClockId, clock_gettime};
use std::time::{SystemTime, UNIX_EPOCH};

/// When it began.
#[derive(Debug)]
pub(super) struct Process {
    start_s: f64,
}

impl Process {
    /// A process that begins now: nobody asks the system for what a clock tells as well.
    pub(super) fn start() -> Self {
        let since = SystemTime::now().duration_since(UNIX_EPOCH);
        let start_s = since.map_or(0.0, |since| since.as_secs_f64());
        Self { start_s }
    }

    /// As it is now. What this system does not tell is left out.
    pub(super) fn register(&self, registry: &mut Registry) {
        registry.register(
            "process_cpu_seconds",
            "Time of all cores that this process has had",
            ConstCounter::new(cpu_seconds()),
        );
        registry.register(
            "process_start_time_seconds",
            "When this process began, since 1970",
            ConstGauge::new(self.start_s),
        );
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let limits = std::fs::read_to_string("/proc/self/limits").unwrap_or_default();
        // Reading the folder opens it.
        let files = std::fs::read_dir("/proc/self/fd").ok();
        let files = files.map(|files| (files.count() as u64).saturating_sub(1));
        for (name, help, value) in [
            (
                "process_resident_memory_bytes",
                "Memory of this process that is in RAM",
                of_status(&status, "VmRSS:").map(|kib| kib * 1024),
            ),
            (
                "process_virtual_memory_bytes",
                "Address space of this process",
                of_status(&status, "VmSize:").map(|kib| kib * 1024),
            ),
            (
                "process_threads",
                "Threads of this process",
                of_status(&status, "Threads:"),
            ),
            (
                "process_open_fds",
                "Files and connections that this process has open",
                files,
            ),
            (
                "process_max_fds",
                "Files and connections that this process may have open",
                max_files(&limits),
            ),
        ] {
            if let Some(value) = value {
                registry.register(name, help, ConstGauge::new(value as f64));
            }
        }
    }
}

fn cpu_seconds() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 / 1e9
}

/// The number of a line such as `VmRSS:     1234 kB`.
fn of_status(status: &str, key: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix(key))?;
    line.split_whitespace().next()?.parse().ok()
}

/// The soft limit; `unlimited` is no number.
fn max_files(limits: &str) -> Option<u64> {
    let line = limits
        .lines()
        .find_map(|line| line.strip_prefix("Max open files"))?;
    line.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_the_system_are_read() {
        assert_eq!(of_status("Name: x\nVmRSS:\t  12 kB\n", "VmRSS:"), Some(12));
        assert_eq!(of_status("", "VmRSS:"), None);
        let limits = "Max open files            1024                 4096                 files\n";
        assert_eq!(max_files(limits), Some(1024));
        assert_eq!(
            max_files("Max open files  unlimited  unlimited files\n"),
            None
        );
        assert!(cpu_seconds() > 0.0);
    }
}
