//! Thousands of workers that render nothing, for measuring a coordinator.
//!
//! Each is a task with connections of its own that speaks the real protocol through
//! the real worker's client: long polls, the next lease before the present one ends,
//! heartbeats, results with sums that are right ([`film_hash`]), failures. It sleeps
//! where a worker renders.

mod dice;
mod histogram;
mod light;
mod member;
mod queue;
mod stats;
mod units;

pub use crate::traffic::TrafficSum;
pub use histogram::Histogram;
pub use light::film_hash;
pub use stats::{Counts, Seen, Stats};

use crate::connection::Access;
use crate::error::WorkerError;
use crate::phase::{Phase, sleep_unless};
use dice::Draw;
use member::{Common, Life};
use shearwater_shared::job::{JobId, RenderSettings};
use shearwater_shared::plan::{Plan, Run};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::watch;
use tokio::task::JoinSet;

/// Pause before another worker comes in the place of one that vanished.
const REBIRTH: Duration = Duration::from_secs(1);
/// Slow workers take so many times as long.
const SLOWNESS: f64 = 3.0;

/// What the workers of a simulation are like.
#[derive(Clone, Copy, Debug)]
pub struct Habits {
    /// Milliseconds of a thread for one unit of the common worker.
    pub unit_ms: f64,
    /// How much the time of a run differs from that, up and down: 0 to 1.
    pub jitter: f64,
    /// Share of workers that take three times as long, 0 to 1.
    pub slow_share: f64,
    /// Share of runs that end in a report of failure, 0 to 1. No unit fails twice.
    pub failure_rate: f64,
    /// Share of runs at whose end the worker vanishes without a word, 0 to 1.
    pub vanish_rate: f64,
    /// Render threads of each worker.
    pub threads: u32,
    /// What chance follows.
    pub seed: u64,
}

impl Habits {
    /// How long a run takes; `place` tells it from all others of the simulation.
    fn time(&self, worker: u32, run: &Run, place: [u64; 3]) -> Duration {
        let slow = dice::share(self.seed, Draw::Slow, [worker.into(), 0, 0]) < self.slow_share;
        let pace = if slow { SLOWNESS } else { 1.0 };
        let jitter = 2.0 * dice::share(self.seed, Draw::Time, place) - 1.0;
        let ms = self.unit_ms * pace * (1.0 + self.jitter * jitter);
        let units = f64::from(run.block1.saturating_sub(run.block0));
        Duration::try_from_secs_f64(units * ms / 1000.0).unwrap_or(Duration::ZERO)
    }
}

/// A crowd of simulated workers.
#[derive(Clone, Debug)]
pub struct CrowdConfig {
    /// Where the coordinator listens.
    pub coordinator_url: String,
    /// With what right, and whom to trust.
    pub access: Access,
    /// How many there are.
    pub workers: u32,
    /// Time over which they come, evenly.
    pub ramp: Duration,
    /// What they are like.
    pub habits: Habits,
    /// The only job that they work on, once it is known; work of others is handed
    /// back.
    pub job: watch::Receiver<Option<JobId>>,
    /// Its settings.
    pub settings: RenderSettings,
}

/// Simulated workers at work; they end when it is dropped.
#[derive(Debug)]
pub struct Crowd {
    stats: Arc<Stats>,
    phase: watch::Sender<Phase>,
    members: JoinSet<Result<(), WorkerError>>,
}

impl Crowd {
    /// Start the workers.
    #[must_use]
    pub fn start(config: CrowdConfig) -> Self {
        let plan = Plan::new(&config.settings);
        let stats = Arc::new(Stats::new(&plan, config.settings.frames));
        let (phase, rx) = watch::channel(Phase::Working);
        let (workers, ramp) = (config.workers, config.ramp);
        let common = Arc::new(Common {
            config,
            plan,
            stats: stats.clone(),
        });
        let mut members = JoinSet::new();
        for number in 0..workers {
            let wait = ramp.mul_f64(f64::from(number) / f64::from(workers));
            let (common, rx) = (common.clone(), rx.clone());
            members.spawn(async move {
                if sleep_unless(&rx, Phase::Draining, wait).await {
                    lives(&common, number, rx).await?;
                }
                Ok(())
            });
        }
        Self {
            stats,
            phase,
            members,
        }
    }

    /// What they have seen so far.
    #[must_use]
    pub const fn stats(&self) -> &Arc<Stats> {
        &self.stats
    }

    /// Send all of them home, without a word to the coordinator.
    ///
    /// # Errors
    /// The address or the credentials were no use to any of them.
    pub async fn stop(mut self) -> Result<(), WorkerError> {
        self.phase.send_replace(Phase::Stopped);
        while let Some(ended) = self.members.join_next().await {
            // One that panicked has said so.
            ended.unwrap_or(Ok(()))?;
        }
        Ok(())
    }
}

/// Live, vanish, and come again as another.
async fn lives(
    common: &Arc<Common>,
    number: u32,
    phase: watch::Receiver<Phase>,
) -> Result<(), WorkerError> {
    for life in 0u32.. {
        // Boxed: a member that has not come yet should cost nothing.
        let life = Box::pin(member::live(common, number, life, phase.clone()));
        if life.await? == Life::Over || !sleep_unless(&phase, Phase::Draining, REBIRTH).await {
            break;
        }
    }
    Ok(())
}
