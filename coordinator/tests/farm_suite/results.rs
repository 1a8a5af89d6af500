//! Results in every order, number and cut: the film is the same.

use crate::farm::{brighten, expected_hash, files, part, problem, spoil, start, start_with, sums};
use reqwest::StatusCode;
use shearwater_shared::job::JobState;
use shearwater_shared::plan::{Plan, Run};
use shearwater_shared::wire;
use std::time::Duration;

#[tokio::test]
async fn shuffled_and_repeated_results_give_the_same_film() {
    let farm = start().await;
    let job = farm.submit().await;
    let mut runs = Vec::new();
    while let Some(lease) = farm.lease("w", 5e5).await {
        runs.extend(lease.runs.into_iter().map(|run| (lease.id, run)));
    }
    assert!(runs.len() > 3, "{runs:?}");
    // A fixed shuffle; every third result comes twice at once.
    runs.sort_by_key(|(id, run)| (run.tile * 7 + run.block0 * 5 + *id as u32) % 11);
    for (i, (lease, run)) in runs.iter().enumerate() {
        if i % 3 == 0 {
            let (first, second) = tokio::join!(
                farm.deliver_run(&job, *lease, run, "w"),
                farm.deliver_run(&job, *lease, run, "w")
            );
            assert!(first != second, "one of them is the duplicate");
        } else {
            assert!(!farm.deliver_run(&job, *lease, run, "w").await);
        }
    }
    let done = farm.wait(job.id, |job| job.done).await;
    assert_eq!(done.film_hashes, [expected_hash(&job.settings, 0)]);
    // And again when all is over.
    for (lease, run) in &runs {
        assert!(farm.deliver_run(&job, *lease, run, "w").await);
    }
    let parts = files(&farm.dir.path().join("objects/part"));
    assert_eq!(parts, [""; 0], "what was not counted or is folded is gone");
    let after = farm.job(job.id).await;
    assert_eq!(after.film_hashes, done.film_hashes);
    assert_eq!((after.units_done, after.unequal_results), (16, 0));
}

#[tokio::test]
async fn an_unequal_repetition_is_an_alarm_and_changes_nothing() {
    let farm = start().await;
    let job = farm.submit().await;
    let lease = farm.lease("w", 5e5).await.expect("work");
    farm.deliver_run(&job, lease.id, &lease.runs[0], "w").await;
    let mut liar = part(&job, lease.id, &lease.runs[0], "liar");
    brighten(&mut liar.sums);
    problem(farm.deliver(&liar).await, 409, "unequal-result").await;
    assert_eq!(farm.job(job.id).await.unequal_results, 1);
    for run in &lease.runs[1..] {
        farm.deliver_run(&job, lease.id, run, "w").await;
    }
    farm.work(&job, "w").await;
    let done = farm.wait(job.id, |job| job.done).await;
    assert_eq!(done.film_hashes, [expected_hash(&job.settings, 0)]);
    problem(farm.deliver(&liar).await, 409, "unequal-result").await;
}

#[tokio::test]
async fn overlapping_cuts_are_counted_once() {
    let farm = start().await;
    let job = farm.submit().await;
    let lease = farm.lease("w", 1e9).await.expect("all of it");
    let run = |block0, block1| Run {
        frame: 0,
        tile: 1,
        block0,
        block1,
    };
    assert!(!farm.deliver_run(&job, lease.id, &run(1, 3), "w").await);
    // Refused whole, and blocks 0 and 3 are ready for others at once.
    assert!(farm.deliver_run(&job, lease.id, &run(0, 2), "w").await);
    assert!(farm.deliver_run(&job, lease.id, &run(2, 4), "w").await);
    let freed = farm.lease("w", 1e9).await.expect("freed units");
    assert_eq!(freed.runs, [run(0, 1), run(3, 4)]);
    for run in &freed.runs {
        assert!(!farm.deliver_run(&job, freed.id, run, "w").await);
    }
    // All four are counted, but never in this cut: nothing to compare with.
    assert!(farm.deliver_run(&job, lease.id, &run(0, 4), "w").await);
    for tile in [0, 2, 3] {
        farm.deliver_run(&job, lease.id, &Run { tile, ..run(0, 4) }, "w")
            .await;
    }
    let done = farm.wait(job.id, |job| job.done).await;
    assert_eq!(done.film_hashes, [expected_hash(&job.settings, 0)]);
}

#[tokio::test]
async fn a_late_result_of_an_expired_lease_counts() {
    let farm = start_with(|config| {
        config.heartbeat_ms = 50;
        config.lease_ttl_ms = 100;
    })
    .await;
    let job = farm.submit().await;
    let first = farm.lease("slow", 1e9).await.expect("work");
    let mut second = None;
    for _ in 0..50 {
        tokio::time::sleep(Duration::from_millis(100)).await;
        second = farm.lease("fast", 1e9).await;
        if second.is_some() {
            break;
        }
    }
    let second = second.expect("the expired units");
    assert_ne!(second.id, first.id);
    assert!(
        !farm
            .deliver_run(&job, first.id, &first.runs[0], "slow")
            .await
    );
    assert!(
        farm.deliver_run(&job, second.id, &first.runs[0], "fast")
            .await
    );
    for run in &first.runs[1..] {
        farm.deliver_run(&job, first.id, run, "slow").await;
    }
    let done = farm.wait(job.id, |job| job.done).await;
    assert_eq!(done.film_hashes, [expected_hash(&job.settings, 0)]);
}

#[tokio::test]
async fn bad_samples_are_counted_and_fail_the_job_beyond_their_share() {
    let farm = start().await;
    let job = farm.submit().await;
    let lease = farm.lease("w", 1e9).await.expect("work");
    let with_bad = |run: &Run, bad: u64| {
        let mut part = part(&job, lease.id, run, "w");
        spoil(&mut part.sums, bad);
        part.sums.depth_cap_hits = 5;
        part
    };
    // 3.9 million samples: sixteen bad ones are borne, seventeen are not.
    let answer = farm.deliver(&with_bad(&lease.runs[0], 16)).await;
    assert_eq!(answer.status(), StatusCode::OK);
    let view = farm.job(job.id).await;
    assert_eq!((view.bad_samples, view.depth_cap_hits), (16, 5));
    assert_eq!(view.state, JobState::Running);
    farm.deliver(&with_bad(&lease.runs[1], 1)).await;
    let failed = farm.job(job.id).await;
    assert_eq!(failed.state, JobState::Failed);
    assert!(failed.failure.is_some_and(|text| text.contains("NaN")));
}

#[tokio::test]
async fn results_nobody_asked_for_are_refused_before_the_frame_exists() {
    let farm = start().await;
    let job = farm.submit().await;
    let run = Run {
        frame: 0,
        tile: 0,
        block0: 0,
        block1: 1,
    };
    let early = part(&job, 5, &run, "w");
    problem(farm.deliver(&early).await, 422, "invalid").await;
    assert_eq!(early.sums, sums(&Plan::new(&job.settings), &run, 0));
    assert!(wire::encode_part(&early).is_ok());
}
