//! The re-execution audit: counted runs go to other workers, their answers are
//! compared, and whoever was wrong is not believed again.
//!
//! An auditor gets a lease like any other and does not know that it audits: its result
//! is a repetition of a counted run, and every such repetition is a claim.

use super::claim::{Claimed, Lives, NewLease, insert_leases, mark_running};
use super::commit::PartRecord;
use super::error::{Attempt, StoreError, corrupt};
use super::log::{Event, log_change};
use super::open::Store;
use super::order::lock_job;
use super::rows::{count, hash, int, json, small, text};
use super::submit::next_id;
use crate::farm::{AuditVerdict, Claim, WaitingAudit, judge};
use crate::metrics::Audited;
use shearwater_shared::api::LogKind;
use shearwater_shared::job::JobId;
use shearwater_shared::plan::Run;
use sqlx::any::AnyRow;
use sqlx::{Any, Transaction};

/// Runs of one audit lease: few, so that other work of the auditor does not wait.
const AUDIT_RUNS_MAX: usize = 4;
/// Open audits that one lease request looks at.
const CANDIDATES_MAX: i64 = 64;
/// Audits of complete frames that one pass looks at.
const WAITING_MAX: i64 = 1024;

const COUNT_EQUAL: &str = "UPDATE job SET audits_equal = audits_equal + 1 WHERE id = $1";
const COUNT_UNEQUAL: &str = "UPDATE job SET audits_unequal = audits_unequal + 1 WHERE id = $1";

/// An audit that keeps its frame from ending.
#[derive(Clone, Debug)]
pub struct HoldingAudit {
    /// Job.
    pub job: JobId,
    /// The run.
    pub run: Run,
    /// When it last changed, by whichever coordinator's clock: tells whether it has.
    pub changed_ms: i64,
    /// What the decision sees; how long that has been so, the store cannot know.
    pub waiting: WaitingAudit,
}

impl Store {
    /// Lease counted runs of one job, which `worker` has not rendered yet, to be
    /// compared; `None` when there are none.
    ///
    /// # Errors
    /// The database failed; nothing was leased.
    pub async fn lease_audits(
        &self,
        worker: &str,
        build: &str,
        now_ms: i64,
        until_ms: i64,
    ) -> Result<Option<(JobId, Claimed)>, StoreError> {
        let found = sqlx::query(
            "SELECT a.job, a.frame, a.tile, a.block0, a.block1, a.claims FROM audit a \
             JOIN job j ON j.id = a.job JOIN part p ON p.job = a.job AND p.frame = a.frame \
             AND p.tile = a.tile AND p.block0 = a.block0 WHERE a.lease = 0 AND p.worker <> $1 \
             AND j.finished_ms IS NULL AND j.paused_ms IS NULL AND (j.build IS NULL OR j.build = $2) \
             ORDER BY j.priority DESC, a.job, a.frame, a.tile, a.block0 LIMIT $3",
        )
        .bind(worker)
        .bind(build)
        .bind(CANDIDATES_MAX)
        .fetch_all(&self.read)
        .await
        .attempt("look for audits")?;
        let mut wanted: Vec<(JobId, Run)> = Vec::new();
        for row in &found {
            let claims = claims(row)?;
            if claims.iter().all(|claim| claim.worker != worker) {
                wanted.push((JobId(int(row, "job")?), run_of(row)?));
            }
        }
        let Some(&(job, _)) = wanted.first() else {
            return Ok(None);
        };
        wanted.retain(|(of, _)| *of == job);
        wanted.truncate(AUDIT_RUNS_MAX);
        // In a transaction of its own: the job comes first below.
        let mut tx = self.begin().await?;
        let id = next_id(&mut tx, "lease").await?;
        tx.commit().await.attempt("commit number of lease")?;
        let mut tx = self.begin().await?;
        let Some(running) = mark_running(&mut tx, job, 1, now_ms).await? else {
            return Ok(None);
        };
        let mut runs = Vec::with_capacity(wanted.len());
        for (job, run) in wanted {
            let taken = at_run(
                "UPDATE audit SET lease = $6, changed_ms = $7 WHERE job = $1 AND frame = $2 \
                 AND tile = $3 AND block0 = $4 AND block1 = $5 AND lease = 0",
                job,
                &run,
            );
            let taken = taken.bind(id).bind(now_ms).execute(&mut *tx).await;
            if taken.attempt("take audit")?.rows_affected() == 1 {
                runs.push(run);
            }
        }
        if runs.is_empty() {
            return Ok(None);
        }
        let lives = Lives {
            job,
            now_ms,
            until_ms,
        };
        let lease = NewLease {
            id,
            worker,
            runs: &runs,
        };
        let kind = LogKind::AuditLeased;
        insert_leases(&mut tx, self.engine, &lives, running, kind, &[lease]).await?;
        tx.commit().await.attempt("commit audit lease")?;
        let extended = running.extended;
        Ok(Some((job, Claimed { id, runs, extended })))
    }

    /// Counted runs that wait for a worker to render them again.
    ///
    /// # Errors
    /// The database failed.
    pub async fn free_audits(&self) -> Result<u64, StoreError> {
        let row = sqlx::query(
            "SELECT count(*) AS free FROM audit a JOIN job j ON j.id = a.job WHERE a.lease = 0 \
             AND j.finished_ms IS NULL AND j.paused_ms IS NULL",
        )
        .fetch_one(&self.read)
        .await
        .attempt("count audits")?;
        count(&row, "free")
    }

    /// Audits that alone keep a frame from ending.
    ///
    /// # Errors
    /// The database failed.
    pub async fn holding_audits(&self) -> Result<Vec<HoldingAudit>, StoreError> {
        let rows = sqlx::query(
            "SELECT a.job, a.frame, a.tile, a.block0, a.block1, a.lease, a.claims, a.tries, \
             a.changed_ms, coalesce(p.worker, '') AS worker FROM audit a \
             JOIN frame f ON f.job = a.job AND f.frame = a.frame JOIN job j ON j.id = a.job \
             LEFT JOIN part p ON p.job = a.job AND p.frame = a.frame AND p.tile = a.tile \
             AND p.block0 = a.block0 WHERE f.film_hash IS NULL AND f.units_done >= f.units_due \
             AND j.finished_ms IS NULL AND j.paused_ms IS NULL \
             ORDER BY a.job, a.frame, a.tile, a.block0 LIMIT $1",
        )
        .bind(WAITING_MAX)
        .fetch_all(&self.read)
        .await
        .attempt("find audits to wait for")?;
        let mut found = Vec::with_capacity(rows.len());
        for row in &rows {
            let mut claimants = vec![text(row, "worker")?];
            claimants.extend(claims(row)?.into_iter().map(|claim| claim.worker));
            let held = HoldingAudit {
                job: JobId(int(row, "job")?),
                run: run_of(row)?,
                changed_ms: int(row, "changed_ms")?,
                waiting: WaitingAudit {
                    claimants,
                    leased: int(row, "lease")? > 0,
                    tries: count(row, "tries")?,
                    held_ms: 0,
                    waited_ms: 0,
                },
            };
            found.push(held);
        }
        Ok(found)
    }

    /// Give an audit up; false when it is gone.
    ///
    /// # Errors
    /// The database failed; the audit is as before.
    pub async fn skip_audit(&self, job: JobId, run: &Run, now_ms: i64) -> Result<bool, StoreError> {
        let mut tx = self.begin().await?;
        lock_job(&mut tx, job).await?;
        let skipped = skip(&mut tx, job, run, now_ms).await?;
        if skipped {
            tx.commit().await.attempt("commit end of audit")?;
            self.measures.audited(Audited::Skipped);
        }
        Ok(skipped)
    }

    /// Open leases of workers that are not believed, with their workers.
    ///
    /// # Errors
    /// The database failed.
    pub async fn distrusted_leases(&self) -> Result<Vec<(i64, String)>, StoreError> {
        sqlx::query(
            "SELECT l.id, l.worker FROM distrust d JOIN lease l ON l.worker = d.worker \
             WHERE l.closed = 0 ORDER BY l.id",
        )
        .fetch_all(&self.read)
        .await
        .attempt("find leases of wrong workers")?
        .iter()
        .map(|row| Ok((int(row, "id")?, text(row, "worker")?)))
        .collect()
    }

    /// Whether this worker was found to deliver wrong sums, and how.
    ///
    /// # Errors
    /// The database failed.
    pub async fn distrust_of(&self, worker: &str) -> Result<Option<String>, StoreError> {
        let row = sqlx::query("SELECT reason FROM distrust WHERE worker = $1")
            .bind(worker)
            .fetch_optional(&self.read)
            .await
            .attempt("read distrust")?;
        row.map(|row| text(&row, "reason")).transpose()
    }
}

type Query<'q> = sqlx::query::Query<'q, Any, sqlx::any::AnyArguments>;

/// Bind job, frame, tile, block0, block1 as $1 to $5.
fn at_run(sql: &'static str, job: JobId, run: &Run) -> Query<'static> {
    sqlx::query(sql)
        .bind(job.0)
        .bind(i64::from(run.frame))
        .bind(i64::from(run.tile))
        .bind(i64::from(run.block0))
        .bind(i64::from(run.block1))
}

fn run_of(row: &AnyRow) -> Result<Run, StoreError> {
    Ok(Run {
        frame: small(row, "frame")?,
        tile: small(row, "tile")?,
        block0: small(row, "block0")?,
        block1: small(row, "block1")?,
    })
}

/// Claims as the row keeps them: worker and hash.
fn claims(row: &AnyRow) -> Result<Vec<Claim>, StoreError> {
    json::<Vec<(String, String)>>(row, "claims")?
        .into_iter()
        .map(|(worker, sums)| {
            Ok(Claim {
                worker,
                sums_hash: sums.parse().map_err(|e| corrupt("claims", e))?,
            })
        })
        .collect()
}

fn claims_text(claims: &[Claim]) -> Result<String, StoreError> {
    let pairs: Vec<(&str, String)> = claims
        .iter()
        .map(|claim| (claim.worker.as_str(), claim.sums_hash.to_string()))
        .collect();
    serde_json::to_string(&pairs).map_err(|e| corrupt("claims", e))
}

/// Begin the audit of a run that is being counted; what was known of one that began at
/// the same block is of no use.
pub(super) async fn begin(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
    run: &Run,
    now_ms: i64,
) -> Result<(), StoreError> {
    let insert = at_run(
        "INSERT INTO audit (job, frame, tile, block0, block1, changed_ms) \
         VALUES ($1, $2, $3, $4, $5, $6) ON CONFLICT (job, frame, tile, block0) DO UPDATE SET \
         block1 = excluded.block1, lease = 0, claims = '[]', tries = 0, \
         changed_ms = excluded.changed_ms",
        job,
        run,
    );
    let inserted = insert.bind(now_ms).execute(&mut **tx).await;
    inserted.attempt("begin audit").map(drop)
}

/// Open the audit of a counted run if there is none.
async fn open(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
    run: &Run,
    now_ms: i64,
) -> Result<(), StoreError> {
    let insert = at_run(
        "INSERT INTO audit (job, frame, tile, block0, block1, changed_ms) \
         SELECT id, $2, $3, $4, $5, $6 FROM job WHERE id = $1 AND finished_ms IS NULL \
         ON CONFLICT DO NOTHING",
        job,
        run,
    );
    let inserted = insert.bind(now_ms).execute(&mut **tx).await;
    inserted.attempt("open audit").map(drop)
}

/// Take a repetition of a counted run as a claim, if it was leased to who delivers it.
/// Unequal bits open an audit where there was none. How the audit ended, if it did.
pub(super) async fn claim(
    tx: &mut Transaction<'static, Any>,
    part: &PartRecord,
    counted: &Claim,
    now_ms: i64,
) -> Result<Option<Audited>, StoreError> {
    let unequal = counted.sums_hash != part.sums_hash;
    if counted.worker == part.worker || !was_leased(tx, part).await? {
        return Ok(None);
    }
    lock_job(tx, part.job).await?;
    if unequal {
        open(tx, part.job, &part.run, now_ms).await?;
    }
    // The update is what others wait for; then the row is read.
    let row = at_run(
        "UPDATE audit SET changed_ms = $6 WHERE job = $1 AND frame = $2 AND tile = $3 \
         AND block0 = $4 AND block1 = $5 RETURNING lease, claims",
        part.job,
        &part.run,
    )
    .bind(now_ms)
    .fetch_optional(&mut **tx)
    .await
    .attempt("read audit")?;
    let Some(row) = row else { return Ok(None) };
    let mut others = claims(&row)?;
    if others.iter().any(|other| other.worker == part.worker) {
        return Ok(None);
    }
    others.push(Claim {
        worker: part.worker.clone(),
        sums_hash: part.sums_hash,
    });
    let mut all = vec![counted.clone()];
    all.extend(others.iter().cloned());
    let lease = int(&row, "lease")?;
    let ended = match judge(&all) {
        AuditVerdict::Ask => {
            let again = at_run(
                "UPDATE audit SET claims = $6, lease = CASE WHEN lease = $7 THEN 0 ELSE lease END \
                 WHERE job = $1 AND frame = $2 AND tile = $3 AND block0 = $4 AND block1 = $5",
                part.job,
                &part.run,
            );
            let again = again.bind(claims_text(&others)?).bind(part.lease);
            let asked = again.execute(&mut **tx).await;
            asked.attempt("ask another")?;
            log_claim(tx, part, LogKind::AuditUnequal, None, now_ms).await?;
            None
        }
        AuditVerdict::Equal => {
            settle(tx, part, COUNT_EQUAL).await?;
            log_claim(tx, part, LogKind::AuditEqual, None, now_ms).await?;
            Some(Audited::Equal)
        }
        AuditVerdict::Wrong(workers) => {
            settle(tx, part, COUNT_UNEQUAL).await?;
            for worker in &workers {
                distrust(tx, part, worker, all.len() - workers.len(), now_ms).await?;
            }
            Some(Audited::Unequal)
        }
        AuditVerdict::Nobody => {
            skip(tx, part.job, &part.run, now_ms).await?;
            Some(Audited::Skipped)
        }
    };
    end_audit_lease(tx, if lease == part.lease { lease } else { 0 }).await?;
    Ok(ended)
}

/// Whether the run was leased to the worker that delivers it: nobody else's word counts.
async fn was_leased(
    tx: &mut Transaction<'static, Any>,
    part: &PartRecord,
) -> Result<bool, StoreError> {
    let row = sqlx::query(
        "SELECT runs FROM lease WHERE id = $1 AND job = $2 AND worker = $3 \
         AND NOT EXISTS (SELECT 1 FROM distrust WHERE worker = $3)",
    )
    .bind(part.lease)
    .bind(part.job.0)
    .bind(&part.worker)
    .fetch_optional(&mut **tx)
    .await
    .attempt("read lease")?;
    let Some(row) = row else { return Ok(false) };
    Ok(json::<Vec<Run>>(&row, "runs")?.contains(&part.run))
}

/// End the audit of the part's run; `count` counts it in its job.
async fn settle(
    tx: &mut Transaction<'static, Any>,
    part: &PartRecord,
    count: &'static str,
) -> Result<(), StoreError> {
    delete(tx, part.job, &part.run).await?;
    let counted = sqlx::query(count).bind(part.job.0).execute(&mut **tx).await;
    counted.attempt("count audit").map(drop)
}

async fn delete(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
    run: &Run,
) -> Result<bool, StoreError> {
    let delete = at_run(
        "DELETE FROM audit WHERE job = $1 AND frame = $2 AND tile = $3 AND block0 = $4 \
         AND block1 = $5",
        job,
        run,
    );
    let deleted = delete.execute(&mut **tx).await.attempt("end audit")?;
    Ok(deleted.rows_affected() == 1)
}

async fn skip(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
    run: &Run,
    now_ms: i64,
) -> Result<bool, StoreError> {
    if !delete(tx, job, run).await? {
        return Ok(false);
    }
    sqlx::query("UPDATE job SET audits_skipped = audits_skipped + 1 WHERE id = $1")
        .bind(job.0)
        .execute(&mut **tx)
        .await
        .attempt("count audit")?;
    let event = Event::new(job, LogKind::AuditSkipped, now_ms);
    let runs = &[*run][..];
    log_change(tx, &Event { runs, ..event }).await?;
    Ok(true)
}

/// Believe a worker no more: nothing of it is counted from now on, and whoever is about
/// to end a frame must look again. What it holds and has delivered is taken back by
/// [`Store::distrusted_leases`] and [`Store::tiles_to_withdraw`].
async fn distrust(
    tx: &mut Transaction<'static, Any>,
    part: &PartRecord,
    worker: &str,
    right: usize,
    now_ms: i64,
) -> Result<(), StoreError> {
    let run = &part.run;
    let reason = format!(
        "its sums of job {}, frame {}, tile {}, blocks {} to {} differ from those of {right} other workers: look for \
         bad memory or an overclock, then restart it",
        part.job,
        run.frame,
        run.tile,
        run.block0,
        run.block1.saturating_sub(1)
    );
    let first = sqlx::query(
        "INSERT INTO distrust (worker, reason, at_ms) VALUES ($1, $2, $3) ON CONFLICT DO NOTHING",
    )
    .bind(worker)
    .bind(&reason)
    .bind(now_ms)
    .execute(&mut **tx)
    .await
    .attempt("store distrust")?;
    if first.rows_affected() != 1 {
        return Ok(());
    }
    sqlx::query("UPDATE job SET extended = extended + 1 WHERE id = $1")
        .bind(part.job.0)
        .execute(&mut **tx)
        .await
        .attempt("stop decisions")?;
    let event = Event {
        worker: Some(worker),
        runs: &[*run],
        text: Some(&reason),
        ..Event::new(part.job, LogKind::Distrusted, now_ms)
    };
    log_change(tx, &event).await
}

async fn log_claim(
    tx: &mut Transaction<'static, Any>,
    part: &PartRecord,
    kind: LogKind,
    text: Option<&str>,
    now_ms: i64,
) -> Result<(), StoreError> {
    let event = Event {
        worker: Some(&part.worker),
        lease: Some(part.lease),
        runs: &[part.run],
        text,
        ..Event::new(part.job, kind, now_ms)
    };
    log_change(tx, &event).await
}

/// Close an audit lease once every run of it is answered; 0 is none.
async fn end_audit_lease(tx: &mut Transaction<'static, Any>, lease: i64) -> Result<(), StoreError> {
    sqlx::query(
        "UPDATE lease SET closed = 1 WHERE id = $1 AND closed = 0 \
         AND NOT EXISTS (SELECT 1 FROM audit WHERE lease = $1)",
    )
    .bind(lease)
    .execute(&mut **tx)
    .await
    .attempt("close audit lease")?;
    Ok(())
}

/// The counted claim about a part's run, of a row of `part`.
pub(super) fn counted(row: &AnyRow) -> Result<Claim, StoreError> {
    Ok(Claim {
        worker: text(row, "worker")?,
        sums_hash: hash(row, "sums_hash")?,
    })
}
