//! JSON of the REST API and of the worker protocol.

use crate::film::ErrorEstimate;
use crate::hash::ContentHash;
use crate::job::{JobId, JobState, Manifest, RenderSettings};
use crate::plan::Run;
use crate::stop::ErrorTarget;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Body of `POST /v1/jobs`. The scene and its files must be uploaded first.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SubmitRequest {
    /// Name for people; default is the scene's.
    #[serde(default)]
    pub name: Option<String>,
    /// Scene and files.
    pub manifest: Manifest,
    /// What differs from the scene's defaults.
    #[serde(default)]
    pub settings: SettingsOverride,
    /// Jobs of higher priority are served first, jobs of the same share the workers;
    /// [`PRIORITY_MIN`](crate::limits::PRIORITY_MIN) to
    /// [`PRIORITY_MAX`](crate::limits::PRIORITY_MAX).
    #[serde(default)]
    pub priority: i32,
    /// Whom to tell when the job ends.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub webhook: Option<WebhookRequest>,
}

/// Whom to tell about the end of a job, by a signed `POST`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct WebhookRequest {
    /// `http` or `https`, without user and password.
    #[schema(max_length = 2000)]
    pub url: String,
    /// Signs the message; default is the farm's. The API never shows it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(min_length = 16, max_length = 200)]
    pub secret: Option<String>,
}

/// What became of telling about the end of a job.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ToSchema)]
pub struct WebhookView {
    /// Whom: without its query, which may hold secrets.
    pub url: String,
    /// Where it stands.
    pub state: WebhookState,
    /// Tries so far, of the job's latest end.
    pub attempts: u32,
    /// What the receiver said last, as an HTTP status.
    #[serde(default)]
    pub last_status: Option<u16>,
    /// Why the last try failed.
    #[serde(default)]
    pub last_error: Option<String>,
    /// When the receiver took it, milliseconds since 1970.
    #[serde(default)]
    pub delivered_ms: Option<i64>,
}

/// Where a webhook stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum WebhookState {
    /// The job has not ended.
    Waiting,
    /// It has; the receiver has not taken the message yet.
    Trying,
    /// The receiver took it.
    Delivered,
    /// The receiver did not take it in time.
    GivenUp,
}

/// Body of a webhook's `POST`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, ToSchema)]
pub struct WebhookEvent {
    /// The same for every repetition of one message; unique within a farm.
    pub id: String,
    /// What happened.
    #[serde(rename = "type")]
    pub kind: WebhookEventKind,
    /// When the job ended, milliseconds since 1970.
    pub at_ms: i64,
    /// The job as it is when this is sent.
    pub job: JobView,
}

/// What a webhook tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ToSchema)]
pub enum WebhookEventKind {
    /// Its pictures are final.
    #[serde(rename = "job.done")]
    Done,
    /// It cannot be rendered.
    #[serde(rename = "job.failed")]
    Failed,
    /// A user stopped it.
    #[serde(rename = "job.cancelled")]
    Cancelled,
}

/// What a submission would become: the answer to `validate_only`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, ToSchema)]
pub struct SubmitCheck {
    /// Name of the job.
    pub name: String,
    /// What would be rendered.
    pub settings: RenderSettings,
    /// Frames of the scene's animation per second; absent without one.
    #[serde(default)]
    pub fps: Option<f64>,
    /// Frames of the scene's animation; absent without one.
    #[serde(default)]
    pub animation_frames: Option<u32>,
    /// Units of all frames; with an error target those of the first pass.
    pub units_total: u64,
    /// Samples per pixel times pixels, over all frames; with an error target the most.
    pub samples_max: u64,
}

/// Body of `PATCH /v1/jobs/{id}`: what is to be changed of a job, ended or not.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ToSchema,
)]
#[serde(deny_unknown_fields)]
pub struct ChangeJob {
    /// Its new priority, from the next lease on; see [`SubmitRequest::priority`].
    #[serde(default)]
    pub priority: Option<i32>,
}

/// Settings that replace the scene's.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ToSchema,
)]
#[serde(deny_unknown_fields)]
pub struct SettingsOverride {
    /// Picture width in pixels.
    #[serde(default)]
    pub width: Option<u32>,
    /// Picture height in pixels.
    #[serde(default)]
    pub height: Option<u32>,
    /// Samples per pixel, even.
    #[serde(default)]
    pub samples: Option<u32>,
    /// Seed.
    #[serde(default)]
    pub seed: Option<u64>,
    /// Stop at this error; `samples` is then the most that any pixel gets, 16,384
    /// when it is not given.
    #[serde(default)]
    pub error: Option<ErrorTarget>,
    /// Stop after so many seconds; see `error` for `samples`.
    #[serde(default)]
    pub seconds: Option<u32>,
    /// Number of frames; default is the rest of the scene's animation.
    #[serde(default)]
    pub frames: Option<u32>,
    /// The scene's number of the first frame; default is 0.
    #[serde(default)]
    pub first_frame: Option<u32>,
}

/// Body of `POST /v1/jobs/{id}/samples`: what is to be added to a job, finished or
/// not.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ToSchema,
)]
#[serde(deny_unknown_fields)]
pub struct AddSamples {
    /// The new total of samples per pixel; for a job with an error target the most
    /// that any pixel gets.
    #[serde(default)]
    pub samples: Option<u32>,
    /// Instead of the total: samples per pixel to add to the job's settings.
    #[serde(default)]
    pub add: Option<u32>,
    /// A smaller error target, for a job that has one.
    #[serde(default)]
    pub error: Option<ErrorTarget>,
    /// Seconds after which the job stops again, from its next lease on; without it
    /// a job that stopped by time goes on to its samples.
    #[serde(default)]
    pub seconds: Option<u32>,
}

/// Which rule ended a job's frames.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema, ToSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum StopCause {
    /// The error is at most the target.
    Error,
    /// All samples are there; with an error target, some tile did not reach it.
    Samples,
    /// The time was up.
    Seconds,
}

/// A job as the API shows it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, ToSchema)]
pub struct JobView {
    /// Number.
    pub id: JobId,
    /// Name.
    pub name: String,
    /// Where it stands.
    pub state: JobState,
    /// No further change will come.
    pub done: bool,
    /// Why it failed.
    pub failure: Option<String>,
    /// Whose fault the failure was; absent when it did not fail or nobody knows.
    #[serde(default)]
    pub failure_kind: Option<FailureKind>,
    /// Priority.
    pub priority: i32,
    /// What is rendered.
    pub settings: RenderSettings,
    /// blake3 of scene.json.
    pub scene_hash: ContentHash,
    /// When it was submitted, milliseconds since 1970.
    pub submitted_ms: i64,
    /// When it ended, milliseconds since 1970.
    pub finished_ms: Option<i64>,
    /// Frames of the scene's animation per second; absent without one.
    #[serde(default)]
    pub fps: Option<f64>,
    /// Frames of the scene's animation; absent without one.
    #[serde(default)]
    pub animation_frames: Option<u32>,
    /// Frames whose film is final.
    #[serde(default)]
    pub frames_done: u64,
    /// Which rule ended it; of several frames the one that comes last in the list of
    /// causes. Absent before a frame is finished.
    #[serde(default)]
    pub stopped_by: Option<StopCause>,
    /// Least samples of any pixel in finished frames.
    #[serde(default)]
    pub samples_min: Option<u32>,
    /// Most samples of any pixel in finished frames.
    #[serde(default)]
    pub samples_max: Option<u32>,
    /// Samples per pixel so far, mean over all pixels and frames.
    #[serde(default)]
    pub samples_mean: f64,
    /// What a user should know about it: why it does not go on.
    #[serde(default)]
    pub note: Option<String>,
    /// Units of all frames, as far as known: with an error target those of the
    /// passes so far.
    pub units_total: u64,
    /// Units counted.
    pub units_done: u64,
    /// Samples counted, over all pixels.
    pub samples_done: u64,
    /// Share of units done, 0 to 1.
    pub progress: f64,
    /// Seconds from the first lease to the last result, or to now.
    pub elapsed_s: f64,
    /// Samples per second over `elapsed_s`.
    pub samples_per_s: f64,
    /// Core seconds that workers spent on it: time on a core, whatever else the
    /// machines did meanwhile.
    pub core_s: f64,
    /// Expected seconds to the end; absent when nothing is known.
    pub remaining_s: Option<f64>,
    /// Expected seconds until the error target is reached, if the squared error goes
    /// on falling as one over the samples; absent for a job without one, of several
    /// frames, or of which nothing is known.
    #[serde(default)]
    pub target_s: Option<f64>,
    /// The worst error (NMSE) of all finished frames, from the two halves; as
    /// long as none is finished, the last point of the first frame so far.
    pub error: Option<ErrorEstimate>,
    /// The scene's number of the frame that `error` is of.
    #[serde(default)]
    pub error_frame: Option<u32>,
    /// What `error.nmse` is expected to be with all samples; absent for a finished
    /// frame.
    #[serde(default)]
    pub nmse_at_end: Option<f64>,
    /// The newest point of error against time, of whatever frame.
    #[serde(default)]
    pub newest_error: Option<ErrorPoint>,
    /// Samples that contributed nothing because they were no light.
    pub bad_samples: u64,
    /// Paths that ended at the safety cap on depth.
    pub depth_cap_hits: u64,
    /// Results that came again with other bits: an alarm.
    #[serde(default)]
    pub unequal_results: u64,
    /// Runs that were rendered again by other workers and compared.
    #[serde(default)]
    pub audits: AuditCounts,
    /// blake3 of the integer film of each frame, in frame order; only when the
    /// job is done and has at most
    /// [`FILM_HASHES_MAX`](crate::limits::FILM_HASHES_MAX) frames. Those of
    /// larger jobs are in [`FramePage`]s.
    pub film_hashes: Vec<ContentHash>,
    /// Whom its end is told, and what became of it; absent without.
    #[serde(default)]
    pub webhook: Option<WebhookView>,
    /// Counts up with every change.
    pub rev: i64,
}

/// How the re-execution audit of a job stands, in runs.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ToSchema,
)]
pub struct AuditCounts {
    /// Chosen, and not yet decided.
    pub open: u64,
    /// Another worker had the same bits.
    pub equal: u64,
    /// A worker had other bits than two others: it was sent away, and what it had
    /// delivered was withdrawn.
    pub unequal: u64,
    /// Given up: there was no other worker to ask.
    pub skipped: u64,
}

/// What an event of a job's log is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum LogKind {
    /// Runs were handed out.
    Leased,
    /// Runs were handed out once more, since their holder may be late.
    Reissued,
    /// A result was counted.
    Counted,
    /// A worker could not render.
    Failed,
    /// A lease was not heard of in time.
    Expired,
    /// A lease was given back.
    Released,
    /// Counted runs were handed to another worker to be compared.
    AuditLeased,
    /// A repetition had the same bits.
    AuditEqual,
    /// A repetition had other bits: a further worker is asked.
    AuditUnequal,
    /// Nobody else could be asked.
    AuditSkipped,
    /// A worker was found to deliver wrong sums.
    Distrusted,
    /// Counted results were taken back and are rendered again.
    Withdrawn,
    /// The job was changed by a user: paused, resumed, tried again, its priority.
    Changed,
    /// The job was cancelled or has failed.
    Ended,
}

/// An event of a job's log.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ToSchema)]
pub struct LogEvent {
    /// The job's `rev` with this event; rises with time, with gaps.
    pub seq: i64,
    /// When, milliseconds since 1970.
    pub at_ms: i64,
    /// What it is about.
    pub kind: LogKind,
    /// The worker's instance; absent when none is concerned.
    pub worker: Option<String>,
    /// The lease's number; absent when none is concerned.
    pub lease: Option<i64>,
    /// The units, as runs; their frames are numbered from 0 within the job.
    pub runs: Vec<Run>,
    /// Milliseconds of one core that a result took; absent for other events.
    pub ms: Option<i64>,
    /// For people.
    pub text: Option<String>,
}

/// One page of a job's log.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ToSchema)]
pub struct LogPage {
    /// Newest first; the log reaches back
    /// [`LOG_CHANGES_MAX`](crate::limits::LOG_CHANGES_MAX) changes of the job.
    pub events: Vec<LogEvent>,
    /// Pass as `page_token` for the next page; absent at the end.
    pub next_page_token: Option<String>,
}

/// A frame of a job as the API shows it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, ToSchema)]
pub struct FrameView {
    /// The scene's number of the frame.
    pub frame: u32,
    /// Where it stands, as far as its job goes on.
    pub state: FrameState,
    /// Units counted.
    pub units_done: u64,
    /// Units of a frame.
    pub units_total: u64,
    /// blake3 of its integer film, once that is final.
    pub film_hash: Option<ContentHash>,
    /// Error so far, from the two halves.
    pub error: Option<ErrorEstimate>,
}

/// Where a frame stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum FrameState {
    /// No unit of it was handed out yet, or nothing came back.
    Waiting,
    /// Some units are counted.
    Running,
    /// Its film is final.
    Done,
}

/// One page of a job's frames.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, ToSchema)]
pub struct FramePage {
    /// In frame order, every frame of the job.
    pub frames: Vec<FrameView>,
    /// Pass as `page_token` for the next page; absent at the end.
    pub next_page_token: Option<String>,
}

/// The error of a frame at one moment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, ToSchema)]
pub struct ErrorPoint {
    /// The scene's number of the frame.
    pub frame: u32,
    /// When, milliseconds since 1970.
    pub at_ms: i64,
    /// Seconds since the job's first lease.
    pub elapsed_s: f64,
    /// Core seconds that workers spent on these samples of the frame.
    pub core_s: f64,
    /// Samples that were merged, over all pixels of the frame.
    pub samples_done: u64,
    /// What the two halves said.
    pub error: ErrorEstimate,
}

/// One page of a frame's error against time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, ToSchema)]
pub struct ErrorPage {
    /// In order of samples: one when they are at least 1.2 times those of the last,
    /// and one of the final film.
    pub points: Vec<ErrorPoint>,
    /// Pass as `page_token` for the next page; absent at the end.
    pub next_page_token: Option<String>,
}

/// One page of jobs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, ToSchema)]
pub struct JobPage {
    /// Newest first.
    pub jobs: Vec<JobView>,
    /// Pass as `page_token` for the next page; absent at the end.
    pub next_page_token: Option<String>,
}

/// Body of `POST /v1/assets/missing`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct MissingRequest {
    /// Hashes that the client could upload.
    pub hashes: Vec<ContentHash>,
}

/// Answer: those that the coordinator lacks.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ToSchema)]
pub struct MissingResponse {
    /// Upload these.
    pub missing: Vec<ContentHash>,
}

/// Who a worker is. The instance is random per process: a name that comes back
/// after a crash is another worker.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct WorkerId {
    /// Name for people.
    pub name: String,
    /// Random, per process.
    pub instance: String,
}

/// Body of `POST /v1/worker/leases`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LeaseRequest {
    /// Who asks.
    pub worker: WorkerId,
    /// [`crate::wire::PROTOCOL_VERSION`] of the worker.
    pub protocol: u16,
    /// Numeric build of its tracer; another one than the farm's is refused.
    pub build: String,
    /// Threads that render.
    pub threads: u32,
    /// Measured samples per second over all threads; 0 when not yet known.
    pub samples_per_s: f64,
    /// Wait at most this long for work.
    pub wait_ms: u64,
}

/// Runs handed to one worker.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, ToSchema)]
pub struct Lease {
    /// Number of the lease.
    pub id: i64,
    /// Job.
    pub job: JobId,
    /// Scene and files.
    pub manifest: Manifest,
    /// What is rendered.
    pub settings: RenderSettings,
    /// What to render, in this order.
    pub runs: Vec<Run>,
    /// Heartbeat at least this often, in milliseconds.
    pub heartbeat_ms: u64,
}

/// Body of `POST /v1/worker/heartbeat`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct HeartbeatRequest {
    /// Who.
    pub worker: WorkerId,
    /// Leases it still works on.
    pub leases: Vec<i64>,
}

/// Answer to a heartbeat.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ToSchema)]
pub struct HeartbeatResponse {
    /// Leases to drop: their job has ended or everything in them is counted.
    pub drop: Vec<i64>,
}

/// Answer to a result.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ToSchema)]
pub struct ResultResponse {
    /// The run was counted already, with the same bits.
    pub duplicate: bool,
}

/// Why a run cannot be rendered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum FailureKind {
    /// The scene or an asset is wrong: every worker would say the same.
    Scene,
    /// Something on this worker.
    Worker,
}

/// Body of `POST /v1/worker/failures`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FailureReport {
    /// Who.
    pub worker: WorkerId,
    /// Job.
    pub job: JobId,
    /// Lease.
    pub lease: i64,
    /// The run; all runs of the lease, or of its `frame`, when absent.
    #[serde(default)]
    pub run: Option<Run>,
    /// The job's number of a frame that cannot be rendered: what the lease holds of
    /// other frames stays leased.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<u32>,
    /// Whose fault.
    pub kind: FailureKind,
    /// For people.
    pub reason: String,
}

/// Body of `POST /v1/worker/release`: runs handed back undone.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ReleaseRequest {
    /// Who.
    pub worker: WorkerId,
    /// Leases given up.
    pub leases: Vec<i64>,
}

/// A worker as the API shows it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, ToSchema)]
pub struct WorkerView {
    /// Who.
    pub worker: WorkerId,
    /// Threads that render.
    pub threads: u32,
    /// Measured samples per second.
    pub samples_per_s: f64,
    /// Milliseconds since it was last heard of.
    pub silent_ms: i64,
    /// Runs it holds.
    pub runs_held: u64,
    /// Seconds for which it gets no work; absent when it may have some.
    #[serde(default)]
    pub quarantined_s: Option<i64>,
    /// Why it gets no work.
    #[serde(default)]
    pub quarantine_reason: Option<String>,
}

/// One page of workers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema, ToSchema)]
pub struct WorkerPage {
    /// Workers heard of lately, in order of their instances.
    pub workers: Vec<WorkerView>,
    /// Pass as `page_token` for the next page; absent at the end.
    pub next_page_token: Option<String>,
}

/// What a probe of the process answers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ToSchema)]
pub struct HealthView {
    /// `ok` or `ready`.
    pub status: String,
    /// Version of the coordinator.
    pub version: String,
}

/// An error, by RFC 9457 (`application/problem+json`).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ToSchema)]
pub struct Problem {
    /// Stable name of the kind of error: `urn:shearwater:problem:...`.
    #[serde(rename = "type")]
    pub kind: String,
    /// Short text of the kind.
    pub title: String,
    /// HTTP status.
    pub status: u16,
    /// What happened, where, and what to do about it.
    pub detail: String,
}
