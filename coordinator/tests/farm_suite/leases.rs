//! Who gets which work, and what becomes of work that is not done.

use crate::farm::{Farm, json, lease_request, problem, start, start_with, worker};
use reqwest::StatusCode;
use shearwater_shared::api::{
    FailureKind, FailureReport, HeartbeatRequest, HeartbeatResponse, JobView, Lease,
    ReleaseRequest, WorkerPage,
};
use shearwater_shared::job::JobState;
use shearwater_shared::plan::Run;
use shearwater_shared::routes;
use std::time::Duration;

fn blocks(lease: &Lease) -> u32 {
    lease.runs.iter().map(|run| run.block1 - run.block0).sum()
}

async fn heartbeat(farm: &Farm, name: &str, leases: &[i64]) -> Vec<i64> {
    let request = HeartbeatRequest {
        worker: worker(name),
        leases: leases.to_vec(),
    };
    let answer = farm.post(routes::WORKER_HEARTBEAT, &request).await;
    json::<HeartbeatResponse>(answer).await.drop
}

fn failure(name: &str, lease: &Lease, run: Option<Run>, kind: FailureKind) -> FailureReport {
    FailureReport {
        worker: worker(name),
        job: lease.job,
        lease: lease.id,
        run,
        frame: None,
        kind,
        reason: "out of paint".into(),
    }
}

#[tokio::test]
async fn lease_size_follows_speed_and_leaves_some_for_others() {
    let farm = start().await;
    let job = farm.submit().await; // 16 units of 245,760 samples
    let small = farm.lease("new", 0.0).await.expect("work");
    assert_eq!(blocks(&small), 1, "one thread, unknown speed: one unit");
    let fast = farm.lease("fast", 1e9).await.expect("work");
    assert_eq!(blocks(&fast), 3, "half of its half of 15");
    let slow = farm.lease("slow", 50_000.0).await.expect("work");
    assert_eq!(blocks(&slow), 1, "never nothing");
    assert_eq!(farm.job(job.id).await.state, JobState::Running);
    let page: WorkerPage = json(farm.get(routes::WORKERS).await).await;
    let workers = page.workers;
    let names: Vec<_> = workers.iter().map(|w| w.worker.name.as_str()).collect();
    assert_eq!(names, ["fast", "new", "slow"]);
    assert!(
        workers[0].samples_per_s == 1e9 && workers[0].runs_held == 1,
        "{workers:?}"
    );
}

#[tokio::test]
async fn higher_priority_first_then_the_older_job() {
    let farm = start().await;
    let old = farm.submit().await;
    farm.submit().await;
    let mut urgent = farm.scene_request().await;
    urgent.priority = 5;
    let urgent: JobView = json(farm.post(routes::JOBS, &urgent).await).await;
    assert_eq!(farm.lease("w", 1e9).await.expect("work").job, urgent.id);
    assert_eq!(farm.lease("w", 1e9).await.expect("work").job, old.id);
}

#[tokio::test]
async fn a_waiting_worker_wakes_for_a_new_job() {
    // Asked again only when the wait is over: what comes before is a wake-up.
    let farm = start_with(|config| config.ask_again_ms = u64::MAX).await;
    let request = farm.scene_request().await;
    let (url, http) = (farm.url(routes::WORKER_LEASES), farm.http.clone());
    let waiting = tokio::spawn(async move {
        let answer = http.post(url).json(&lease_request("w", 0.0, 20_000)).send();
        let answer = answer.await.expect("answer");
        assert_eq!(answer.status(), StatusCode::OK, "woken, not timed out");
        json::<Lease>(answer).await
    });
    tokio::time::sleep(Duration::from_millis(300)).await;
    let job: JobView = json(farm.post(routes::JOBS, &request).await).await;
    assert_eq!(waiting.await.expect("task").job, job.id);
    let none = farm
        .post(routes::WORKER_LEASES, &lease_request("v", 0.0, 100))
        .await;
    assert_eq!(none.status(), StatusCode::OK, "the rest of the job");
}

#[tokio::test]
async fn heartbeats_keep_leases_and_name_what_to_drop() {
    let farm = start_with(|config| {
        config.heartbeat_ms = 2000;
        config.lease_ttl_ms = 6000;
        config.lease_target_ms = 60_000;
    })
    .await;
    let job = farm.submit().await;
    // Takes 39 s at this speed: not overdue while the test lasts.
    let lease = farm.lease("w", 1e5).await.expect("all of it");
    assert_eq!(blocks(&lease), 16);
    for _ in 0..16 {
        assert_eq!(heartbeat(&farm, "w", &[lease.id]).await, [0i64; 0]);
        tokio::time::sleep(Duration::from_millis(500)).await;
    }
    assert!(
        farm.lease("v", 0.0).await.is_none(),
        "kept beyond its first life"
    );
    assert_eq!(heartbeat(&farm, "v", &[lease.id, 99]).await, [lease.id, 99]);
    for run in &lease.runs {
        farm.deliver_run(&job, lease.id, run, "w").await;
    }
    assert_eq!(heartbeat(&farm, "w", &[lease.id]).await, [lease.id]);
}

#[tokio::test]
async fn released_work_is_ready_at_once_but_only_by_its_holder() {
    let farm = start_with(|config| config.lease_target_ms = 60_000).await;
    farm.submit().await;
    // Takes 39 s at this speed: not overdue while the test lasts.
    let lease = farm.lease("w", 1e5).await.expect("all of it");
    let release = async |name: &str| {
        let request = ReleaseRequest {
            worker: worker(name),
            leases: vec![lease.id],
        };
        let answer = farm.post(routes::WORKER_RELEASE, &request).await;
        assert_eq!(answer.status(), StatusCode::NO_CONTENT);
    };
    release("thief").await;
    assert!(farm.lease("v", 0.0).await.is_none());
    release("w").await;
    let again = farm.lease("w", 1e5).await.expect("work");
    assert!(blocks(&again) > 1);
}

#[tokio::test]
async fn the_last_runs_are_handed_out_twice_and_the_first_result_counts() {
    let farm = start_with(|config| config.lease_target_ms = 60_000).await;
    let job = farm.submit().await;
    // All 16 units in one lease; at this speed they take 39 s.
    let slow = farm.lease("slow", 1e5).await.expect("all of it");
    assert_eq!(blocks(&slow), 16);
    let helper = farm.lease("helper", 1e7).await.expect("the endgame");
    assert!(helper.runs.iter().all(|run| slow.runs.contains(run)));
    assert_eq!(
        helper.runs[0],
        slow.runs[slow.runs.len() - 1],
        "what comes last"
    );
    assert!(
        farm.lease("third", 1e7)
            .await
            .is_none_or(|third| { third.runs.iter().all(|run| !helper.runs.contains(run)) })
    );
    for run in &helper.runs {
        assert!(!farm.deliver_run(&job, helper.id, run, "helper").await);
        assert!(farm.deliver_run(&job, slow.id, run, "slow").await);
    }
    for run in slow.runs.iter().filter(|run| !helper.runs.contains(run)) {
        farm.deliver_run(&job, slow.id, run, "slow").await;
    }
    let done = farm.wait(job.id, |job| job.done).await;
    assert_eq!(
        done.film_hashes,
        [crate::farm::expected_hash(&job.settings, 0)]
    );
}

#[tokio::test]
async fn a_wrong_scene_fails_its_job_at_once() {
    let farm = start().await;
    let job = farm.submit().await;
    let lease = farm.lease("w", 1e9).await.expect("work");
    let stranger = failure("stranger", &lease, None, FailureKind::Scene);
    problem(
        farm.post(routes::WORKER_FAILURES, &stranger).await,
        404,
        "not-found",
    )
    .await;
    let report = failure("w", &lease, None, FailureKind::Scene);
    let answer = farm.post(routes::WORKER_FAILURES, &report).await;
    assert_eq!(answer.status(), StatusCode::NO_CONTENT);
    let failed = farm.job(job.id).await;
    assert_eq!(failed.state, JobState::Failed);
    assert_eq!(failed.failure.as_deref(), Some("out of paint"));
    assert_eq!(failed.failure_kind, Some(FailureKind::Scene));
    assert_eq!(heartbeat(&farm, "w", &[lease.id]).await, [lease.id]);
}

#[tokio::test]
async fn a_unit_that_three_workers_fail_fails_the_job() {
    let farm = start().await;
    let job = farm.submit().await;
    for name in ["a", "b", "c"] {
        let lease = farm.lease(name, 0.0).await.expect("work");
        let first = lease.runs[0];
        assert_eq!((first.tile, first.block0), (0, 0), "tried by others first");
        let report = failure(name, &lease, Some(first), FailureKind::Worker);
        let answer = farm.post(routes::WORKER_FAILURES, &report).await;
        assert_eq!(answer.status(), StatusCode::NO_CONTENT);
        if name == "a" {
            let other = farm.lease("z", 0.0).await.expect("work");
            farm.post(
                routes::WORKER_RELEASE,
                &ReleaseRequest {
                    worker: worker("z"),
                    leases: vec![other.id],
                },
            )
            .await;
            let not_again = farm.lease("a", 0.0).await.expect("other work");
            assert_ne!((not_again.runs[0].tile, not_again.runs[0].block0), (0, 0));
        }
    }
    let failed = farm.job(job.id).await;
    assert_eq!(failed.state, JobState::Failed);
    assert!(
        failed
            .failure
            .is_some_and(|text| text.contains("out of paint"))
    );
}

#[tokio::test]
async fn two_workers_fail_a_unit_in_turn_until_the_job_fails() {
    let farm = start().await;
    let job = farm.submit().await;
    // Both are present from the start.
    let present = farm.lease("b", 0.0).await.expect("work");
    let request = ReleaseRequest {
        worker: worker("b"),
        leases: vec![present.id],
    };
    farm.post(routes::WORKER_RELEASE, &request).await;
    let mut tries = 0;
    for name in ["a", "b"].into_iter().cycle().take(12) {
        let lease = farm.lease(name, 0.0).await.expect("tried again");
        let first = lease.runs[0];
        assert_eq!((first.tile, first.block0), (0, 0), "{name}, try {tries}");
        let report = failure(name, &lease, Some(first), FailureKind::Worker);
        farm.post(routes::WORKER_FAILURES, &report).await;
        tries += 1;
        if farm.job(job.id).await.done {
            break;
        }
    }
    assert_eq!(farm.job(job.id).await.state, JobState::Failed);
    assert_eq!(tries, 6, "the limit of one unit");
}

#[tokio::test]
async fn one_worker_alone_fails_the_job_after_six_tries() {
    let farm = start().await;
    let job = farm.submit().await;
    for _ in 0..6 {
        let lease = farm.lease("only", 0.0).await.expect("tried again");
        let report = failure("only", &lease, None, FailureKind::Worker);
        farm.post(routes::WORKER_FAILURES, &report).await;
    }
    let failed = farm.job(job.id).await;
    assert_eq!(failed.state, JobState::Failed);
    assert_eq!(failed.failure_kind, Some(FailureKind::Worker));
}

#[tokio::test]
async fn a_frame_that_failed_takes_no_other_with_it() {
    let farm = start().await;
    farm.submit().await;
    let lease = farm.lease("w", 1e9).await.expect("work");
    let mut report = failure("w", &lease, None, FailureKind::Worker);
    report.frame = Some(7);
    let answer = farm.post(routes::WORKER_FAILURES, &report).await;
    assert_eq!(answer.status(), StatusCode::UNPROCESSABLE_ENTITY);
    assert!(farm.lease("w", 1e9).await.is_none(), "all is still leased");
    report.frame = Some(0);
    farm.post(routes::WORKER_FAILURES, &report).await;
    let again = farm.lease("w", 1e9).await.expect("freed");
    assert_eq!(blocks(&again), blocks(&lease));
}

#[tokio::test]
async fn a_worker_that_fails_everything_is_quarantined() {
    let farm = start().await;
    farm.submit().await;
    assert!(farm.lease("good", 0.0).await.is_some());
    for _ in 0..3 {
        let lease = farm.lease("sick", 0.0).await.expect("work");
        let report = failure("sick", &lease, None, FailureKind::Worker);
        farm.post(routes::WORKER_FAILURES, &report).await;
    }
    let answer = farm
        .post(routes::WORKER_LEASES, &lease_request("sick", 0.0, 0))
        .await;
    let text = problem(answer, 403, "quarantined").await.detail;
    assert!(text.contains("look at its log"), "{text}");
    assert!(farm.lease("good", 0.0).await.is_some());
}
