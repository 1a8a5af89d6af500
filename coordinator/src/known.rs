//! Jobs as they were a moment ago.
//!
//! Every lease and every result needs its job: the plan, the scene, what it is checked
//! against. They hardly ever change, and reading them a thousand times a second would
//! be most of the work. Whatever must not be out of date is asked of the database.

use crate::store::{JobRow, Store, StoreError};
use shearwater_shared::job::JobId;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Age from which a job is read again.
const AGE_MAX: Duration = Duration::from_secs(1);
/// Jobs that are kept: those with work under way; a manifest is some kilobytes.
const JOBS_MAX: usize = 256;

/// The jobs that were read lately.
#[derive(Debug, Default)]
pub(crate) struct Known {
    jobs: Mutex<BTreeMap<JobId, (Instant, Arc<JobRow>)>>,
}

impl Known {
    fn jobs(&self) -> MutexGuard<'_, BTreeMap<JobId, (Instant, Arc<JobRow>)>> {
        // A panic elsewhere leaves the values whole.
        self.jobs.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The job as it was at most a second ago.
    ///
    /// # Errors
    /// The database failed.
    pub(crate) async fn job(
        &self,
        store: &Store,
        id: JobId,
    ) -> Result<Option<Arc<JobRow>>, StoreError> {
        let known = self.jobs().get(&id).cloned();
        match known {
            Some((read, job)) if read.elapsed() < AGE_MAX => Ok(Some(job)),
            _ => self.job_now(store, id).await,
        }
    }

    /// The job as it is.
    ///
    /// # Errors
    /// The database failed.
    pub(crate) async fn job_now(
        &self,
        store: &Store,
        id: JobId,
    ) -> Result<Option<Arc<JobRow>>, StoreError> {
        let read = Instant::now();
        let job = store.job(id).await?.map(Arc::new);
        let mut jobs = self.jobs();
        match &job {
            Some(job) => jobs.insert(id, (read, Arc::clone(job))),
            None => jobs.remove(&id),
        };
        while jobs.len() > JOBS_MAX {
            let oldest = jobs.iter().min_by_key(|(_, (read, _))| *read);
            let Some(oldest) = oldest.map(|(id, _)| *id) else {
                break;
            };
            jobs.remove(&oldest);
        }
        Ok(job)
    }
}
