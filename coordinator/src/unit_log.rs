//! Log lines about units: the same fields as in a worker's log, so that a unit is found in
//! both by `job`, `frame`, `tile`, `block0` and `block1`, and a lease by `lease`.
//!
//! Numbers of frames are the job's own, from 0, as in its log (`GET /v1/jobs/ID/log`).

use shearwater_shared::api::{Lease, WorkerId};
use shearwater_shared::wire::PartUpload;
use tracing::Span;

/// What is logged while a result is handled belongs to its unit.
pub(crate) fn span(part: &PartUpload) -> Span {
    let run = &part.run;
    tracing::info_span!(
        "unit",
        job = part.job.0,
        lease = part.lease,
        frame = run.frame,
        tile = run.tile,
        block0 = run.block0,
        block1 = run.block1,
        worker = part.worker,
    )
}

/// A worker gets a lease: a line for each of its runs, of which there are few
/// ([`shearwater_shared::limits::LEASE_RUNS_MAX`]).
pub(crate) fn leased(lease: &Lease, worker: &WorkerId) {
    if !tracing::enabled!(tracing::Level::DEBUG) {
        return;
    }
    for run in &lease.runs {
        tracing::debug!(
            job = lease.job.0,
            lease = lease.id,
            frame = run.frame,
            tile = run.tile,
            block0 = run.block0,
            block1 = run.block1,
            worker = worker.instance,
            name = worker.name,
            "leased"
        );
    }
}
