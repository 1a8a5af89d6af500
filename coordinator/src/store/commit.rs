//! Results are counted, each once.
//!
//! Results that come at the same time are counted by one transaction: all of them or
//! none. Whatever is unusual about one of them sends each its own way.

use super::audits;
use super::error::{Attempt, StoreError};
use super::lists::{Listed, list, listed};
use super::log::{Event, log_all};
use super::open::{Engine, Store};
use super::rows::{big, int, json};
use crate::metrics::Transaction as Kind;
use shearwater_shared::api::LogKind;
use shearwater_shared::hash::ContentHash;
use shearwater_shared::job::JobId;
use shearwater_shared::plan::Run;
use sqlx::{Any, Executor, Transaction};
use std::collections::{BTreeMap, BTreeSet};

/// One run's result. Its object is durable before this is committed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PartRecord {
    /// Job.
    pub job: JobId,
    /// The run.
    pub run: Run,
    /// Lease under which it was rendered; only to free what it still holds.
    pub lease: i64,
    /// Worker (instance).
    pub worker: String,
    /// Numeric build that rendered it.
    pub build: String,
    /// Hash of the sums, for comparison with repetitions.
    pub sums_hash: ContentHash,
    /// Name of the object that holds the sums.
    pub object: String,
    /// Samples over all pixels.
    pub samples: u64,
    /// Microseconds of cores.
    pub core_us: u64,
    /// Bad samples.
    pub bad_samples: u64,
    /// Paths that met the cap on depth.
    pub depth_cap_hits: u64,
    /// Whether another worker is to render it again ([`crate::farm::is_audited`]).
    pub audited: bool,
}

/// What became of a result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CommitOutcome {
    /// Counted now, all units of the run.
    Counted,
    /// Counted before, with the same bits as far as they can be compared.
    Duplicate,
    /// Counted before with other bits: an alarm.
    Unequal {
        /// Worker whose bits were counted.
        first_worker: String,
    },
    /// Some units were counted before in another cut: refused whole, the other
    /// units are ready again.
    Overlap,
    /// The job was cancelled or has failed.
    Ended,
    /// The worker was found to deliver wrong sums before.
    Distrusted,
    /// The job's first result came from another numeric build.
    OtherBuild {
        /// That one.
        first: String,
    },
    /// No such job, or the frame's units do not exist.
    Unknown,
}

// The job stands in the list: beside a job of its own SQLite would look through all of
// that one's units.
pub(super) const COUNT_UNITS: Listed = listed!(
    "UPDATE unit SET state = 2, lease = 0 FROM (SELECT CAST(value ->> 0 AS BIGINT) AS j, \
     CAST(value ->> 1 AS BIGINT) AS f, CAST(value ->> 2 AS BIGINT) AS t, \
     CAST(value ->> 3 AS BIGINT) AS b0, CAST(value ->> 4 AS BIGINT) AS b1 FROM ",
    ") v WHERE unit.job = v.j AND unit.frame = v.f AND unit.tile = v.t AND unit.block >= v.b0 \
     AND unit.block < v.b1 AND unit.state < 2"
);
const IS_ANY_DISTRUSTED: Listed = listed!(
    "SELECT worker FROM distrust WHERE worker IN (SELECT value ->> 0 FROM ",
    ") LIMIT 1"
);
const ADD_TO_FRAMES: Listed = listed!(
    "UPDATE frame SET units_done = units_done + v.units, bad_samples = bad_samples + v.bad \
     FROM (SELECT CAST(value ->> 0 AS BIGINT) AS j, CAST(value ->> 1 AS BIGINT) AS f, \
     CAST(value ->> 2 AS BIGINT) AS units, CAST(value ->> 3 AS BIGINT) AS bad FROM ",
    ") v WHERE frame.job = v.j AND frame.frame = v.f"
);
const INSERT_PARTS: Listed = listed!(
    "INSERT INTO part (job, frame, tile, block0, block1, sums_hash, worker, object, core_us, \
     bad_samples, depth_cap_hits) SELECT $2, CAST(value ->> 0 AS BIGINT), \
     CAST(value ->> 1 AS BIGINT), CAST(value ->> 2 AS BIGINT), CAST(value ->> 3 AS BIGINT), \
     value ->> 4, value ->> 5, value ->> 6, CAST(value ->> 7 AS BIGINT), \
     CAST(value ->> 8 AS BIGINT), CAST(value ->> 9 AS BIGINT) FROM ",
    ""
);
const RESET_FAILURES: Listed = listed!(
    "UPDATE worker SET failed_in_row = 0, failed_last = '' WHERE failed_in_row > 0 \
     AND instance IN (SELECT value ->> 0 FROM ",
    ")"
);
const LEASES_OF_PARTS: Listed = listed!(
    "SELECT id, runs FROM lease WHERE job = $2 AND closed = 0 \
     AND id IN (SELECT CAST(value ->> 0 AS BIGINT) FROM ",
    ")"
);
const OPEN_RUNS: Listed = listed!(
    "SELECT DISTINCT v.l AS id FROM (SELECT CAST(value ->> 0 AS BIGINT) AS l, \
     CAST(value ->> 1 AS BIGINT) AS j, CAST(value ->> 2 AS BIGINT) AS f, \
     CAST(value ->> 3 AS BIGINT) AS t, CAST(value ->> 4 AS BIGINT) AS b0, \
     CAST(value ->> 5 AS BIGINT) AS b1 FROM ",
    ") v WHERE EXISTS (SELECT 1 FROM unit WHERE unit.job = v.j AND unit.frame = v.f \
     AND unit.tile = v.t AND unit.block >= v.b0 AND unit.block < v.b1 AND unit.state < 2)"
);
const CLOSE_LEASES: Listed = listed!(
    "UPDATE lease SET closed = 1 WHERE id IN (SELECT CAST(value ->> 0 AS BIGINT) FROM ",
    ")"
);

impl Store {
    /// Count all units of the run if none is counted yet.
    ///
    /// # Errors
    /// The database failed; nothing was counted.
    pub async fn commit(
        &self,
        part: &PartRecord,
        now_ms: i64,
    ) -> Result<CommitOutcome, StoreError> {
        if self.commit_all(std::slice::from_ref(part), now_ms).await? {
            return Ok(CommitOutcome::Counted);
        }
        self.settle(part, now_ms).await
    }

    /// Count all units of runs of one job and one numeric build, if none of them is
    /// counted yet and nothing stands against any of the runs; false when nothing was
    /// counted.
    ///
    /// # Errors
    /// The database failed; nothing was counted.
    pub async fn commit_all(&self, parts: &[PartRecord], now_ms: i64) -> Result<bool, StoreError> {
        let Some(job) = parts.first().map(|part| part.job) else {
            return Ok(true);
        };
        let engine = self.engine;
        let _timed = self.measures.transaction(Kind::Commit);
        let mut tx = self.begin().await?;
        let counted = count_units(&mut tx, engine, parts).await?;
        let due: u64 = parts.iter().map(units_of).sum();
        // A dropped transaction is rolled back.
        if counted != due {
            return Ok(false);
        }
        let Some(rev) = add_to_job(&mut tx, parts, now_ms).await? else {
            return Ok(false);
        };
        if is_any_distrusted(&mut tx, engine, parts).await? {
            return Ok(false);
        }
        add_to_frames(&mut tx, engine, parts).await?;
        insert_parts(&mut tx, engine, parts).await?;
        log_counted(&mut tx, engine, rev, parts, now_ms).await?;
        for part in parts.iter().filter(|part| part.audited) {
            audits::begin(&mut tx, job, &part.run, now_ms).await?;
        }
        close_leases_that_are_done(&mut tx, engine, parts).await?;
        tx.commit().await.attempt("commit results")?;
        Ok(true)
    }
}

pub(super) fn units_of(part: &PartRecord) -> u64 {
    u64::from(part.run.block1.saturating_sub(part.run.block0))
}

fn job_of(parts: &[PartRecord]) -> i64 {
    parts.first().map_or(0, |part| part.job.0)
}

async fn count_units(
    tx: &mut Transaction<'static, Any>,
    engine: Engine,
    parts: &[PartRecord],
) -> Result<u64, StoreError> {
    let rows: Vec<_> = parts
        .iter()
        .map(|PartRecord { job, run, .. }| (job.0, run.frame, run.tile, run.block0, run.block1))
        .collect();
    let counted = sqlx::query(COUNT_UNITS.of(engine))
        .bind(list(&rows)?)
        .execute(&mut **tx)
        .await
        .attempt("count units")?;
    Ok(counted.rows_affected())
}

/// Add the runs to their job, which keeps the numeric build of its first result: pixels
/// of two builds must not meet in one picture. The number of its last change; `None`
/// when it has ended, is gone, or is of another build.
async fn add_to_job(
    tx: &mut Transaction<'static, Any>,
    parts: &[PartRecord],
    now_ms: i64,
) -> Result<Option<i64>, StoreError> {
    let sum = |of: fn(&PartRecord) -> u64| big(parts.iter().map(of).sum());
    let row = sqlx::query(
        "UPDATE job SET units_done = units_done + $2, samples_done = samples_done + $3, \
         core_us = core_us + $4, bad_samples = bad_samples + $5, \
         depth_cap_hits = depth_cap_hits + $6, last_result_ms = $7, rev = rev + $8, \
         build = coalesce(build, $9) WHERE id = $1 AND finished_ms IS NULL \
         AND (build IS NULL OR build = $9) RETURNING rev",
    )
    .bind(job_of(parts))
    .bind(sum(units_of))
    .bind(sum(|part| part.samples))
    .bind(sum(|part| part.core_us))
    .bind(sum(|part| part.bad_samples))
    .bind(sum(|part| part.depth_cap_hits))
    .bind(now_ms)
    .bind(i64::try_from(parts.len()).unwrap_or(i64::MAX))
    .bind(parts.first().map(|part| part.build.clone()))
    .fetch_optional(&mut **tx)
    .await
    .attempt("add to job")?;
    row.map(|row| int(&row, "rev")).transpose()
}

/// Whether a result comes from a worker that is not believed.
async fn is_any_distrusted(
    tx: &mut Transaction<'static, Any>,
    engine: Engine,
    parts: &[PartRecord],
) -> Result<bool, StoreError> {
    let found = sqlx::query(IS_ANY_DISTRUSTED.of(engine))
        .bind(list(&workers(parts))?)
        .fetch_optional(&mut **tx)
        .await
        .attempt("look for distrust")?;
    Ok(found.is_some())
}

/// Their workers, each once and in one order: rows are locked in it.
fn workers(parts: &[PartRecord]) -> Vec<[&str; 1]> {
    let workers: BTreeSet<&str> = parts.iter().map(|part| part.worker.as_str()).collect();
    workers.into_iter().map(|worker| [worker]).collect()
}

async fn add_to_frames(
    tx: &mut Transaction<'static, Any>,
    engine: Engine,
    parts: &[PartRecord],
) -> Result<(), StoreError> {
    let mut frames: BTreeMap<u32, (u64, u64)> = BTreeMap::new();
    for part in parts {
        let (units, bad) = frames.entry(part.run.frame).or_default();
        *units += units_of(part);
        *bad += part.bad_samples;
    }
    let job = job_of(parts);
    let rows: Vec<(i64, u32, u64, i64)> = frames
        .into_iter()
        .map(|(frame, (units, bad))| (job, frame, units, big(bad)))
        .collect();
    sqlx::query(ADD_TO_FRAMES.of(engine))
        .bind(list(&rows)?)
        .execute(&mut **tx)
        .await
        .attempt("add to frames")?;
    Ok(())
}

async fn insert_parts(
    tx: &mut Transaction<'static, Any>,
    engine: Engine,
    parts: &[PartRecord],
) -> Result<(), StoreError> {
    let rows: Vec<_> = parts
        .iter()
        .map(|part| {
            let run = &part.run;
            let place = (run.frame, run.tile, run.block0, run.block1);
            (
                place.0,
                place.1,
                place.2,
                place.3,
                part.sums_hash.to_string(),
                &part.worker,
                &part.object,
                big(part.core_us),
                big(part.bad_samples),
                big(part.depth_cap_hits),
            )
        })
        .collect();
    sqlx::query(INSERT_PARTS.of(engine))
        .bind(list(&rows)?)
        .bind(job_of(parts))
        .execute(&mut **tx)
        .await
        .attempt("insert parts")?;
    sqlx::query(RESET_FAILURES.of(engine))
        .bind(list(&workers(parts))?)
        .execute(&mut **tx)
        .await
        .attempt("reset failures")?;
    Ok(())
}

async fn log_counted(
    tx: &mut Transaction<'static, Any>,
    engine: Engine,
    rev: i64,
    parts: &[PartRecord],
    now_ms: i64,
) -> Result<(), StoreError> {
    let events: Vec<Event<'_>> = parts
        .iter()
        .map(|part| Event {
            worker: Some(&part.worker),
            lease: Some(part.lease),
            runs: std::slice::from_ref(&part.run),
            ms: Some(big(part.core_us / 1000)),
            ..Event::new(part.job, LogKind::Counted, now_ms)
        })
        .collect();
    log_all(tx, engine, JobId(job_of(parts)), rev, &events).await
}

/// Close the leases of parts of which every run is counted. A run that was handed out
/// once more is still its first lease's as well.
async fn close_leases_that_are_done(
    tx: &mut Transaction<'static, Any>,
    engine: Engine,
    parts: &[PartRecord],
) -> Result<(), StoreError> {
    let job = job_of(parts);
    let named: BTreeSet<i64> = parts.iter().map(|part| part.lease).collect();
    let named: Vec<[i64; 1]> = named.into_iter().map(|id| [id]).collect();
    let leases = sqlx::query(LEASES_OF_PARTS.of(engine))
        .bind(list(&named)?)
        .bind(job)
        .fetch_all(&mut **tx)
        .await
        .attempt("look at leases")?;
    let mut done = BTreeSet::new();
    let mut runs = Vec::new();
    for row in &leases {
        let id = int(row, "id")?;
        done.insert(id);
        let of_lease = json::<Vec<Run>>(row, "runs")?;
        runs.extend(of_lease.into_iter().map(|run| (id, JobId(job), run)));
    }
    for id in with_open_runs(&mut **tx, engine, &runs).await? {
        done.remove(&id);
    }
    if done.is_empty() {
        return Ok(());
    }
    let done: Vec<[i64; 1]> = done.into_iter().map(|id| [id]).collect();
    sqlx::query(CLOSE_LEASES.of(engine))
        .bind(list(&done)?)
        .execute(&mut **tx)
        .await
        .attempt("close leases")?;
    Ok(())
}

/// Those leases, of these with their jobs' runs, that have a unit which is not counted.
pub(super) async fn with_open_runs<'e>(
    database: impl Executor<'e, Database = Any>,
    engine: Engine,
    runs: &[(i64, JobId, Run)],
) -> Result<BTreeSet<i64>, StoreError> {
    if runs.is_empty() {
        return Ok(BTreeSet::new());
    }
    let rows: Vec<_> = runs
        .iter()
        .map(|(id, job, run)| (id, job.0, run.frame, run.tile, run.block0, run.block1))
        .collect();
    sqlx::query(OPEN_RUNS.of(engine))
        .bind(list(&rows)?)
        .fetch_all(database)
        .await
        .attempt("look at runs")?
        .iter()
        .map(|row| int(row, "id"))
        .collect()
}
