//! Heartbeats: sent from the asynchronous side, however busy the threads are.

use crate::client::{CallError, Client};
use crate::held::Held;
use crate::phase::{Phase, PhaseRx, sleep_unless};
use shearwater_shared::api::{HeartbeatRequest, WorkerId};
use std::time::{Duration, Instant};

/// How often to look whether a heartbeat is due: a new lease may want shorter
/// ones than the last.
const LOOK: Duration = Duration::from_millis(250);
/// Most often, whatever a lease asks.
const SHORTEST: Duration = Duration::from_millis(20);

/// Keep the leases in `held` alive until the worker stops.
pub(crate) async fn beat(client: Client, worker: WorkerId, held: &Held, phase: PhaseRx) {
    let mut last = Instant::now();
    loop {
        // Twice as often as asked: one may get lost.
        let every = || held.heartbeat().map(|asked| (asked / 2).max(SHORTEST));
        let pause = every().map_or(LOOK, |every| every.min(LOOK));
        if !sleep_unless(&phase, Phase::Stopped, pause).await {
            return;
        }
        // Looked up again: leases come and go during the pause.
        if every().is_none_or(|every| last.elapsed() + pause / 2 < every) {
            continue;
        }
        let leases = held.ids();
        last = Instant::now();
        let request = HeartbeatRequest {
            worker: worker.clone(),
            leases,
        };
        match client.heartbeat(&request).await {
            Ok(answer) => answer.drop.iter().for_each(|&lease| {
                tracing::info!(lease, "lease dropped by the coordinator");
                held.abandon(lease);
            }),
            Err(CallError::Unavailable(why) | CallError::Damaged(why)) => {
                tracing::debug!(why, "heartbeat not heard");
            }
            Err(CallError::Refused(problem)) => {
                tracing::warn!(problem.detail, "heartbeat refused");
            }
        }
    }
}
