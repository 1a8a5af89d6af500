//! A result that cannot simply be counted: repeated, late, refused.

use super::audits;
use super::commit::{CommitOutcome, PartRecord, units_of};
use super::error::{Attempt, StoreError};
use super::open::Store;
use super::rows::{count, int, optional_text, small};
use shearwater_shared::job::JobId;
use sqlx::{Any, Transaction};

impl Store {
    /// Those of these parts of which no unit is counted.
    ///
    /// # Errors
    /// The database failed.
    pub async fn uncounted(&self, parts: Vec<PartRecord>) -> Result<Vec<PartRecord>, StoreError> {
        let mut open = Vec::with_capacity(parts.len());
        for part in parts {
            let row = for_run(sqlx::query(OPEN_UNITS), &part)
                .fetch_one(&self.read)
                .await
                .attempt("look at units")?;
            if count(&row, "open")? == units_of(&part) {
                open.push(part);
            }
        }
        Ok(open)
    }

    /// Why a part was not counted.
    pub(super) async fn settle(
        &self,
        part: &PartRecord,
        now_ms: i64,
    ) -> Result<CommitOutcome, StoreError> {
        let mut tx = self.begin().await?;
        let row = for_run(sqlx::query(OPEN_UNITS), part)
            .fetch_one(&mut *tx)
            .await
            .attempt("look at units")?;
        if count(&row, "open")? != units_of(part) {
            drop(tx);
            return self.settle_repetition(part, now_ms).await;
        }
        if is_distrusted(&mut tx, &part.worker).await? {
            return Ok(CommitOutcome::Distrusted);
        }
        let job = sqlx::query("SELECT build FROM job WHERE id = $1 AND finished_ms IS NULL")
            .bind(part.job.0)
            .fetch_optional(&mut *tx)
            .await
            .attempt("read job")?;
        let Some(job) = job else {
            return Ok(CommitOutcome::Ended);
        };
        Ok(match optional_text(&job, "build")? {
            Some(first) if first != part.build => CommitOutcome::OtherBuild { first },
            // Somebody was between; the worker sends it once more.
            _ => return Err(StoreError::Changed("result")),
        })
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

const OPEN_UNITS: &str = "SELECT count(*) AS open FROM unit WHERE job = $1 AND frame = $2 \
     AND tile = $3 AND block >= $4 AND block < $5 AND state < 2";

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
