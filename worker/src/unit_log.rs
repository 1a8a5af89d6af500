//! Log lines about units: the same fields as in a coordinator's log, so that a unit is
//! found in both by `job`, `frame`, `tile`, `block0` and `block1`, and a lease by `lease`.

use crate::held::HeldLease;
use shearwater_shared::plan::Run;
use tracing::Span;

/// What is logged within it belongs to a unit. Numbers of frames are the job's own, from 0.
pub(crate) fn span(lease: &HeldLease, run: &Run) -> Span {
    tracing::info_span!(
        "unit",
        job = lease.job.0,
        lease = lease.id,
        frame = run.frame,
        tile = run.tile,
        block0 = run.block0,
        block1 = run.block1,
    )
}
