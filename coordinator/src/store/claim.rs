//! Units become leased: fresh ones, or once more at the end of a job.
//!
//! Workers that ask at the same time are served by one transaction: the cost of a
//! claim is that of its statements, and each of them takes a list.

use super::error::{Attempt, StoreError};
use super::fresh::ready_units;
use super::lists::{Listed, list, listed};
use super::log::{Event, log_all};
use super::open::{Engine, Store};
use super::rows::{int, runs_text};
use super::submit::next_ids;
use crate::farm::{Unit, Wish, share_out};
use crate::metrics::Transaction as Kind;
use shearwater_shared::api::LogKind;
use shearwater_shared::job::JobId;
use shearwater_shared::plan::Run;
use sqlx::{Any, Transaction};

/// Which units may be claimed.
#[derive(Clone, Debug)]
pub struct ClaimQuery {
    /// Of this job.
    pub job: JobId,
    /// Who wants how many, first come first served; each worker once.
    pub wishes: Vec<Wish>,
    /// Workers present, or 0 when the asking one is alone. Units that a worker failed
    /// on are left to the others, until as many have failed on them.
    pub present: u64,
    /// Whether the job has a time stop: what is out of time is withheld, and tiles grow
    /// together, block by block.
    pub timed: bool,
}

/// A fresh lease.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Claimed {
    /// Number of the lease.
    pub id: i64,
    /// Its runs, in the order to render.
    pub runs: Vec<Run>,
    /// How often samples were added to the job by then: its settings are those of
    /// after so many additions.
    pub extended: i64,
}

// As for counting them: the job stands in the list.
pub(super) const LEASE_UNITS: Listed = listed!(
    "UPDATE unit SET state = 1, lease = v.l FROM (SELECT CAST(value ->> 0 AS BIGINT) AS l, \
     CAST(value ->> 1 AS BIGINT) AS j, CAST(value ->> 2 AS BIGINT) AS f, \
     CAST(value ->> 3 AS BIGINT) AS t, CAST(value ->> 4 AS BIGINT) AS b0, \
     CAST(value ->> 5 AS BIGINT) AS b1 FROM ",
    ") v WHERE unit.job = v.j AND unit.frame = v.f AND unit.tile = v.t AND unit.block >= v.b0 \
     AND unit.block < v.b1 AND unit.state = 0"
);

impl Store {
    /// Lease the runs that `cut` makes of each worker's share of the first ready units;
    /// makes the units of the next frames when too few are ready. One answer for each
    /// wish: `None` when nothing is ready for it or the job has ended.
    ///
    /// # Errors
    /// The database failed; nothing was leased.
    pub async fn claim(
        &self,
        query: &ClaimQuery,
        cut: impl Fn(&[Unit], &Wish) -> Vec<Run> + Send,
        now_ms: i64,
        until_ms: i64,
    ) -> Result<Vec<Option<Claimed>>, StoreError> {
        let _timed = self.measures.transaction(Kind::Claim);
        let mut tx = self.begin().await?;
        let (ready, failed) = ready_units(&mut tx, self.engine, query, now_ms).await?;
        let shares = share_out(ready, &query.wishes, &failed, query.present);
        let mut cuts: Vec<(&Wish, Vec<Run>)> = Vec::with_capacity(shares.len());
        for (wish, share) in query.wishes.iter().zip(&shares) {
            cuts.push((wish, cut(share, wish)));
        }
        let count = cuts.iter().filter(|(_, runs)| !runs.is_empty()).count();
        if count == 0 {
            // The frames that were made are kept.
            tx.commit().await.attempt("commit frame")?;
            return Ok(vec![None; query.wishes.len()]);
        }
        let Some(running) = mark_running(&mut tx, query.job, count, now_ms).await? else {
            return Ok(vec![None; query.wishes.len()]);
        };
        let mut id = next_ids(&mut tx, "lease", count).await?;
        let mut leases = Vec::with_capacity(count);
        let mut answers = Vec::with_capacity(cuts.len());
        for (wish, runs) in &cuts {
            if runs.is_empty() {
                answers.push(None);
                continue;
            }
            leases.push(NewLease {
                id,
                worker: &wish.worker,
                runs,
            });
            answers.push(Some(Claimed {
                id,
                runs: runs.clone(),
                extended: running.extended,
            }));
            id += 1;
        }
        lease_units(&mut tx, self.engine, query.job, &leases).await?;
        let lives = Lives {
            job: query.job,
            now_ms,
            until_ms,
        };
        insert_leases(
            &mut tx,
            self.engine,
            &lives,
            running,
            LogKind::Leased,
            &leases,
        )
        .await?;
        tx.commit().await.attempt("commit claim")?;
        Ok(answers)
    }

    /// Lease `runs`, which another worker holds, once more. Runs that were
    /// counted meanwhile are left out; `None` when all were.
    ///
    /// # Errors
    /// The database failed; nothing was leased.
    pub async fn reissue(
        &self,
        job: JobId,
        runs: &[Run],
        worker: &str,
        now_ms: i64,
        until_ms: i64,
    ) -> Result<Option<Claimed>, StoreError> {
        let _timed = self.measures.transaction(Kind::Claim);
        // In a transaction of its own: the units come first below.
        let mut tx = self.begin().await?;
        let id = next_ids(&mut tx, "lease", 1).await?;
        tx.commit().await.attempt("commit number of lease")?;
        let mut tx = self.begin().await?;
        for run in runs {
            let taken = sqlx::query(
                "UPDATE unit SET lease = $1 WHERE job = $2 AND frame = $3 \
                 AND tile = $4 AND block >= $5 AND block < $6 AND state = 1",
            )
            .bind(id)
            .bind(job.0)
            .bind(i64::from(run.frame))
            .bind(i64::from(run.tile))
            .bind(i64::from(run.block0))
            .bind(i64::from(run.block1))
            .execute(&mut *tx)
            .await
            .attempt("lease units again")?
            .rows_affected();
            // A run that is no longer whole belongs to nobody: it would be
            // refused for overlapping.
            if taken != u64::from(run.block1.saturating_sub(run.block0)) {
                return Ok(None);
            }
        }
        let Some(running) = mark_running(&mut tx, job, 1, now_ms).await? else {
            return Ok(None);
        };
        let lives = Lives {
            job,
            now_ms,
            until_ms,
        };
        let lease = NewLease { id, worker, runs };
        let kind = LogKind::Reissued;
        insert_leases(&mut tx, self.engine, &lives, running, kind, &[lease]).await?;
        tx.commit().await.attempt("commit reissue")?;
        Ok(Some(Claimed {
            id,
            runs: runs.to_vec(),
            extended: running.extended,
        }))
    }
}

/// What is known of a job whose row is held.
#[derive(Clone, Copy, Debug)]
pub(super) struct Running {
    /// Number of its last change.
    pub(super) rev: i64,
    /// Counts additions of samples.
    pub(super) extended: i64,
}

/// Note that the job is being rendered, and count as many changes as leases begin;
/// `None` when it has ended or is paused.
pub(super) async fn mark_running(
    tx: &mut Transaction<'static, Any>,
    job: JobId,
    leases: usize,
    now_ms: i64,
) -> Result<Option<Running>, StoreError> {
    let row = sqlx::query(
        "UPDATE job SET first_lease_ms = coalesce(first_lease_ms, $2), \
         timed_from_ms = coalesce(timed_from_ms, $2), rev = rev + $3 \
         WHERE id = $1 AND finished_ms IS NULL AND paused_ms IS NULL RETURNING rev, extended",
    )
    .bind(job.0)
    .bind(now_ms)
    .bind(i64::try_from(leases).unwrap_or(i64::MAX))
    .fetch_optional(&mut **tx)
    .await
    .attempt("mark job running")?;
    row.map(|row| {
        Ok(Running {
            rev: int(&row, "rev")?,
            extended: int(&row, "extended")?,
        })
    })
    .transpose()
}

async fn lease_units(
    tx: &mut Transaction<'static, Any>,
    engine: Engine,
    job: JobId,
    leases: &[NewLease<'_>],
) -> Result<(), StoreError> {
    let rows: Vec<[i64; 6]> = leases
        .iter()
        .flat_map(|lease| {
            lease.runs.iter().map(|run| {
                [
                    lease.id,
                    job.0,
                    run.frame.into(),
                    run.tile.into(),
                    run.block0.into(),
                    run.block1.into(),
                ]
            })
        })
        .collect();
    sqlx::query(LEASE_UNITS.of(engine))
        .bind(list(&rows)?)
        .execute(&mut **tx)
        .await
        .attempt("lease units")?;
    Ok(())
}

/// A lease to be stored.
#[derive(Clone, Copy, Debug)]
pub(super) struct NewLease<'a> {
    pub(super) id: i64,
    pub(super) worker: &'a str,
    pub(super) runs: &'a [Run],
}

/// What leases of one claim have in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lives {
    pub(super) job: JobId,
    pub(super) now_ms: i64,
    pub(super) until_ms: i64,
}

const INSERT_LEASES: Listed = listed!(
    "INSERT INTO lease (id, job, worker, runs, created_ms, until_ms) \
     SELECT CAST(value ->> 0 AS BIGINT), $2, value ->> 1, value ->> 2, $3, $4 FROM ",
    ""
);

/// Insert the rows of leases, the latest last, and tell the log of them as `kind`; their
/// job is marked.
pub(super) async fn insert_leases(
    tx: &mut Transaction<'static, Any>,
    engine: Engine,
    lives: &Lives,
    running: Running,
    kind: LogKind,
    leases: &[NewLease<'_>],
) -> Result<(), StoreError> {
    let mut rows = Vec::with_capacity(leases.len());
    let mut events = Vec::with_capacity(leases.len());
    for lease in leases {
        rows.push((lease.id, lease.worker, runs_text(lease.runs)?));
        events.push(Event {
            worker: Some(lease.worker),
            lease: Some(lease.id),
            runs: lease.runs,
            ..Event::new(lives.job, kind, lives.now_ms)
        });
    }
    sqlx::query(INSERT_LEASES.of(engine))
        .bind(list(&rows)?)
        .bind(lives.job.0)
        .bind(lives.now_ms)
        .bind(lives.until_ms)
        .execute(&mut **tx)
        .await
        .attempt("insert leases")?;
    sqlx::query("UPDATE job SET served = $2 WHERE id = $1")
        .bind(lives.job.0)
        .bind(leases.last().map_or(0, |lease| lease.id))
        .execute(&mut **tx)
        .await
        .attempt("note turn")?;
    log_all(tx, engine, lives.job, running.rev, &events).await
}
