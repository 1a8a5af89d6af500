//! Speed and error of a job, for people.

use crate::output::{duration, nmse_text, scaled};
use shearwater_shared::api::{ErrorPoint, JobView};
use shearwater_shared::film::{ErrorDetail, ErrorEstimate};

/// Samples per second, and those of one core.
pub(crate) fn speed(job: &JobView) -> String {
    let all = scaled(job.samples_per_s);
    if job.core_s <= 0.0 {
        return format!("{all} samples/s");
    }
    let of_a_core = scaled(job.samples_done as f64 / job.core_s);
    format!("{all} samples/s ({of_a_core} per core)")
}

/// Rows about the error of a job's picture.
pub(crate) fn rows(job: &JobView) -> Vec<(&'static str, String)> {
    let Some(error) = &job.error else {
        return Vec::new();
    };
    let mut rows = vec![("NMSE", nmse(job, error))];
    if let Some(detail) = &error.detail {
        rows.extend(detail_rows(detail));
    }
    if let (Some(target), Some(left)) = (job.settings.stop.error, job.target_s) {
        let text = format!("relMSE {:.1e} in about {}", target.get(), duration(left));
        rows.push(("target", text));
    }
    rows
}

fn nmse(job: &JobView, error: &ErrorEstimate) -> String {
    let mut text = nmse_text(job, error.nmse);
    text.push_str(&format!(
        ", worst tile {:.1e} ({})",
        error.worst_tile_nmse, error.worst_tile
    ));
    if let Some(at_end) = job.nmse_at_end {
        text.push_str(&format!(", {at_end:.1e} at the end"));
    }
    text
}

fn detail_rows(detail: &ErrorDetail) -> Vec<(&'static str, String)> {
    let mut rows = vec![
        (
            "relMSE",
            format!(
                "{:.3e}, worst tile {:.1e} ({})",
                detail.relmse, detail.worst_tile_relmse, detail.worst_relmse_tile
            ),
        ),
        (
            "mean",
            format!(
                "{:.6} +- {:.1e} (luminance, 95 %)",
                detail.mean, detail.mean_interval
            ),
        ),
    ];
    if let Some(share) = detail.firefly_share {
        let text = format!(
            "{:.3} % of the light in 0.01 % of the samples",
            100.0 * share
        );
        rows.push(("fireflies", text));
    }
    if detail.repeated_tiles > 0 {
        let text = format!(
            "the halves of {} tiles are equal: a repeated seed? Their error is unknown",
            detail.repeated_tiles
        );
        rows.push(("ALARM", text));
    }
    rows
}

/// The error on one short line: now and, if it is known, at the end.
pub(crate) fn short(job: &JobView) -> Option<String> {
    let error = job.error.as_ref()?;
    let mut text = format!("NMSE {:.1e}", error.nmse);
    if let Some(at_end) = job.nmse_at_end {
        text.push_str(&format!(" ({at_end:.1e} at the end)"));
    }
    if let Some(left) = job.target_s {
        text.push_str(&format!("  target in {}", duration(left)));
    }
    if error.detail.is_some_and(|detail| detail.repeated_tiles > 0) {
        text.push_str("  ALARM: equal halves");
    }
    Some(text)
}

/// Error against time as a table.
pub(crate) fn points(points: &[ErrorPoint]) -> String {
    let mut text = format!(
        "\n{:>9}  {:>10}  {:>9}  {:>9}  {:>9}  {:>10}  {:>9}",
        "SECONDS", "CORE S", "SAMPLES", "NMSE", "RELMSE", "WORST TILE", "FIREFLIES"
    );
    for point in points {
        let detail = point.error.detail.unwrap_or_default();
        let fireflies = detail
            .firefly_share
            .map_or_else(|| "-".to_owned(), |share| format!("{:.2} %", 100.0 * share));
        text.push_str(&format!(
            "\n{:>9.2}  {:>10.2}  {:>9}  {:>9.2e}  {:>9.2e}  {:>10.2e}  {fireflies:>9}",
            point.elapsed_s,
            point.core_s,
            scaled(point.samples_done as f64),
            point.error.nmse,
            detail.relmse,
            detail.worst_tile_relmse,
        ));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_has_a_line_for_each_point() {
        let point = |samples_done, nmse| ErrorPoint {
            frame: 0,
            at_ms: 0,
            elapsed_s: 1.5,
            core_s: 3.0,
            samples_done,
            error: ErrorEstimate {
                nmse,
                detail: Some(ErrorDetail {
                    firefly_share: Some(0.031),
                    ..ErrorDetail::default()
                }),
                ..ErrorEstimate::default()
            },
        };
        let text = points(&[point(1_000, 0.02), point(2_000_000, 0.01)]);
        let lines: Vec<&str> = text.lines().skip(1).collect();
        assert_eq!(lines.len(), 3, "{text}");
        assert!(
            lines[1].contains("1.00 k") && lines[1].contains("2.00e-2"),
            "{text}"
        );
        assert!(
            lines[2].contains("2.00 M") && lines[2].contains("3.10 %"),
            "{text}"
        );
        let widths: Vec<usize> = lines.iter().map(|line| line.chars().count()).collect();
        assert_eq!(widths, [widths[0]; 3], "columns under their names");
    }
}
