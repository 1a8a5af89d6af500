//! A result is counted, once.

use super::audits;
use super::error::{Attempt, StoreError};
use super::log::{Event, log};
use super::open::Store;
use super::rows::{big, count, int, json, small, text};
use crate::metrics::Transaction as Kind;
use shearwater_shared::api::LogKind;
use shearwater_shared::hash::ContentHash;
use shearwater_shared::job::JobId;
use shearwater_shared::plan::Run;
use sqlx::{Any, Transaction};

/// One run's result. Its object is durable before this is committed.
#[derive(Clone, Debug)]
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
        let _timed = self.measures.transaction(Kind::Commit);
        let mut tx = self.begin().await?;
        let marked = for_run(
            sqlx::query(
                "UPDATE unit SET state = 2, lease = 0 WHERE job = $1 AND frame = $2 \
                 AND tile = $3 AND block >= $4 AND block < $5 AND state < 2",
            ),
            part,
        )
        .execute(&mut *tx)
        .await
        .attempt("count units")?
        .rows_affected();
        if marked != u64::from(part.run.block1.saturating_sub(part.run.block0)) {
            tx.rollback().await.attempt("roll back")?;
            return self.settle_repetition(part, now_ms).await;
        }
        if is_distrusted(&mut tx, &part.worker).await? {
            return Ok(CommitOutcome::Distrusted);
        }
        if let Some(first) = other_build(&mut tx, part).await? {
            return Ok(CommitOutcome::OtherBuild { first });
        }
        if !add_to_job(&mut tx, part, now_ms).await? {
            return Ok(CommitOutcome::Ended);
        }
        insert_part(&mut tx, part).await?;
        log_counted(&mut tx, part, now_ms).await?;
        if part.audited {
            audits::begin(&mut tx, part.job, &part.run, now_ms).await?;
        }
        close_if_done(&mut tx, part).await?;
        tx.commit().await.attempt("commit result")?;
        Ok(CommitOutcome::Counted)
    }

    /// What [`Store::commit`] would answer, if it is known without trying:
    /// saves writing the object of a repetition. Counts nothing; a repetition is
    /// compared.
    ///
    /// # Errors
    /// The database failed.
    pub async fn counted_before(
        &self,
        part: &PartRecord,
        now_ms: i64,
    ) -> Result<Option<CommitOutcome>, StoreError> {
        let row = for_run(
            sqlx::query(
                "SELECT count(*) AS open FROM unit WHERE job = $1 AND frame = $2 AND tile = $3 \
                 AND block >= $4 AND block < $5 AND state < 2",
            ),
            part,
        )
        .fetch_one(&self.read)
        .await
        .attempt("look at units")?;
        let length = u64::from(part.run.block1.saturating_sub(part.run.block0));
        if count(&row, "open")? == length {
            return Ok(None);
        }
        self.settle_repetition(part, now_ms).await.map(Some)
    }

    // At least one unit of the run is counted or missing.
    async fn settle_repetition(
        &self,
        part: &PartRecord,
        now_ms: i64,
    ) -> Result<CommitOutcome, StoreError> {
        let mut tx = self.begin().await?;
        let job = sqlx::query("SELECT ended FROM job WHERE id = $1")
            .bind(part.job.0)
            .fetch_optional(&mut *tx)
            .await
            .attempt("read job")?;
        let Some(job) = job else {
            return Ok(CommitOutcome::Unknown);
        };
        let first = sqlx::query(
            "SELECT block1, sums_hash, worker FROM part WHERE job = $1 AND frame = $2 \
             AND tile = $3 AND block0 = $4",
        )
        .bind(part.job.0)
        .bind(i64::from(part.run.frame))
        .bind(i64::from(part.run.tile))
        .bind(i64::from(part.run.block0))
        .fetch_optional(&mut *tx)
        .await
        .attempt("read part")?;
        if let Some(first) = first
            && small(&first, "block1")? == part.run.block1
        {
            let counted = audits::counted(&first)?;
            let equal = counted.sums_hash == part.sums_hash;
            if !equal {
                count_unequal(&mut tx, part.job).await?;
            }
            let audited = audits::claim(&mut tx, part, &counted, now_ms).await?;
            tx.commit().await.attempt("commit comparison")?;
            audited.inspect(|&end| self.measures.audited(end));
            return Ok(if equal {
                CommitOutcome::Duplicate
            } else {
                CommitOutcome::Unequal {
                    first_worker: counted.worker,
                }
            });
        }
        if int(&job, "ended")? != 0 {
            return Ok(CommitOutcome::Ended);
        }
        let outcome = settle_overlap(&mut tx, part).await?;
        tx.commit().await.attempt("commit overlap")?;
        Ok(outcome)
    }
}

type Query<'q> = sqlx::query::Query<'q, Any, sqlx::any::AnyArguments>;

/// Bind job, frame, tile, block0, block1 as $1 to $5.
fn for_run<'q>(query: Query<'q>, part: &PartRecord) -> Query<'q> {
    query
        .bind(part.job.0)
        .bind(i64::from(part.run.frame))
        .bind(i64::from(part.run.tile))
        .bind(i64::from(part.run.block0))
        .bind(i64::from(part.run.block1))
}

/// The numeric build of the job's first result, if it is not the part's. The first
/// result fixes it: pixels of two builds must not meet in one picture.
async fn other_build(
    tx: &mut Transaction<'static, Any>,
    part: &PartRecord,
) -> Result<Option<String>, StoreError> {
    let row =
        sqlx::query("UPDATE job SET build = coalesce(build, $2) WHERE id = $1 RETURNING build")
            .bind(part.job.0)
            .bind(&part.build)
            .fetch_optional(&mut **tx)
            .await
            .attempt("fix numeric build")?;
    let Some(row) = row else { return Ok(None) };
    let first = text(&row, "build")?;
    Ok((first != part.build).then_some(first))
}

/// Add the run to its job and frame; false when the job has ended or is gone.
async fn add_to_job(
    tx: &mut Transaction<'static, Any>,
    part: &PartRecord,
    now_ms: i64,
) -> Result<bool, StoreError> {
    let units = i64::from(part.run.block1.saturating_sub(part.run.block0));
    let live = sqlx::query(
        "UPDATE job SET units_done = units_done + $2, samples_done = samples_done + $3, \
         core_us = core_us + $4, bad_samples = bad_samples + $5, \
         depth_cap_hits = depth_cap_hits + $6, last_result_ms = $7, rev = rev + 1 \
         WHERE id = $1 AND finished_ms IS NULL",
    )
    .bind(part.job.0)
    .bind(units)
    .bind(big(part.samples))
    .bind(big(part.core_us))
    .bind(big(part.bad_samples))
    .bind(big(part.depth_cap_hits))
    .bind(now_ms)
    .execute(&mut **tx)
    .await
    .attempt("add to job")?;
    if live.rows_affected() != 1 {
        return Ok(false);
    }
    sqlx::query(
        "UPDATE frame SET units_done = units_done + $3, bad_samples = bad_samples + $4 \
         WHERE job = $1 AND frame = $2",
    )
    .bind(part.job.0)
    .bind(i64::from(part.run.frame))
    .bind(units)
    .bind(big(part.bad_samples))
    .execute(&mut **tx)
    .await
    .attempt("add to frame")?;
    Ok(true)
}

async fn is_distrusted(
    tx: &mut Transaction<'static, Any>,
    worker: &str,
) -> Result<bool, StoreError> {
    let row = sqlx::query("SELECT worker FROM distrust WHERE worker = $1")
        .bind(worker.to_owned())
        .fetch_optional(&mut **tx)
        .await
        .attempt("look for distrust")?;
    Ok(row.is_some())
}

async fn log_counted(
    tx: &mut Transaction<'static, Any>,
    part: &PartRecord,
    now_ms: i64,
) -> Result<(), StoreError> {
    let event = Event {
        worker: Some(&part.worker),
        lease: Some(part.lease),
        runs: &[part.run],
        ms: Some(big(part.core_us / 1000)),
        ..Event::new(part.job, LogKind::Counted, now_ms)
    };
    log(tx, &event).await
}

async fn insert_part(
    tx: &mut Transaction<'static, Any>,
    part: &PartRecord,
) -> Result<(), StoreError> {
    for_run(
        sqlx::query(
            "INSERT INTO part (job, frame, tile, block0, block1, sums_hash, worker, object, \
             core_us, bad_samples, depth_cap_hits) \
             VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11)",
        ),
        part,
    )
    .bind(part.sums_hash.to_string())
    .bind(&part.worker)
    .bind(&part.object)
    .bind(big(part.core_us))
    .bind(big(part.bad_samples))
    .bind(big(part.depth_cap_hits))
    .execute(&mut **tx)
    .await
    .attempt("insert part")?;
    sqlx::query(
        "UPDATE worker SET failed_in_row = 0, failed_last = '' \
         WHERE instance = $1 AND failed_in_row > 0",
    )
    .bind(&part.worker)
    .execute(&mut **tx)
    .await
    .attempt("reset failures")?;
    Ok(())
}

/// Close the lease of a part when every run of it is counted. A run that was
/// handed out once more is still this lease's as well.
async fn close_if_done(
    tx: &mut Transaction<'static, Any>,
    part: &PartRecord,
) -> Result<(), StoreError> {
    let lease = sqlx::query(
        "SELECT runs FROM lease WHERE id = $1 AND job = $2 AND closed = 0 AND NOT EXISTS \
         (SELECT 1 FROM unit WHERE job = $2 AND state = 1 AND lease = $1)",
    )
    .bind(part.lease)
    .bind(part.job.0)
    .fetch_optional(&mut **tx)
    .await
    .attempt("look at lease")?;
    let Some(lease) = lease else { return Ok(()) };
    for run in json::<Vec<Run>>(&lease, "runs")? {
        let open = sqlx::query(
            "SELECT 1 FROM unit WHERE job = $1 AND frame = $2 AND tile = $3 AND block >= $4 \
             AND block < $5 AND state < 2 LIMIT 1",
        )
        .bind(part.job.0)
        .bind(i64::from(run.frame))
        .bind(i64::from(run.tile))
        .bind(i64::from(run.block0))
        .bind(i64::from(run.block1))
        .fetch_optional(&mut **tx)
        .await
        .attempt("look at run")?;
        if open.is_some() {
            return Ok(());
        }
    }
    sqlx::query("UPDATE lease SET closed = 1 WHERE id = $1")
        .bind(part.lease)
        .execute(&mut **tx)
        .await
        .attempt("close lease")?;
    Ok(())
}

async fn count_unequal(tx: &mut Transaction<'static, Any>, job: JobId) -> Result<(), StoreError> {
    sqlx::query(
        "UPDATE job SET unequal_results = unequal_results + 1, rev = rev + 1 WHERE id = $1",
    )
    .bind(job.0)
    .execute(&mut **tx)
    .await
    .attempt("count alarm")?;
    Ok(())
}

/// A run in another cut than what was counted: free its uncounted units.
async fn settle_overlap(
    tx: &mut Transaction<'static, Any>,
    part: &PartRecord,
) -> Result<CommitOutcome, StoreError> {
    let row = for_run(
        sqlx::query(
            "SELECT count(*) AS known, CAST(coalesce(sum(CASE WHEN state = 2 THEN 1 ELSE 0 END), \
             0) AS BIGINT) AS counted FROM unit WHERE job = $1 AND frame = $2 AND tile = $3 \
             AND block >= $4 AND block < $5",
        ),
        part,
    )
    .fetch_one(&mut **tx)
    .await
    .attempt("look at units")?;
    let length = u64::from(part.run.block1.saturating_sub(part.run.block0));
    if count(&row, "known")? != length {
        return Ok(CommitOutcome::Unknown);
    }
    if count(&row, "counted")? == length {
        return Ok(CommitOutcome::Duplicate);
    }
    for_run(
        sqlx::query(
            "UPDATE unit SET state = 0, lease = 0 WHERE job = $1 AND frame = $2 AND tile = $3 \
             AND block >= $4 AND block < $5 AND state = 1 AND lease = $6",
        ),
        part,
    )
    .bind(part.lease)
    .execute(&mut **tx)
    .await
    .attempt("free units")?;
    Ok(CommitOutcome::Overlap)
}
