//! Working, draining, stopped: how a worker leaves.

use std::time::Duration;
use tokio::sync::watch;

/// How far the worker has come towards its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Phase {
    /// Takes leases and renders.
    Working,
    /// Takes nothing new; delivers what is finished.
    Draining,
    /// Gives up what is not yet delivered.
    Stopped,
}

/// What tasks watch.
pub(crate) type PhaseRx = watch::Receiver<Phase>;

/// Wait until `phase` is reached.
pub(crate) async fn reached(rx: &PhaseRx, phase: Phase) {
    // An error means that the sender is gone, which is the end as well.
    let _ = rx.clone().wait_for(|now| *now >= phase).await;
}

/// Sleep, or return `false` early once `phase` is reached.
pub(crate) async fn sleep_unless(rx: &PhaseRx, phase: Phase, time: Duration) -> bool {
    tokio::select! {
        () = tokio::time::sleep(time) => true,
        () = reached(rx, phase) => false,
    }
}
