//! The farm as its store has it, read when somebody asks, and not too often.

use crate::app::{App, now_ms};
use crate::store::{Census, StoreError};
use prometheus_client::encoding::EncodeLabelSet;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::registry::Registry;
use shearwater_shared::job::JobState;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::Mutex;
use tokio::time::Instant;

/// A census is good for so long at least, however many ask.
const FRESH: Duration = Duration::from_secs(1);
/// And for so many times what it took: counting costs the database at most a twentieth of
/// one connection.
const FRESH_FACTOR: u32 = 20;
/// Longest wait for the database: below the ten seconds after which Prometheus gives up
/// on all of it.
const TIMEOUT: Duration = Duration::from_secs(2);
/// A worker counts as present when it was heard of within this time: it asks for work
/// more often ([`shearwater_shared::limits::LEASE_WAIT_MS_MAX`]).
const PRESENT_MS: i64 = 30_000;

/// The last census; whoever asks while one is taken waits for it.
#[derive(Debug, Default)]
pub(super) struct CensusCache(Mutex<Option<Taken>>);

#[derive(Debug)]
struct Taken {
    good_until: Instant,
    census: Option<Arc<Census>>,
}

impl CensusCache {
    /// How the farm looks; `None` when the database does not say.
    pub(super) async fn now(&self, app: &App) -> Option<Arc<Census>> {
        let mut last = self.0.lock().await;
        let began = Instant::now();
        if let Some(taken) = last.as_ref().filter(|taken| taken.good_until > began) {
            return taken.census.clone();
        }
        let census = match take(app).await {
            Ok(census) => census.map(Arc::new),
            Err(error) => {
                tracing::warn!(%error, "census for /metrics");
                app.troubles.suspect();
                None
            }
        };
        let cost = began.elapsed();
        *last = Some(Taken {
            good_until: Instant::now() + FRESH.max(cost * FRESH_FACTOR),
            census: census.clone(),
        });
        census
    }
}

async fn take(app: &App) -> Result<Option<Census>, StoreError> {
    if app.troubles.database_is_away() {
        return Ok(None);
    }
    let now_ms = now_ms();
    let census = app.store.census(now_ms - PRESENT_MS, now_ms);
    match tokio::time::timeout(TIMEOUT, census).await {
        Ok(census) => census.map(Some),
        Err(_) => {
            tracing::warn!(timeout = ?TIMEOUT, "no census for /metrics: the database takes too long");
            Ok(None)
        }
    }
}

#[derive(Clone, Debug, PartialEq, Eq, Hash, EncodeLabelSet)]
struct State {
    state: &'static str,
}

/// Gauges of a census; without one they are absent, so that nobody takes old numbers for
/// those of now.
pub(super) fn register(registry: &mut Registry, census: Option<&Census>) {
    let known = Gauge::<i64>::default();
    known.set(i64::from(census.is_some()));
    registry.register(
        "farm_known",
        "1 if the numbers of jobs, units and workers could be read; otherwise they are absent",
        known,
    );
    let Some(census) = census else { return };
    let mut add = |name: &str, help: &str, values: &[(&'static str, u64)]| {
        let family = Family::<State, Gauge>::default();
        for &(state, value) in values {
            let gauge = family.get_or_create_owned(&State { state });
            gauge.set(i64::try_from(value).unwrap_or(i64::MAX));
        }
        registry.register(name, help, family);
    };
    let jobs: Vec<_> = census
        .jobs
        .iter()
        .map(|&(state, n)| (name(state), n))
        .collect();
    add("jobs", "Jobs by state; deleted ones are gone", &jobs);
    let units = [
        ("pending", census.units_pending),
        ("leased", census.units_leased),
        ("done", census.units_done),
    ];
    add(
        "units",
        "Units of jobs that have not ended, by state",
        &units,
    );
    let workers = [
        ("present", census.workers_present),
        ("quarantined", census.workers_quarantined),
    ];
    add(
        "workers",
        "Workers heard of within 30 s: those that may work, and those that get nothing",
        &workers,
    );
    for (name, help, value) in [
        (
            "worker_threads",
            "Render threads of the workers that may work",
            census.threads,
        ),
        (
            "leases_open",
            "Leases that workers hold",
            census.leases_open,
        ),
        (
            "audits_open",
            "Counted runs that are to be compared",
            census.audits_open,
        ),
        (
            "parts_unfolded",
            "Counted results that wait to be folded into their tiles",
            census.parts_unfolded,
        ),
    ] {
        let gauge = Gauge::<i64>::default();
        gauge.set(i64::try_from(value).unwrap_or(i64::MAX));
        registry.register(name, help, gauge);
    }
}

const fn name(state: JobState) -> &'static str {
    match state {
        JobState::Queued => "queued",
        JobState::Running => "running",
        JobState::Paused => "paused",
        JobState::Done => "done",
        JobState::Cancelled => "cancelled",
        JobState::Failed => "failed",
    }
}
