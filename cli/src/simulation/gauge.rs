//! What processes of this machine use, from `/proc`.

use std::time::Instant;

/// Ticks of a second in `/proc`: the same on every Linux that this runs on.
const TICKS_PER_S: f64 = 100.0;
/// Most samples that are kept; then every second one goes, and only every second
/// moment is kept from then on.
const SAMPLES_MAX: usize = 8192;

/// A process at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sample {
    /// When.
    pub(crate) at: Instant,
    /// Resident bytes.
    pub(crate) rss_bytes: u64,
    /// Seconds of cores since the process began.
    pub(crate) cpu_s: f64,
    /// Open files, connections among them.
    pub(crate) files: u64,
}

/// Samples of one process over time.
#[derive(Debug)]
pub(crate) struct Gauge {
    pid: u32,
    every: u32,
    turn: u32,
    samples: Vec<Sample>,
}

impl Gauge {
    /// Of a process by its number.
    pub(crate) const fn of(pid: u32) -> Self {
        Self {
            pid,
            every: 1,
            turn: 0,
            samples: Vec::new(),
        }
    }

    /// How the process is now; `None` where the system does not say.
    pub(crate) fn now(&self) -> Option<Sample> {
        let status = self.read("status")?;
        let files = std::fs::read_dir(format!("/proc/{}/fd", self.pid)).ok()?;
        Some(Sample {
            at: Instant::now(),
            rss_bytes: kib(&status, "VmRSS:")? << 10,
            cpu_s: cpu_s(&self.read("stat")?)?,
            files: files.count() as u64,
        })
    }

    /// The most that has been resident, in bytes: the system counts it in steps, so
    /// that a sample may have been higher. 0 where it does not say.
    pub(crate) fn rss_max_bytes(&self) -> u64 {
        let peak = self.read("status").and_then(|text| kib(&text, "VmHWM:"));
        let sampled = self.samples.iter().map(|sample| sample.rss_bytes).max();
        sampled.unwrap_or(0).max(peak.unwrap_or(0) << 10)
    }

    fn read(&self, file: &str) -> Option<String> {
        std::fs::read_to_string(format!("/proc/{}/{file}", self.pid)).ok()
    }

    /// Keep how the process is now.
    pub(crate) fn take(&mut self) {
        self.turn += 1;
        if !self.turn.is_multiple_of(self.every) {
            return;
        }
        self.samples.extend(self.now());
        if self.samples.len() >= SAMPLES_MAX {
            let mut index = 0;
            self.samples.retain(|_| {
                index += 1;
                index % 2 == 0
            });
            self.every = self.every.saturating_mul(2);
        }
    }

    /// Every sample that was kept, in order.
    pub(crate) fn samples(&self) -> &[Sample] {
        &self.samples
    }
}

/// Seconds that all cores of the machine together were busy since it started.
pub(crate) fn machine_busy_s() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/stat").ok()?;
    let line = text.lines().next()?.strip_prefix("cpu ")?;
    let numbers: Vec<f64> = line
        .split_whitespace()
        .map_while(|n| n.parse().ok())
        .collect();
    // user nice system idle iowait irq softirq steal; guests are in user.
    let busy = [0, 1, 2, 5, 6].iter().filter_map(|&n| numbers.get(n));
    Some(busy.sum::<f64>() / TICKS_PER_S)
}

fn kib(status: &str, name: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim().strip_suffix("kB")?.trim().parse().ok()
}

/// User and system time; the name before them may hold anything but its last bracket.
fn cpu_s(stat: &str) -> Option<f64> {
    let (_, fields) = stat.rsplit_once(')')?;
    let mut fields = fields.split_whitespace().skip(11);
    let user: f64 = fields.next()?.parse().ok()?;
    let system: f64 = fields.next()?.parse().ok()?;
    Some((user + system) / TICKS_PER_S)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_what_the_system_writes() {
        let status = "Name:\tx\nVmHWM:\t  2048 kB\nVmRSS:\t  1024 kB\n";
        assert_eq!(kib(status, "VmRSS:"), Some(1024));
        assert_eq!(kib(status, "VmSwap:"), None);
        let stat = "7 (a ) b) S 1 7 7 0 -1 4194560 1 0 0 0 150 50 0 0 20 0 9 0";
        assert_eq!(cpu_s(stat), Some(2.0));
        assert_eq!(cpu_s(""), None);
    }

    #[test]
    fn this_process_has_memory_and_files() {
        let mut gauge = Gauge::of(std::process::id());
        for _ in 0..3 {
            gauge.take();
        }
        assert_eq!(gauge.samples().len(), 3);
        assert!(gauge.samples()[0].rss_bytes > 1 << 20 && gauge.samples()[0].files > 2);
        assert!(gauge.rss_max_bytes() >= gauge.samples()[0].rss_bytes);
        assert!(machine_busy_s() > Some(0.0));
    }

    #[test]
    fn samples_thin_out() {
        let mut gauge = Gauge::of(std::process::id());
        let now = gauge.now().expect("this process");
        gauge.samples = vec![now; SAMPLES_MAX - 1];
        gauge.take();
        assert_eq!((gauge.samples.len(), gauge.every), (SAMPLES_MAX / 2, 2));
        gauge.take();
        gauge.take();
        assert_eq!(gauge.samples.len(), SAMPLES_MAX / 2 + 1);
    }
}
