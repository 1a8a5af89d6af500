//! What decisions are made of: as it was a moment ago.

use crate::app::App;
use crate::farm::{LiveJob, OpenLease};
use crate::presence::Present;
use crate::store::StoreError;
use shearwater_shared::job::JobId;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Age from which it is read again. What this coordinator hands out is noted in it;
/// whatever makes work forgets it; what others do may be so late.
const AGE_MAX: Duration = Duration::from_millis(200);
/// Leased units that the endgame looks at; more means that it is no endgame.
const ENDGAME_UNITS_MAX: u32 = 4096;

/// The farm, read lately.
#[derive(Debug, Default)]
pub(super) struct Snapshot {
    read: Option<Instant>,
    /// Jobs that may be served.
    pub(super) jobs: Vec<LiveJob>,
    /// Counted runs that wait for a worker to be compared.
    pub(super) audits: u64,
    /// Leases that are waited for, of jobs at their end.
    endgames: BTreeMap<JobId, Arc<Vec<OpenLease>>>,
}

impl Snapshot {
    /// Something changed.
    pub(super) fn forget(&mut self) {
        self.read = None;
    }

    /// The leases of a job changed.
    pub(super) fn forget_endgame(&mut self, job: JobId) {
        self.endgames.remove(&job);
    }

    /// Read it, if it is too old. All workers are of the farm's build: others are refused.
    pub(super) async fn renew(&mut self, app: &App) -> Result<(), StoreError> {
        if self.read.is_some_and(|read| read.elapsed() < AGE_MAX) {
            return Ok(());
        }
        let read = Instant::now();
        self.read = None;
        self.endgames.clear();
        self.jobs = app.store.live_jobs(&app.config.build).await?;
        self.audits = app.store.free_audits().await?;
        self.read = Some(read);
        Ok(())
    }

    /// Leases of a job that are waited for.
    pub(super) async fn endgame(
        &mut self,
        app: &App,
        present: &Present,
        id: JobId,
    ) -> Result<Arc<Vec<OpenLease>>, StoreError> {
        if let Some(known) = self.endgames.get(&id) {
            return Ok(Arc::clone(known));
        }
        let leases = Arc::new(read_endgame(app, present, id).await?);
        self.endgames.insert(id, Arc::clone(&leases));
        Ok(leases)
    }
}

async fn read_endgame(
    app: &App,
    present: &Present,
    id: JobId,
) -> Result<Vec<OpenLease>, StoreError> {
    let leased = app.store.leased_units(id, ENDGAME_UNITS_MAX).await?;
    let Some(job) = app.known.job(&app.store, id).await? else {
        return Ok(Vec::new());
    };
    let plan = job.plan();
    let leases = app.store.open_leases(id).await?.into_iter();
    Ok(leases
        .map(|lease| OpenLease {
            samples_per_s: present
                .get(&lease.worker)
                .map_or(0.0, |w| w.milli_samples_per_s as f64 / 1000.0),
            worker: lease.worker,
            created_ms: lease.created_ms,
            runs: lease
                .runs
                .iter()
                .map(|run| {
                    let waited_for = (run.block0..run.block1)
                        .all(|block| leased.contains(&(run.frame, run.tile, block)));
                    (*run, plan.run_samples(run), waited_for)
                })
                .collect(),
        })
        .collect())
}
