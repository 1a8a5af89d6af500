//! Leases and jobs that end.

use crate::suite::{beat, claim, gone, part, submit};
use shearwater_coordinator::store::{CommitOutcome, JobFilter, Store};

pub(crate) async fn what_ended_stays_ended(store: &Store) {
    let job = submit(store).await;
    let claimed = claim(store, job, 16, 1, 1000).await.expect("work");
    assert!(store.fail_job(job, None, "why", 5).await.expect("fail"));
    assert!(!store.cancel(job, 6).await.expect("cancel"));
    assert!(!store.fail_job(job, None, "other", 7).await.expect("fail"));
    let row = store.job(job).await.expect("read").expect("job");
    assert_eq!(row.finished_ms, Some(5));
    assert!(claim(store, job, 16, 1, 1000).await.is_none());
    let late = part(job, claimed.runs[0], claimed.id, 0);
    let outcome = store.commit(&late, 9).await.expect("commit");
    assert_eq!(outcome, CommitOutcome::Ended);
    assert!(!store.names_object(&late.object).await.expect("look"));
}

pub(crate) async fn expiry_frees_and_late_results_count(store: &Store) {
    let job = submit(store).await;
    let first = claim(store, job, 4, 1_000_000, 1_000_100)
        .await
        .expect("work");
    assert!(beat(store, "w", first.id, 1_000_200).await);
    assert!(!beat(store, "thief", first.id, 9_000_000).await);
    let leased = async || {
        let units = store.leased_units(job, 99).await.expect("units");
        units.len()
    };
    store.expire(1_000_150).await.expect("expire");
    assert_eq!(leased().await, 4, "prolonged");
    store.expire(1_000_201).await.expect("expire");
    assert_eq!(leased().await, 0);
    let second = claim(store, job, 4, 1_000_300, 2_000_000)
        .await
        .expect("work");
    assert_eq!(second.runs, first.runs, "holes are filled first");
    let late = part(job, first.runs[0], first.id, 0);
    let outcome = store.commit(&late, 1_000_400).await.expect("commit");
    assert_eq!(outcome, CommitOutcome::Counted);
    let counted = [first.runs[0]];
    let reissue = store.reissue(job, &counted, "v", 1_000_400, 2_000_000);
    assert_eq!(reissue.await.expect("reissue"), None, "nobody waits for it");
    let again = part(job, second.runs[0], second.id, 1);
    let outcome = store.commit(&again, 1_000_400).await.expect("commit");
    assert_eq!(outcome, CommitOutcome::Duplicate);
}

pub(crate) async fn a_clock_set_back_ends_leases_in_time(store: &Store) {
    let job = submit(store).await;
    let day = 86_400_000;
    let before = claim(store, job, 4, day, day + 100).await.expect("work");
    // A day earlier by the clock.
    store
        .cut_future_times(50, 150, 1000)
        .await
        .expect("cut times");
    let lease = store.lease(before.id).await.expect("read").expect("lease");
    assert_eq!(lease.until_ms, 150);
    store.expire(151).await.expect("expire");
    let after = claim(store, job, 4, 152, 1000).await.expect("work");
    assert_eq!(after.runs, before.runs, "ready again");
}

pub(crate) async fn a_lease_ends_with_its_last_run(store: &Store) {
    let job = submit(store).await;
    let first = claim(store, job, 4, 1, 1000).await.expect("work");
    let second = claim(store, job, 4, 1, 1000).await.expect("work");
    let again = store
        .reissue(job, &second.runs, "v", 2, 1000)
        .await
        .expect("reissue")
        .expect("work");
    let closed = async |id| {
        let lease = store.lease(id).await.expect("read");
        lease.expect("lease").closed
    };
    let last = first.runs.len() - 1;
    for (i, run) in first.runs.iter().enumerate() {
        assert!(!closed(first.id).await, "before run {i} of {last}");
        let outcome = store.commit(&part(job, *run, first.id, 0), 3).await;
        assert_eq!(outcome.expect("commit"), CommitOutcome::Counted);
    }
    assert!(closed(first.id).await);
    assert!(!closed(second.id).await && !closed(again.id).await);
    for run in &second.runs {
        // The first holder still renders what was handed out once more.
        assert!(!closed(second.id).await);
        let outcome = store.commit(&part(job, *run, second.id, 0), 3).await;
        assert_eq!(outcome.expect("commit"), CommitOutcome::Counted);
    }
    assert!(closed(second.id).await);
}

pub(crate) async fn everything_of_a_deleted_job_goes(store: &Store) {
    let job = submit(store).await;
    let claimed = claim(store, job, 16, 1, 1000).await.expect("work");
    let record = part(job, claimed.runs[0], claimed.id, 0);
    store.commit(&record, 2).await.expect("commit");
    assert!(store.delete_job(job).await.expect("delete"));
    assert!(!store.delete_job(job).await.expect("delete"));
    gone(store, job).await;
    assert_eq!(store.job(job).await.expect("read"), None);
    assert_eq!(store.lease(claimed.id).await.expect("read"), None);
    assert!(!store.names_object(&record.object).await.expect("look"));
    let late = part(job, claimed.runs[1], claimed.id, 1);
    let outcome = store.commit(&late, 9).await.expect("commit");
    assert_eq!(outcome, CommitOutcome::Unknown);
    assert_ne!(submit(store).await, job, "numbers are never used again");
    let listing = JobFilter {
        below: i64::MAX,
        state: None,
        limit: 100,
    };
    let jobs = store.jobs(&listing).await.expect("list");
    assert!(jobs.iter().all(|row| row.id != job));
}
