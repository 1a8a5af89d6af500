//! What a simulation found, as numbers and as text.

use super::audit::Audit;
use super::gauge::Sample;
use crate::output;
use serde::Serialize;
use shearwater_worker::simulate::{Histogram, Seen};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// Seconds of a window of which the best and the worst are named.
pub(crate) const WINDOW_S: usize = 10;

/// A distribution of times, in milliseconds.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Times {
    count: u64,
    p50_ms: f64,
    p90_ms: f64,
    p99_ms: f64,
    max_ms: f64,
}

impl Times {
    fn of(histogram: &Histogram) -> Self {
        let ms = |time: Duration| time.as_secs_f64() * 1000.0;
        let quantile = |share| ms(histogram.quantile(share));
        Self {
            count: histogram.count(),
            p50_ms: quantile(0.5),
            p90_ms: quantile(0.9),
            p99_ms: quantile(0.99),
            max_ms: ms(histogram.max()),
        }
    }

    fn text(&self) -> String {
        format!(
            "p50 {:.1} ms, p90 {:.1}, p99 {:.1}, max {:.1} ({} of them)",
            self.p50_ms, self.p90_ms, self.p99_ms, self.max_ms, self.count
        )
    }
}

/// What the coordinator's process used; absent for one that is not our own.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Usage {
    /// Most resident bytes, from its start on.
    pub(crate) rss_max_bytes: u64,
    /// Most resident bytes in each quarter of the run.
    pub(crate) rss_quarters_bytes: [u64; 4],
    /// Seconds of cores while there was work.
    pub(crate) cpu_s: f64,
    /// The same for a thousand units counted.
    pub(crate) cpu_s_per_1000_units: f64,
    /// Most open files, connections among them.
    pub(crate) files_max: u64,
    /// Share of one core while the workers waited for a job; absent if they did not.
    pub(crate) idle_cores: Option<f64>,
}

/// What is known besides the workers' own statistics.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Facts {
    pub(crate) workers: u32,
    pub(crate) threads: u32,
    pub(crate) frames: u32,
    pub(crate) units: u64,
    pub(crate) unit_ms: f64,
    pub(crate) seed: u64,
    /// From the submission's first byte to its answer.
    pub(crate) submit_s: f64,
    /// From the moment when there was a job and the first worker to the last unit
    /// that was counted.
    pub(crate) work_s: f64,
    /// From the last unit to the end of the job: folding and hashing. Absent before.
    pub(crate) finish_s: Option<f64>,
    /// Core time of the results counted, over that of all workers in `work_s`.
    pub(crate) efficiency: f64,
    /// Seconds of cores of the simulated workers.
    pub(crate) simulator_cpu_s: f64,
    /// Most resident bytes of them.
    pub(crate) simulator_rss_max_bytes: u64,
    /// Seconds of cores of everything else on this machine: a database, others.
    pub(crate) others_cpu_s: f64,
    /// Whether the time was up before the job was done.
    pub(crate) cut_short: bool,
}

/// All of it.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Report {
    #[serde(flatten)]
    pub(crate) facts: Facts,
    pub(crate) workers_connected: u64,
    pub(crate) units_counted: u64,
    pub(crate) units_per_s: f64,
    pub(crate) units_per_s_worst_window: Option<f64>,
    pub(crate) units_per_s_best_window: Option<f64>,
    pub(crate) results_per_s: f64,
    pub(crate) leases: u64,
    pub(crate) units_given_again: u64,
    pub(crate) duplicates: u64,
    pub(crate) failures: u64,
    pub(crate) vanished: u64,
    pub(crate) dropped: u64,
    pub(crate) refused: u64,
    pub(crate) quarantined: u64,
    pub(crate) lease_wait: Times,
    pub(crate) lease_wait_cut: Times,
    pub(crate) result_wait: Times,
    pub(crate) calls_per_unit: f64,
    pub(crate) bytes_sent_per_unit: f64,
    pub(crate) bytes_received_per_unit: f64,
    pub(crate) errors: BTreeMap<String, u64>,
    pub(crate) coordinator: Option<Usage>,
    pub(crate) audit: Audit,
}

impl Report {
    /// Of a simulation; `steady` are the first and the last second of its windows.
    pub(crate) fn new(
        facts: Facts,
        seen: &Seen,
        steady: (usize, usize),
        usage: Option<Usage>,
        audit: Audit,
    ) -> Self {
        let counts = seen.counts;
        let windows = seen.rates(WINDOW_S, steady.0, steady.1);
        let units = counts.units_counted;
        let per_unit = |n: u64| n as f64 / units.max(1) as f64;
        let per_s = |n: u64| n as f64 / facts.work_s.max(1e-3);
        Self {
            workers_connected: counts.connected,
            units_counted: units,
            units_per_s: per_s(units),
            units_per_s_worst_window: windows.map(|w| w.0),
            units_per_s_best_window: windows.map(|w| w.1),
            results_per_s: per_s(counts.results),
            leases: counts.leases,
            units_given_again: counts.units_given_again,
            duplicates: counts.duplicates,
            failures: counts.failures,
            vanished: counts.vanished,
            dropped: counts.dropped,
            refused: counts.refused,
            quarantined: counts.quarantined,
            lease_wait: Times::of(&seen.lease_waits),
            lease_wait_cut: Times::of(&seen.lease_waits_cut),
            result_wait: Times::of(&seen.result_waits),
            calls_per_unit: per_unit(seen.traffic.calls),
            bytes_sent_per_unit: per_unit(seen.traffic.sent_bytes),
            bytes_received_per_unit: per_unit(seen.traffic.received_bytes),
            errors: seen.traffic.failures.clone(),
            coordinator: usage,
            audit,
            facts,
        }
    }

    /// For people.
    pub(crate) fn text(&self) -> String {
        let facts = &self.facts;
        let mut rows = vec![
            (
                "workers",
                format!(
                    "{} of {} connected, {} threads each",
                    self.workers_connected, facts.workers, facts.threads
                ),
            ),
            (
                "units",
                format!(
                    "{} counted of {} ({} frames), in {:.1} s",
                    self.units_counted, facts.units, facts.frames, facts.work_s
                ),
            ),
            ("rate", self.rate_text()),
            ("lease wait", self.lease_wait.text()),
            ("cut at end", self.lease_wait_cut.text()),
            ("result wait", self.result_wait.text()),
            (
                "faults",
                format!(
                    "{} failures, {} vanished, {} units given again, {} duplicates, {} dropped, {} refused, {} quarantined",
                    self.failures,
                    self.vanished,
                    self.units_given_again,
                    self.duplicates,
                    self.dropped,
                    self.refused,
                    self.quarantined
                ),
            ),
            ("errors", self.errors_text()),
            (
                "of a unit",
                format!(
                    "{:.2} calls, {:.0} bytes sent, {:.0} received",
                    self.calls_per_unit, self.bytes_sent_per_unit, self.bytes_received_per_unit
                ),
            ),
            ("submitted in", format!("{:.3} s", facts.submit_s)),
            (
                "finished in",
                facts
                    .finish_s
                    .map_or("-".to_owned(), |s| format!("{s:.2} s after the last unit")),
            ),
            ("efficiency", format!("{:.4}", facts.efficiency)),
        ];
        rows.extend(self.coordinator.iter().flat_map(usage_rows));
        rows.push((
            "others",
            format!(
                "{:.1} s simulated workers ({} MiB), {:.1} s everything else",
                facts.simulator_cpu_s,
                facts.simulator_rss_max_bytes >> 20,
                facts.others_cpu_s
            ),
        ));
        rows.push(("audit", self.audit_text()));
        output::table(&rows)
    }

    fn rate_text(&self) -> String {
        let window = |rate: Option<f64>| rate.map_or("-".to_owned(), |rate| format!("{rate:.0}"));
        format!(
            "{:.0} units/s (windows of {WINDOW_S} s: {} to {}), {:.0} results/s",
            self.units_per_s,
            window(self.units_per_s_worst_window),
            window(self.units_per_s_best_window),
            self.results_per_s
        )
    }

    fn errors_text(&self) -> String {
        if self.errors.is_empty() {
            return "none".to_owned();
        }
        let errors = self.errors.iter().map(|(kind, n)| format!("{kind}: {n}"));
        errors.collect::<Vec<_>>().join(", ")
    }

    fn audit_text(&self) -> String {
        let audit = &self.audit;
        if audit.faults.is_empty() {
            return format!(
                "{} of {} units counted, none twice; {} films checked, all right",
                audit.units_done, audit.units_total, audit.films_checked
            );
        }
        audit.faults.join("; ")
    }
}

fn usage_rows(usage: &Usage) -> Vec<(&'static str, String)> {
    let mib = |bytes: u64| format!("{}", bytes >> 20);
    let quarters = usage.rss_quarters_bytes.map(mib).join(", ");
    let mut rows = vec![
        (
            "memory",
            format!(
                "{} MiB at most; by quarters {quarters}",
                mib(usage.rss_max_bytes)
            ),
        ),
        (
            "cpu",
            format!(
                "{:.1} s, {:.3} s per 1000 units",
                usage.cpu_s, usage.cpu_s_per_1000_units
            ),
        ),
        ("open files", usage.files_max.to_string()),
    ];
    if let Some(idle) = usage.idle_cores {
        rows.push(("idle", format!("{idle:.3} cores while the workers waited")));
    }
    rows
}

/// Most resident bytes in each quarter of the time between two moments.
pub(crate) fn quarters(samples: &[Sample], from: Instant, to: Instant) -> [u64; 4] {
    let length = to.saturating_duration_since(from) / 4;
    [0, 1, 2, 3].map(|quarter| {
        let start = from + length * quarter;
        let within = |sample: &&Sample| (start..=start + length).contains(&sample.at);
        let bytes = samples.iter().filter(within).map(|s| s.rss_bytes);
        bytes.max().unwrap_or(0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_quarter_has_its_own_maximum() {
        let zero = Instant::now();
        let at = |ms| zero + Duration::from_millis(ms);
        let samples = [
            (500, 9),
            (1500, 1),
            (2500, 2),
            (3500, 3),
            (4500, 4),
            (9000, 8),
        ];
        let samples = samples.map(|(ms, rss_bytes)| Sample {
            at: at(ms),
            rss_bytes,
            cpu_s: 0.0,
            files: 0,
        });
        assert_eq!(quarters(&samples, at(1000), at(5000)), [1, 2, 3, 4]);
        assert_eq!(quarters(&[], at(0), at(0)), [0; 4]);
    }
}
