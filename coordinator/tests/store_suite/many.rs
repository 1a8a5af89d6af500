//! What many ask at the same time is one transaction.

use crate::suite::{beat, claim, claim_all, part, submit};
use shearwater_coordinator::farm::Wish;
use shearwater_coordinator::store::{Beat, Claimed, CommitOutcome, PartRecord, Store, WorkerRow};
use shearwater_shared::api::LogKind;
use shearwater_shared::job::JobId;
use std::collections::BTreeSet;

fn wish(worker: &str, units_max: usize) -> Wish {
    Wish {
        worker: worker.into(),
        units_max,
        threads: 1,
    }
}

fn units(claimed: &Claimed) -> BTreeSet<(u32, u32, u32)> {
    let of_run = |run: &shearwater_shared::plan::Run| {
        let run = *run;
        (run.block0..run.block1).map(move |block| (run.frame, run.tile, block))
    };
    claimed.runs.iter().flat_map(of_run).collect()
}

pub(crate) async fn those_who_ask_together_are_served_together(store: &Store) {
    let job = submit(store).await;
    let wishes = vec![wish("a", 3), wish("b", 9), wish("c", 4), wish("d", 100)];
    let claimed = claim_all(store, job, wishes, 4, 1, 1000).await;
    let claimed: Vec<Claimed> = claimed.into_iter().flatten().collect();
    assert_eq!(claimed.len(), 4);
    let mut all = BTreeSet::new();
    let mut ids = BTreeSet::new();
    for (claimed, (worker, most)) in claimed
        .iter()
        .zip([("a", 3), ("b", 9), ("c", 4), ("d", 100)])
    {
        let own = units(claimed);
        assert!(own.len() <= most, "{own:?}");
        assert!(own.is_disjoint(&all), "each unit has one holder");
        all.extend(own.iter().copied());
        ids.insert(claimed.id);
        let row = store.lease(claimed.id).await.expect("read").expect("row");
        assert_eq!((row.worker.as_str(), &row.runs), (worker, &claimed.runs));
        assert!(!row.closed);
    }
    assert_eq!(ids.len(), 4);
    let held = store.leased_units(job, 9999).await.expect("units");
    assert_eq!(held, all);
    // The log tells of each of them, in order and with a number of its own.
    let log = store.log(job, i64::MAX, 100).await.expect("log");
    let leased: Vec<_> = log.iter().rev().map(|e| (e.kind, e.lease)).collect();
    let expected: Vec<_> = ids.iter().map(|id| (LogKind::Leased, Some(*id))).collect();
    assert_eq!(leased, expected);
    let numbers: BTreeSet<i64> = log.iter().map(|event| event.seq).collect();
    assert_eq!(numbers.len(), log.len());
}

pub(crate) async fn what_one_failed_on_goes_to_others(store: &Store) {
    let job = submit(store).await;
    let first = claim(store, job, 1, 1, 1000).await.expect("work");
    let run = first.runs[0];
    store
        .record_failure(job, first.id, &[run], "w", "broken", 2)
        .await
        .expect("record");
    let claimed = claim_all(store, job, vec![wish("w", 2), wish("b", 2)], 2, 3, 1000).await;
    let [Some(own), Some(other)] = &claimed[..] else {
        panic!("{claimed:?}")
    };
    assert!(!own.runs.contains(&run), "{own:?}");
    assert_eq!(units(own).len(), 2, "there is other work");
    assert!(units(other).contains(&(run.frame, run.tile, run.block0)));
}

fn parts(job: JobId, claimed: &Claimed, nonce: u64) -> Vec<PartRecord> {
    let of_run = |run: &shearwater_shared::plan::Run| part(job, *run, claimed.id, nonce);
    claimed.runs.iter().map(of_run).collect()
}

pub(crate) async fn results_are_counted_together_or_not_at_all(store: &Store) {
    let job = submit(store).await;
    let wishes = vec![wish("w", 6), wish("w2", 6), wish("w3", 2)];
    let claimed = claim_all(store, job, wishes, 3, 1, 1000).await;
    let claimed: Vec<Claimed> = claimed.into_iter().flatten().collect();
    let both: Vec<PartRecord> = claimed[..2].iter().flat_map(|c| parts(job, c, 0)).collect();
    assert!(store.commit_all(&both, 2).await.expect("commit"));
    let row = store.job(job).await.expect("read").expect("job");
    assert_eq!((row.units_done, row.units_leased), (12, 2));
    assert_eq!(row.core_us, both.len() as u64);
    for lease in &claimed[..2] {
        let lease = store.lease(lease.id).await.expect("read").expect("row");
        assert!(lease.closed, "every run of it is counted");
    }
    // One of them was counted before: none of these is counted now.
    let mut mixed = parts(job, &claimed[2], 1);
    let new = mixed.clone();
    mixed.push(both[0].clone());
    let before = store.job(job).await.expect("read").expect("job");
    assert!(!store.commit_all(&mixed, 3).await.expect("commit"));
    let after = store.job(job).await.expect("read").expect("job");
    assert_eq!(before, after);
    for record in &mixed {
        let outcome = store.commit(record, 4).await.expect("commit");
        let expected = if new.contains(record) {
            CommitOutcome::Counted
        } else {
            CommitOutcome::Duplicate
        };
        assert_eq!(outcome, expected);
    }
    let row = store.job(job).await.expect("read").expect("job");
    assert_eq!((row.units_done, row.units_leased), (14, 0));
    // Another numeric build.
    let more = claim(store, job, 2, 5, 1000).await.expect("work");
    let mut foreign = parts(job, &more, 2);
    for part in &mut foreign {
        part.build = "other".into();
    }
    assert!(!store.commit_all(&foreign, 6).await.expect("commit"));
    let outcome = store.commit(&foreign[0], 6).await.expect("commit");
    assert_eq!(outcome, CommitOutcome::OtherBuild { first: "b".into() });
}

pub(crate) async fn workers_are_heard_together(store: &Store) {
    let job = submit(store).await;
    let wishes = vec![wish("heard-a", 2), wish("heard-b", 2)];
    let claimed = claim_all(store, job, wishes, 2, 1000, 1100).await;
    let [Some(a), Some(b)] = &claimed[..] else {
        panic!("{claimed:?}")
    };
    let beats = [
        Beat {
            lease: a.id,
            worker: "heard-a".into(),
        },
        Beat {
            lease: b.id,
            worker: "heard-a".into(),
        },
    ];
    let wanted = store.hear(&beats, 5000).await.expect("hear");
    assert_eq!(wanted, BTreeSet::from([a.id]), "the other one is not its");
    store.expire(2000).await.expect("expire");
    let lives = async |id| !store.lease(id).await.expect("read").expect("row").closed;
    assert!(lives(a.id).await && !lives(b.id).await);
    // Expiry only ends the waiting: what it renders is still of use, until it is counted.
    assert!(beat(store, "heard-b", b.id, 5000).await);
    for part in parts(job, b, 0) {
        store.commit(&part, 2001).await.expect("commit");
    }
    assert!(!beat(store, "heard-b", b.id, 5000).await);

    let row = |instance: &str, seen_ms| WorkerRow {
        instance: instance.into(),
        name: "name".into(),
        threads: 3,
        milli_samples_per_s: 7,
        seen_ms,
        distrusted: false,
        quarantined_until_ms: 0,
        quarantine_reason: None,
    };
    let far_ms = 1 << 50;
    let rows = [row("heard-a", far_ms), row("heard-b", far_ms)];
    store.workers_asked(&rows).await.expect("note");
    let seen = [
        ("heard-b".to_owned(), far_ms + 9),
        ("nobody".into(), far_ms),
    ];
    store.workers_seen(&seen).await.expect("note");
    let workers = store.workers(far_ms).await.expect("read");
    assert_eq!(
        workers,
        [row("heard-a", far_ms), row("heard-b", far_ms + 9)]
    );
}
