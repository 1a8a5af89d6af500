//! The store: every transition is one SQL statement or one short transaction.
//!
//! SQL is the only truth. The statements are BIGINT and TEXT only and run on
//! SQLite and PostgreSQL alike; the engine follows from the URL. SQLite writes
//! through a pool of one connection (more of them only wait for each other,
//! with worse tails) and reads through another. Pixel data are objects
//! ([`crate::objects`]), written before the row that names them.

mod asset_use;
mod assets;
mod audits;
mod census;
mod claim;
mod commit;
mod delete;
mod error;
mod errors;
mod extend;
mod fail;
mod folds;
mod frames;
mod fresh;
mod hear;
mod idem;
mod jobs;
mod leases;
mod levels;
mod lists;
mod log;
mod open;
mod order;
mod queue;
mod repeat;
mod rows;
mod steer;
mod submit;
mod sweep;
mod time_up;
mod tokens;
mod url;
mod webhooks;
mod withdraw;
mod workers;

pub use asset_use::COUNTED_TABLES;
pub use audits::HoldingAudit;
pub use census::Census;
pub use claim::{ClaimQuery, Claimed};
pub use commit::{CommitOutcome, PartRecord};
pub use error::StoreError;
pub use errors::{ERROR_POINTS_MAX, ErrorRow, Folded};
pub use folds::{FoldInput, FoldTask, FrameTile, TileState};
pub use frames::{FrameEnd, FrameRow};
pub use hear::Beat;
pub use idem::{IdempotencyKey, Repetition};
pub use jobs::JobFilter;
pub use leases::LeaseRow;
pub use levels::{NextPass, PassState};
pub use open::{Engine, Store};
pub use queue::Queued;
pub use rows::{Ended, JobRow};
pub use submit::{NewJob, Submitted};
pub use tokens::TokenRow;
pub use url::DatabaseUrl;
pub use webhooks::{DueWebhook, NewWebhook, WebhookRow};
pub use withdraw::Withdrawn;
pub use workers::WorkerRow;
