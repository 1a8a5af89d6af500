//! The farm's decisions: pure functions of a snapshot and of `now_ms`.
//!
//! How large a lease is, which job is served, what is handed out once more at
//! the end, when a unit or a worker is given up. No clock, socket or database.

mod adaptive;
mod audit;
mod choose;
mod deadline;
mod endgame;
mod extend;
mod failure;
mod forecast;
mod heartbeat;
mod lease_size;
mod runs;
mod share_out;
mod state;
mod webhook;

pub use adaptive::{TileAtLevel, Verdict, verdict};
pub use audit::{AuditVerdict, Claim, WHOLE_PPM, WaitingAudit, audit_waits, is_audited, judge};
pub use choose::{LiveJob, next_job};
pub use deadline::{frame_deadline_ms, frames_out_of_time, lease_target_ms};
pub use endgame::{Helper, OpenLease, runs_to_reissue};
pub use extend::{ExtendError, extended};
pub use failure::{
    QUARANTINE_MS, UnitFailures, WorkerStreak, bad_samples_reason, should_quarantine, too_many_bad,
    unit_is_poison,
};
pub use forecast::{nmse_at, samples_to_error};
pub use heartbeat::{heartbeat_ms, lease_ttl_ms};
pub use lease_size::{Sizing, lease_units};
pub use runs::{Unit, cut_runs};
pub use share_out::{Failed, Wish, share_out};
pub use state::{JobCounts, job_state};
pub use webhook::{TRIES_MS, TRY_MS, Told, ahead_ms_max, pause_ms, webhook_state};
