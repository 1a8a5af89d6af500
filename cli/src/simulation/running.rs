//! A simulation from its start to its report.

use super::audit::audit;
use super::child::{OwnCoordinator, Start};
use super::gauge::{Gauge, machine_busy_s};
use super::report::{Facts, Report, Usage, quarters};
use super::work;
use crate::api::Api;
use crate::exit::CliError;
use shearwater_shared::api::JobView;
use shearwater_shared::job::{JobId, RenderSettings};
use shearwater_worker::connection::Access;
use shearwater_worker::simulate::{Crowd, CrowdConfig, Habits, Seen};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use tokio::sync::watch;

/// How often the job and the coordinator are looked at.
const LOOK: Duration = Duration::from_secs(1);
/// Seconds after which the rate of units is a steady one: the first leases are
/// small, until the workers' speed is known.
const SETTLE_S: f64 = 10.0;
/// Looks in a row at which the coordinator may fail to answer: it is under load.
const SILENT_LOOKS_MAX: u32 = 60;
/// Jobs of which one that has not ended is looked for.
const JOBS_LOOKED_AT: usize = 200;

/// What is to be simulated.
#[derive(Clone, Debug)]
pub(crate) struct SimulationPlan {
    /// Running coordinator; none is one of our own.
    pub(crate) url: Option<String>,
    /// For that one.
    pub(crate) access: Access,
    /// Program of the own coordinator; none is this one.
    pub(crate) program: Option<PathBuf>,
    /// Where the own coordinator's stores are; none is its default.
    pub(crate) data: Option<PathBuf>,
    pub(crate) database: Option<String>,
    pub(crate) objects: Option<String>,
    /// Share of runs that the own coordinator audits; none is its default.
    pub(crate) audit: Option<f64>,
    pub(crate) workers: u32,
    /// Time over which the workers come.
    pub(crate) ramp: Duration,
    /// How long they wait before there is a job.
    pub(crate) idle: Duration,
    /// Longest time of work.
    pub(crate) bound: Option<Duration>,
    pub(crate) settings: RenderSettings,
    pub(crate) habits: Habits,
}

/// Under way.
pub(crate) struct Running {
    plan: SimulationPlan,
    api: Api,
    own: Option<OwnCoordinator>,
    crowd: Crowd,
    job: JobId,
    coordinator: Option<Gauge>,
    simulator: Gauge,
    began: Moment,
    submit_s: f64,
    idle_cores: Option<f64>,
}

/// How a simulation came to its end.
#[derive(Debug)]
pub(crate) struct EndOfWork {
    job: JobView,
    /// When the last unit was counted or the time was up.
    counted: Moment,
    cut_short: bool,
}

/// Clocks at one moment.
#[derive(Clone, Copy, Debug)]
struct Moment {
    at: Instant,
    coordinator_s: f64,
    simulator_s: f64,
    machine_s: f64,
}

impl Moment {
    fn now(coordinator: Option<&Gauge>, simulator: &Gauge) -> Self {
        let cpu_s = |gauge: &Gauge| gauge.now().map_or(0.0, |now| now.cpu_s);
        Self {
            at: Instant::now(),
            coordinator_s: coordinator.map_or(0.0, cpu_s),
            simulator_s: cpu_s(simulator),
            machine_s: machine_busy_s().unwrap_or(0.0),
        }
    }
}

impl Running {
    /// Start the coordinator, let the workers come, submit the job.
    pub(crate) async fn start(plan: SimulationPlan, folder: &Path) -> Result<Self, CliError> {
        let own = own_coordinator(&plan, folder).await?;
        let (url, access) = match (&own, &plan.url) {
            (None, Some(url)) => (url.clone(), plan.access.clone()),
            (own, _) => {
                let url = own.as_ref().map(|own| own.url.clone());
                (url.unwrap_or_default(), Access::default())
            }
        };
        let api = Api::new(&url, &access)?;
        refuse_company(&api).await?;
        let bundle = work::scene(folder)?;
        let coordinator = own.as_ref().map(|own| Gauge::of(own.pid));
        let simulator = Gauge::of(std::process::id());
        let (known, job) = watch::channel(None);
        let config = CrowdConfig {
            coordinator_url: url,
            access,
            workers: plan.workers,
            ramp: plan.ramp,
            habits: plan.habits,
            job,
            settings: plan.settings,
        };
        // Idle workers wait before there is a job; else the job is there first.
        let mut waiting = None;
        let mut idle_cores = None;
        if !plan.idle.is_zero() {
            waiting = Some(Crowd::start(config.clone()));
            tokio::time::sleep(plan.ramp).await;
            let before = Moment::now(coordinator.as_ref(), &simulator);
            tokio::time::sleep(plan.idle).await;
            let after = Moment::now(coordinator.as_ref(), &simulator);
            let used_s = after.coordinator_s - before.coordinator_s;
            idle_cores = Some(used_s / (after.at - before.at).as_secs_f64());
        }
        let since = Instant::now();
        let settings = work::to_override(&plan.settings);
        let name = Some("simulated".to_owned());
        let job = api.submit(&bundle, name, settings, 0, None).await?.id;
        let submit_s = since.elapsed().as_secs_f64();
        known.send_replace(Some(job));
        let began = Moment::now(coordinator.as_ref(), &simulator);
        Ok(Self {
            crowd: waiting.unwrap_or_else(|| Crowd::start(config)),
            plan,
            api,
            own,
            job,
            coordinator,
            simulator,
            began,
            submit_s,
            idle_cores,
        })
    }

    fn moment(&self) -> Moment {
        Moment::now(self.coordinator.as_ref(), &self.simulator)
    }

    /// Look on until the job ends or the time is up.
    pub(crate) async fn watch(&mut self) -> Result<EndOfWork, CliError> {
        let mut counted = None;
        let mut silent = 0;
        loop {
            tokio::time::sleep(LOOK).await;
            if let Some(own) = &mut self.own {
                own.check()?;
            }
            if let Some(gauge) = &mut self.coordinator {
                gauge.take();
            }
            let job = match self.api.job(self.job).await {
                Err(CliError::Unreachable { .. } | CliError::Silent { .. })
                    if silent < SILENT_LOOKS_MAX =>
                {
                    silent += 1;
                    continue;
                }
                job => job?,
            };
            silent = 0;
            if let Some(why) = self.crowd.stats().refusal() {
                return Err(CliError::Simulation(format!("a worker is refused: {why}")));
            }
            tracing::info!(units = job.units_done, of = job.units_total, "simulating");
            let up = self
                .plan
                .bound
                .is_some_and(|bound| self.began.at.elapsed() >= bound);
            if counted.is_none() && (job.units_done >= job.units_total || up) {
                counted = Some(self.moment());
            }
            if job.done || up {
                let counted = counted.unwrap_or_else(|| self.moment());
                return Ok(EndOfWork {
                    cut_short: !job.done,
                    counted,
                    job,
                });
            }
        }
    }

    /// Send the workers home, audit, report and clean up, in this order. The second
    /// is what became of the cleaning.
    pub(crate) async fn finish(
        self,
        ended: Result<EndOfWork, CliError>,
    ) -> (Result<Report, CliError>, Result<(), CliError>) {
        let Self { crowd, own, .. } = self;
        let stats = crowd.stats().clone();
        let started = stats.started();
        let stopped = crowd.stop().await;
        let about = About {
            plan: self.plan,
            began: self.began,
            submit_s: self.submit_s,
            idle_cores: self.idle_cores,
            coordinator: self.coordinator,
            started,
            seen: stats.seen(),
        };
        let report = match (ended, stopped) {
            (Err(error), _) => Err(error),
            (Ok(_), Err(refused)) => Err(refused.into()),
            (Ok(end), Ok(())) => about.report(&self.api, end).await,
        };
        let cleaned = match own {
            // Its store goes with it, or is to be kept as it is.
            Some(own) => {
                own.end().await;
                Ok(())
            }
            None => remove(&self.api, self.job).await,
        };
        (report, cleaned)
    }
}

/// What is known when the workers have gone.
struct About {
    plan: SimulationPlan,
    began: Moment,
    submit_s: f64,
    idle_cores: Option<f64>,
    coordinator: Option<Gauge>,
    /// When the first worker came.
    started: Instant,
    seen: Seen,
}

impl About {
    async fn report(self, api: &Api, end: EndOfWork) -> Result<Report, CliError> {
        // As it is now: the last results may have come since.
        let job = api.job(end.job.id).await?;
        let audit = audit(api, &job, &self.seen.counts, !end.cut_short).await?;
        let last_counted = (self.started + self.seen.last_counted).max(self.began.at);
        let work_s = (last_counted - self.began.at).as_secs_f64();
        let SimulationPlan {
            workers, habits, ..
        } = self.plan;
        let threads = f64::from(workers) * f64::from(habits.threads);
        let simulator_cpu_s = end.counted.simulator_s - self.began.simulator_s;
        let coordinator_cpu_s = end.counted.coordinator_s - self.began.coordinator_s;
        let machine_cpu_s = end.counted.machine_s - self.began.machine_s;
        let facts = Facts {
            workers,
            threads: habits.threads,
            frames: self.plan.settings.frames,
            units: job.units_total,
            unit_ms: habits.unit_ms,
            seed: habits.seed,
            submit_s: self.submit_s,
            work_s,
            finish_s: finish_s(&job, last_counted),
            efficiency: job.core_s / (threads * work_s.max(1e-3)),
            simulator_cpu_s,
            simulator_rss_max_bytes: Gauge::of(std::process::id()).rss_max_bytes(),
            others_cpu_s: (machine_cpu_s - simulator_cpu_s - coordinator_cpu_s).max(0.0),
            cut_short: end.cut_short,
        };
        let usage = self.coordinator.as_ref().map(|gauge| Usage {
            rss_max_bytes: gauge.rss_max_bytes(),
            rss_quarters_bytes: quarters(gauge.samples(), self.began.at, last_counted),
            cpu_s: coordinator_cpu_s,
            cpu_s_per_1000_units: coordinator_cpu_s * 1000.0 / job.units_done.max(1) as f64,
            files_max: gauge.samples().iter().map(|s| s.files).max().unwrap_or(0),
            idle_cores: self.idle_cores,
        });
        Ok(Report::new(facts, &self.seen, self.steady(), usage, audit))
    }

    /// The first and the last second, since the first worker came, in which the farm
    /// was in full work.
    fn steady(&self) -> (usize, usize) {
        let ramped = self.plan.ramp.as_secs_f64();
        let submitted = self.began.at.saturating_duration_since(self.started);
        let from_s = ramped.max(submitted.as_secs_f64()) + SETTLE_S;
        let to = self.seen.all_given.unwrap_or(self.seen.last_counted);
        (from_s.ceil() as usize, to.as_secs() as usize)
    }
}

/// From the last result to the end of the job: exact where the coordinator has the
/// clock of this machine.
fn finish_s(job: &JobView, last_counted: Instant) -> Option<f64> {
    let ended = UNIX_EPOCH + Duration::from_millis(u64::try_from(job.finished_ms?).ok()?);
    let since_end = SystemTime::now().duration_since(ended).ok()?;
    let since_counted = last_counted.elapsed();
    Some(since_counted.saturating_sub(since_end).as_secs_f64())
}

/// A coordinator of our own, unless another one is named.
async fn own_coordinator(
    plan: &SimulationPlan,
    folder: &Path,
) -> Result<Option<OwnCoordinator>, CliError> {
    if plan.url.is_some() {
        return Ok(None);
    }
    let data = plan.data.clone().unwrap_or_else(|| folder.join("data"));
    let start = Start {
        program: plan.program.as_deref(),
        database: plan.database.as_deref(),
        objects: plan.objects.as_deref(),
        audit: plan.audit,
        data: &data,
    };
    OwnCoordinator::start(start).await.map(Some)
}

/// Refuse a farm that is in use: its jobs would wait for workers that render nothing.
async fn refuse_company(api: &Api) -> Result<(), CliError> {
    let page = api.jobs(JOBS_LOOKED_AT, None).await?;
    match page.jobs.iter().find(|job| !job.done) {
        Some(job) => Err(CliError::Simulation(format!(
            "job {} of this farm has not ended: simulated workers would be in the way of real ones",
            job.id
        ))),
        None => Ok(()),
    }
}

/// Take the job away from a coordinator that is not ours.
async fn remove(api: &Api, job: JobId) -> Result<(), CliError> {
    if !api.job(job).await?.done {
        api.cancel(job).await?;
    }
    api.delete(job).await
}
