//! Rows as Rust values.

use super::error::{Attempt, StoreError, corrupt};
use crate::farm::frames_out_of_time;
use shearwater_shared::api::{AuditCounts, FailureKind, StopCause};
use shearwater_shared::hash::ContentHash;
use shearwater_shared::job::{JobId, Manifest, RenderSettings};
use shearwater_shared::plan::{Plan, Run};
use shearwater_shared::scene::Post;
use sqlx::Row;
use sqlx::any::AnyRow;

/// How a job ended, where nobody could derive it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ended {
    /// It has not been stopped.
    No,
    /// By a user.
    Cancelled,
    /// With this reason; whose fault it was, if anybody knows.
    Failed(String, Option<FailureKind>),
}

/// A job as stored, with the number of its leased units.
#[derive(Clone, Debug, PartialEq)]
pub struct JobRow {
    /// Number.
    pub id: JobId,
    /// Name for people.
    pub name: String,
    /// Scene and files.
    pub manifest: Manifest,
    /// What is rendered.
    pub settings: RenderSettings,
    /// The scene's way from radiance to a picture.
    pub post: Post,
    /// Frames of the scene's animation per second.
    pub fps: Option<f64>,
    /// Frames of the scene's animation; jobs of older stores lack it.
    pub animation_frames: Option<u32>,
    /// Higher is served first.
    pub priority: i32,
    /// Frames whose film is final.
    pub frames_done: u64,
    /// Units to be counted, as far as known.
    pub units_due: u64,
    /// Units counted.
    pub units_done: u64,
    /// Units leased now.
    pub units_leased: u64,
    /// Samples of the units that are due, over all pixels and frames.
    pub samples_total: u64,
    /// Samples counted.
    pub samples_done: u64,
    /// Microseconds of cores spent on counted runs.
    pub core_us: u64,
    /// Bad samples of counted runs.
    pub bad_samples: u64,
    /// Paths of counted runs that met the cap on depth.
    pub depth_cap_hits: u64,
    /// Results that came again with other bits.
    pub unequal_results: u64,
    /// How it was stopped.
    pub ended: Ended,
    /// Why its finished frames have no more samples; the last of the order of
    /// [`StopCause`] of all of them.
    pub stopped: Option<StopCause>,
    /// Samples per pixel in its finished frames, least and most.
    pub samples_range: Option<(u32, u32)>,
    /// Counts additions of samples.
    pub extended: i64,
    /// Numeric build of its first counted result.
    pub build: Option<String>,
    /// When the time of its time stop began to run.
    pub timed_from_ms: Option<i64>,
    /// Since when its user has it paused.
    pub paused_ms: Option<i64>,
    /// Decides which runs are audited; nobody outside knows it.
    pub audit_salt: i64,
    /// How its audit stands.
    pub audits: AuditCounts,
    /// When it was submitted.
    pub submitted_ms: i64,
    /// When its first lease went out.
    pub first_lease_ms: Option<i64>,
    /// When its last result was counted.
    pub last_result_ms: Option<i64>,
    /// When it was done, cancelled or failed.
    pub finished_ms: Option<i64>,
    /// Counts up with every change.
    pub rev: i64,
}

impl JobRow {
    /// The job's plan.
    #[must_use]
    pub fn plan(&self) -> Plan {
        Plan::new(&self.settings)
    }

    /// How many of its frames, from the first on, are out of time at `now_ms`;
    /// `None` without a time stop.
    #[must_use]
    pub fn out_of_time(&self, now_ms: i64) -> Option<u32> {
        let seconds = self.settings.stop.seconds?;
        let frames = self.settings.frames;
        Some(self.timed_from_ms.map_or(0, |from_ms| {
            frames_out_of_time(from_ms, seconds, frames, now_ms)
        }))
    }
}

/// The columns of [`job_row`].
macro_rules! job_columns {
    () => {
        "id, name, manifest, settings, post, fps, animation_frames, priority, frames_done, units_due, units_done, samples_total, \
         samples_done, core_us, bad_samples, depth_cap_hits, unequal_results, ended, failure, \
         submitted_ms, first_lease_ms, last_result_ms, finished_ms, rev, stopped, samples_min, samples_max, extended, build, \
         timed_from_ms, paused_ms, audit_salt, audits_equal, audits_unequal, audits_skipped, \
         (SELECT count(*) FROM audit WHERE audit.job = job.id) AS audits_open, \
         (SELECT count(*) FROM unit WHERE unit.job = job.id AND unit.state = 1) AS leased"
    };
}
pub(super) use job_columns;

pub(super) fn int(row: &AnyRow, column: &'static str) -> Result<i64, StoreError> {
    row.try_get(column).attempt(column)
}

pub(super) fn count(row: &AnyRow, column: &'static str) -> Result<u64, StoreError> {
    u64::try_from(int(row, column)?).map_err(|e| corrupt(column, e))
}

pub(super) fn small(row: &AnyRow, column: &'static str) -> Result<u32, StoreError> {
    u32::try_from(int(row, column)?).map_err(|e| corrupt(column, e))
}

pub(super) fn optional_small(
    row: &AnyRow,
    column: &'static str,
) -> Result<Option<u32>, StoreError> {
    let value = row.try_get::<Option<i64>, _>(column).attempt(column)?;
    let small = value.map(u32::try_from).transpose();
    small.map_err(|e| corrupt(column, e))
}

pub(super) fn text(row: &AnyRow, column: &'static str) -> Result<String, StoreError> {
    row.try_get(column).attempt(column)
}

pub(super) fn optional_text(
    row: &AnyRow,
    column: &'static str,
) -> Result<Option<String>, StoreError> {
    row.try_get(column).attempt(column)
}

pub(super) fn hash(row: &AnyRow, column: &'static str) -> Result<ContentHash, StoreError> {
    text(row, column)?.parse().map_err(|e| corrupt(column, e))
}

/// A count as SQL has it; counts of ours stay far below 2^63.
pub(super) fn big(value: u64) -> i64 {
    i64::try_from(value).unwrap_or(i64::MAX)
}

pub(super) fn json<T: serde::de::DeserializeOwned>(
    row: &AnyRow,
    column: &'static str,
) -> Result<T, StoreError> {
    serde_json::from_str(&text(row, column)?).map_err(|e| corrupt(column, e))
}

/// The number of a cause in the column `stopped`.
pub(super) const fn stop_code(cause: StopCause) -> i64 {
    match cause {
        StopCause::Error => 1,
        StopCause::Samples => 2,
        StopCause::Seconds => 3,
    }
}

const fn stop_cause(code: i64) -> Option<StopCause> {
    match code {
        1 => Some(StopCause::Error),
        2 => Some(StopCause::Samples),
        3 => Some(StopCause::Seconds),
        _ => None,
    }
}

/// The number of a failure in the column `ended`.
pub(super) const fn failure_code(kind: Option<FailureKind>) -> i64 {
    match kind {
        None => 2,
        Some(FailureKind::Scene) => 3,
        Some(FailureKind::Worker) => 4,
    }
}

const fn failure_kind(code: i64) -> Option<FailureKind> {
    match code {
        3 => Some(FailureKind::Scene),
        4 => Some(FailureKind::Worker),
        _ => None,
    }
}

/// Runs as the lease row keeps them.
pub(super) fn runs_text(runs: &[Run]) -> Result<String, StoreError> {
    serde_json::to_string(runs).map_err(|e| corrupt("runs", e))
}

pub(super) fn job_row(row: &AnyRow) -> Result<JobRow, StoreError> {
    let ended = match int(row, "ended")? {
        0 => Ended::No,
        1 => Ended::Cancelled,
        code => Ended::Failed(
            optional_text(row, "failure")?.unwrap_or_default(),
            failure_kind(code),
        ),
    };
    let time = |column: &'static str| row.try_get::<Option<i64>, _>(column).attempt(column);
    Ok(JobRow {
        id: JobId(int(row, "id")?),
        name: text(row, "name")?,
        manifest: json(row, "manifest")?,
        settings: json(row, "settings")?,
        post: json(row, "post")?,
        animation_frames: optional_small(row, "animation_frames")?,
        fps: optional_text(row, "fps")?
            .map(|text| serde_json::from_str(&text).map_err(|e| corrupt("fps", e)))
            .transpose()?,
        priority: i32::try_from(int(row, "priority")?).map_err(|e| corrupt("priority", e))?,
        frames_done: count(row, "frames_done")?,
        units_due: count(row, "units_due")?,
        units_done: count(row, "units_done")?,
        units_leased: count(row, "leased")?,
        samples_total: count(row, "samples_total")?,
        samples_done: count(row, "samples_done")?,
        core_us: count(row, "core_us")?,
        bad_samples: count(row, "bad_samples")?,
        depth_cap_hits: count(row, "depth_cap_hits")?,
        unequal_results: count(row, "unequal_results")?,
        ended,
        stopped: stop_cause(int(row, "stopped")?),
        samples_range: optional_small(row, "samples_min")?.zip(optional_small(row, "samples_max")?),
        extended: int(row, "extended")?,
        build: optional_text(row, "build")?,
        timed_from_ms: time("timed_from_ms")?,
        paused_ms: time("paused_ms")?,
        audit_salt: int(row, "audit_salt")?,
        audits: AuditCounts {
            open: count(row, "audits_open")?,
            equal: count(row, "audits_equal")?,
            unequal: count(row, "audits_unequal")?,
            skipped: count(row, "audits_skipped")?,
        },
        submitted_ms: int(row, "submitted_ms")?,
        first_lease_ms: time("first_lease_ms")?,
        last_result_ms: time("last_result_ms")?,
        finished_ms: time("finished_ms")?,
        rev: int(row, "rev")?,
    })
}
