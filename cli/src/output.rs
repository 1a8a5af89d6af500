//! What is printed: text for people, one JSON object for programs.

use crate::error_text;
use crate::exit::CliError;
use serde_json::{Value, json};
use shearwater_shared::api::{AuditCounts, JobView, StopCause};
use shearwater_shared::hash::ContentHash;
use shearwater_shared::job::JobState;
use std::io::{ErrorKind, Write};

/// Print a text and end the line. Whoever reads may have closed the pipe (`| head`):
/// that is no error of this program, and nothing can be said about it there.
pub(crate) fn line(text: impl std::fmt::Display) {
    match writeln!(std::io::stdout().lock(), "{text}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            let _ = writeln!(std::io::stderr(), "error: standard output: {error}");
        }
        _ => {}
    }
}

/// Print one JSON object on one line.
pub(crate) fn object(value: &Value) {
    line(value);
}

/// Print something that the user should know; to standard error.
pub(crate) fn note(text: impl std::fmt::Display) {
    let _ = writeln!(std::io::stderr(), "note: {text}");
}

/// Print why the command failed. Text always goes to standard error.
pub(crate) fn error(error: &CliError, json: bool) {
    eprintln!("error: {error}");
    // One object only: a comparison, a report or a simulation has printed its own.
    let printed = matches!(
        error,
        CliError::Different(_) | CliError::Variants(_) | CliError::Audit(_)
    );
    if json && !printed {
        object(&json!({
            "error": {
                "kind": error.kind(),
                "message": error.to_string(),
                "exit_code": error.exit() as u8,
            }
        }));
    }
}

/// A job as its API's JSON.
pub(crate) fn job_value(job: &JobView) -> Value {
    serde_json::to_value(job).unwrap_or_else(|e| json!({ "error": e.to_string() }))
}

/// A state as the API spells it.
pub(crate) const fn state_text(state: JobState) -> &'static str {
    match state {
        JobState::Queued => "queued",
        JobState::Running => "running",
        JobState::Paused => "paused",
        JobState::Done => "done",
        JobState::Cancelled => "cancelled",
        JobState::Failed => "failed",
    }
}

/// A job after a command has changed it: one line, or its JSON.
pub(crate) fn job_state(job: &JobView, json: bool) {
    if json {
        object(&job_value(job));
    } else {
        line(format_args!("job {} is {}", job.id, state_text(job.state)));
    }
}

/// A job as a table of two columns.
pub(crate) fn job_text(job: &JobView) -> String {
    let mut rows = vec![
        ("job", format!("{} ({})", job.id, job.name)),
        ("state", state_text(job.state).to_owned()),
        (
            "size",
            format!("{}x{}", job.settings.width, job.settings.height),
        ),
        ("samples", samples_text(job)),
        ("frames", frames_text(job)),
        (
            "progress",
            format!(
                "{:.1} % ({} of {} units)",
                job.progress * 100.0,
                job.units_done,
                job.units_total
            ),
        ),
        ("speed", error_text::speed(job)),
        (
            "seconds",
            format!("{:.2} ({:.2} of one core)", job.elapsed_s, job.core_s),
        ),
    ];
    if let Some(left) = job.remaining_s.filter(|_| !job.done) {
        rows.push(("left", duration(left)));
    }
    rows.extend(error_text::rows(job));
    if job.bad_samples > 0 {
        rows.push(("bad samples", job.bad_samples.to_string()));
    }
    if job.priority != 0 {
        rows.push(("priority", job.priority.to_string()));
    }
    if job.audits != AuditCounts::default() {
        rows.push(("audit", audit_text(&job.audits)));
    }
    if job.depth_cap_hits > 0 {
        rows.push(("cut paths", job.depth_cap_hits.to_string()));
    }
    rows.extend(stop_rows(job));
    if let Some(note) = &job.note {
        rows.push(("note", note.clone()));
    }
    if let Some(failure) = &job.failure {
        rows.push(("failure", failure.clone()));
    }
    rows.extend(film_rows(job));
    table(&rows)
}

fn audit_text(audits: &AuditCounts) -> String {
    let AuditCounts {
        open,
        equal,
        unequal,
        skipped,
    } = audits;
    format!("{equal} equal, {unequal} unequal, {open} open, {skipped} skipped")
}

/// Samples per pixel: what is asked for, and with a stop rule what there is.
pub(crate) fn samples_text(job: &JobView) -> String {
    let asked = job.settings.samples;
    let rule = match (job.settings.stop.error, job.settings.stop.seconds) {
        (None, None) => return format!("{asked} per pixel"),
        (Some(error), None) => format!("until the error is {error}"),
        (None, Some(seconds)) => format!("for {seconds} s"),
        (Some(error), Some(seconds)) => format!("until the error is {error}, for {seconds} s"),
    };
    format!("{rule}, at most {asked} per pixel")
}

/// What a job with a stop rule has come to.
pub(crate) fn stop_rows(job: &JobView) -> Vec<(&'static str, String)> {
    let stop = &job.settings.stop;
    if stop.error.is_none() && stop.seconds.is_none() {
        return Vec::new();
    }
    let mut rows = Vec::new();
    let mean = job.samples_mean;
    let range = match (job.samples_min, job.samples_max) {
        (Some(least), Some(most)) => format!("mean {mean:.1} ({least} to {most})"),
        _ => format!("mean {mean:.1} so far"),
    };
    rows.push(("per pixel", range));
    if let Some(cause) = job.stopped_by.filter(|_| job.done) {
        let text = match cause {
            StopCause::Error => "the error is reached",
            StopCause::Samples => "all samples are there",
            StopCause::Seconds => "the time is up; `shearwater add` goes on",
        };
        rows.push(("stopped", text.to_owned()));
    }
    rows
}

/// A row for each film hash of a job; with several frames, after its number.
pub(crate) fn film_rows(job: &JobView) -> Vec<(&'static str, String)> {
    let numbers = job.settings.first_frame..;
    let row = |(frame, hash): (u32, &ContentHash)| match job.settings.frames {
        1 => ("film hash", hash.to_string()),
        _ => ("film hash", format!("{frame:04} {hash}")),
    };
    numbers.zip(&job.film_hashes).map(row).collect()
}

/// How many frames are done, and which they are.
fn frames_text(job: &JobView) -> String {
    let (done, settings) = (job.frames_done, &job.settings);
    let (all, first, last) = (settings.frames, settings.first_frame, settings.last_frame());
    match all {
        1 if first == 0 => format!("{done} of 1 done"),
        1 => format!("{done} of 1 done ({first})"),
        _ => format!("{done} of {all} done ({first} to {last})"),
    }
}

/// A job's NMSE; with several frames, of which of them.
pub(crate) fn nmse_text(job: &JobView, nmse: f64) -> String {
    match job.error_frame {
        Some(frame) if job.settings.frames > 1 && job.frames_done > 0 => {
            format!("{nmse:.3e} (frame {frame}, the worst)")
        }
        Some(frame) if job.settings.frames > 1 => format!("{nmse:.3e} (frame {frame})"),
        _ => format!("{nmse:.3e}"),
    }
}

/// Rows of a name and a value, names padded to one width.
pub(crate) fn table(rows: &[(&str, String)]) -> String {
    let width = rows.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    rows.iter()
        .map(|(name, value)| format!("{name:width$}  {value}"))
        .collect::<Vec<_>>()
        .join("\n")
}

/// A number with a decimal prefix: `12.3 M`.
pub(crate) fn scaled(value: f64) -> String {
    let (factor, prefix) = match value {
        v if v >= 1e9 => (1e9, " G"),
        v if v >= 1e6 => (1e6, " M"),
        v if v >= 1e3 => (1e3, " k"),
        _ => (1.0, ""),
    };
    format!("{:.2}{prefix}", value / factor)
}

/// Seconds as `1:02:03` or `2:03`.
pub(crate) fn duration(seconds: f64) -> String {
    // `as` saturates, and a NaN becomes 0.
    let s = seconds.ceil() as u64;
    match s / 3600 {
        0 => format!("{}:{:02}", s / 60, s % 60),
        hours => format!("{hours}:{:02}:{:02}", s / 60 % 60, s % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_for_people() {
        assert_eq!(scaled(0.0), "0.00");
        assert_eq!(scaled(1_234_567.0), "1.23 M");
        assert_eq!(duration(61.2), "1:02");
        assert_eq!(duration(3_661.0), "1:01:01");
        assert_eq!(duration(f64::NAN), "0:00");
        assert_eq!(
            table(&[("a", "1".into()), ("long", "2".into())]),
            "a     1\nlong  2"
        );
    }
}
