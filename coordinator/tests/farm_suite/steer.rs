//! What a user does to a job under way, and what its log says.

use crate::farm::{Farm, json, lease_request, problem, start, start_with, worker};
use reqwest::StatusCode;
use serde_json::json as value;
use shearwater_shared::api::{FailureKind, FailureReport, JobView, LogEvent, LogKind, LogPage};
use shearwater_shared::job::{JobId, JobState};
use shearwater_shared::routes;
use std::time::Duration;

async fn steer(farm: &Farm, route: &str, id: JobId) -> JobView {
    let answer = farm
        .post(&routes::fill(route, &id.to_string()), &value!({}))
        .await;
    assert_eq!(answer.status(), StatusCode::OK, "{answer:?}");
    json(answer).await
}

async fn patch(farm: &Farm, id: JobId, body: serde_json::Value) -> reqwest::Response {
    let url = farm.url(&routes::fill(routes::JOB, &id.to_string()));
    farm.http
        .patch(url)
        .json(&body)
        .send()
        .await
        .expect("answer")
}

/// The whole log, oldest first.
pub(crate) async fn log(farm: &Farm, id: JobId) -> Vec<LogEvent> {
    let path = routes::fill(routes::JOB_LOG, &id.to_string());
    let (mut events, mut token) = (Vec::new(), String::new());
    loop {
        let page = farm
            .get(&format!("{path}?page_size=3&page_token={token}"))
            .await;
        let page: LogPage = json(page).await;
        assert!(page.events.len() <= 3);
        events.extend(page.events);
        match page.next_page_token {
            Some(next) => token = next,
            None => break,
        }
    }
    assert!(
        events.is_sorted_by(|a, b| a.seq > b.seq),
        "newest first, each once"
    );
    events.reverse();
    events
}

pub(crate) fn kinds(events: &[LogEvent]) -> Vec<LogKind> {
    events.iter().map(|event| event.kind).collect()
}

#[tokio::test]
async fn a_paused_job_hands_out_nothing_and_takes_what_was_begun() {
    let farm = start().await;
    let job = farm.submit().await;
    let lease = farm.lease("w", 1e6).await.expect("work");
    let paused = steer(&farm, routes::JOB_PAUSE, job.id).await;
    assert_eq!((paused.state, paused.done), (JobState::Paused, false));
    assert!(farm.lease("w", 1e6).await.is_none());
    farm.deliver_run(&job, lease.id, &lease.runs[0], "w").await;
    let listed = farm.get("/v1/jobs?state=paused").await;
    let listed: serde_json::Value = json(listed).await;
    assert_eq!(listed["jobs"][0]["id"], job.id.0, "{listed}");
    let before = farm.job(job.id).await;
    tokio::time::sleep(Duration::from_millis(300)).await;
    let after = farm.job(job.id).await;
    assert_eq!(after.elapsed_s, before.elapsed_s, "the pause takes no time");
    assert_eq!(after.remaining_s, None);
    // Twice is the same as once.
    steer(&farm, routes::JOB_PAUSE, job.id).await;
    let resumed = steer(&farm, routes::JOB_RESUME, job.id).await;
    assert_eq!(resumed.state, JobState::Running);
    assert!(resumed.elapsed_s < before.elapsed_s + 0.25, "{resumed:?}");
    steer(&farm, routes::JOB_RESUME, job.id).await;
    for run in &lease.runs[1..] {
        farm.deliver_run(&job, lease.id, run, "w").await;
    }
    farm.work(&job, "w").await;
    farm.wait(job.id, |job| job.done).await;
    let done = steer(&farm, routes::JOB_PAUSE, job.id).await;
    assert_eq!(done.state, JobState::Done, "an ended one stays as it is");
    let changes = log(&farm, job.id).await.into_iter();
    let changes = changes.filter(|event| event.kind == LogKind::Changed);
    let texts: Vec<_> = changes.filter_map(|event| event.text).collect();
    assert_eq!(texts, ["paused", "resumed"]);
}

#[tokio::test]
async fn a_waiting_worker_wakes_when_its_job_is_resumed() {
    let farm = start_with(|config| config.ask_again_ms = u64::MAX).await;
    let job = farm.submit().await;
    steer(&farm, routes::JOB_PAUSE, job.id).await;
    let (url, http) = (farm.url(routes::WORKER_LEASES), farm.http.clone());
    let waiting = tokio::spawn(async move {
        let answer = http.post(url).json(&lease_request("w", 0.0, 20_000)).send();
        answer.await.expect("answer").status()
    });
    tokio::time::sleep(Duration::from_millis(300)).await;
    steer(&farm, routes::JOB_RESUME, job.id).await;
    assert_eq!(waiting.await.expect("task"), StatusCode::OK);
}

#[tokio::test]
async fn priority_counts_from_the_next_lease_on() {
    let farm = start().await;
    let (first, second) = (farm.submit().await, farm.submit().await);
    let job_of = async |speed| farm.lease("w", speed).await.expect("work").job;
    // Equal ones take turns.
    assert_eq!(job_of(0.0).await, first.id);
    assert_eq!(job_of(0.0).await, second.id);
    assert_eq!(job_of(0.0).await, first.id);
    let raised = patch(&farm, second.id, value!({"priority": 7})).await;
    assert_eq!(json::<JobView>(raised).await.priority, 7);
    for _ in 0..3 {
        assert_eq!(job_of(0.0).await, second.id);
    }
    patch(&farm, first.id, value!({"priority": 8})).await;
    assert_eq!(job_of(0.0).await, first.id);
    for (body, status, kind) in [
        (value!({"priority": 1001}), 422, "invalid"),
        (value!({"priority": -1001}), 422, "invalid"),
        (value!({}), 422, "invalid"),
        (value!({"priority": "high"}), 400, "bad-request"),
        (value!({"name": "x"}), 400, "bad-request"),
    ] {
        problem(patch(&farm, first.id, body).await, status, kind).await;
    }
    problem(
        patch(&farm, JobId(99), value!({"priority": 1})).await,
        404,
        "not-found",
    )
    .await;
    let mut request = farm.scene_request().await;
    request.priority = 5000;
    problem(farm.post(routes::JOBS, &request).await, 422, "invalid").await;
}

#[tokio::test]
async fn a_failed_job_is_tried_again_and_keeps_what_it_has() {
    let farm = start().await;
    let job = farm.submit().await;
    let first = farm.lease("w", 0.0).await.expect("work");
    farm.deliver_run(&job, first.id, &first.runs[0], "w").await;
    for _ in 0..6 {
        let lease = farm.lease("w", 0.0).await.expect("tried again");
        let report = FailureReport {
            worker: worker("w"),
            job: lease.job,
            lease: lease.id,
            run: None,
            frame: None,
            kind: FailureKind::Worker,
            reason: "out of paint".into(),
        };
        farm.post(routes::WORKER_FAILURES, &report).await;
    }
    let failed = farm.job(job.id).await;
    assert_eq!((failed.state, failed.units_done), (JobState::Failed, 1));
    assert!(farm.lease("w", 0.0).await.is_none());
    let again = steer(&farm, routes::JOB_RETRY, job.id).await;
    assert_eq!((again.state, again.failure), (JobState::Running, None));
    steer(&farm, routes::JOB_RETRY, job.id).await;
    // Its failures are forgotten: one more does not end it.
    farm.work(&job, "w").await;
    let done = farm.wait(job.id, |job| job.done).await;
    assert_eq!(done.state, JobState::Done);
    let retry = routes::fill(routes::JOB_RETRY, &job.id.to_string());
    problem(farm.post(&retry, &value!({})).await, 409, "job-not-failed").await;
    let cancelled = farm.submit().await;
    steer(&farm, routes::JOB_CANCEL, cancelled.id).await;
    let retry = routes::fill(routes::JOB_RETRY, &cancelled.id.to_string());
    problem(farm.post(&retry, &value!({})).await, 409, "job-not-failed").await;
    let kinds = kinds(&log(&farm, job.id).await);
    assert_eq!(kinds[..2], [LogKind::Leased, LogKind::Counted]);
    let count = |kind| kinds.iter().filter(|k| **k == kind).count();
    assert_eq!(count(LogKind::Failed), 6);
    assert_eq!(count(LogKind::Ended), 1);
}

#[tokio::test]
async fn the_log_names_worker_units_and_time() {
    let farm = start_with(|config| {
        config.heartbeat_ms = 50;
        config.lease_ttl_ms = 100;
    })
    .await;
    let job = farm.submit().await;
    let kept = farm.lease("w", 0.0).await.expect("work");
    farm.deliver_run(&job, kept.id, &kept.runs[0], "w").await;
    let lost = farm.lease("lost", 0.0).await.expect("work");
    let release = value!({"worker": worker("tired"), "leases": [farm
        .lease("tired", 0.0).await.expect("work").id]});
    farm.post(routes::WORKER_RELEASE, &release).await;
    let events = loop {
        let events = log(&farm, job.id).await;
        if kinds(&events).contains(&LogKind::Expired) {
            break events;
        }
        tokio::time::sleep(Duration::from_millis(100)).await;
    };
    let of = |kind| {
        events
            .iter()
            .find(|event| event.kind == kind)
            .expect("event")
    };
    let counted = of(LogKind::Counted);
    assert_eq!(counted.worker.as_deref(), Some("w-instance"));
    assert_eq!((counted.lease, counted.ms), (Some(kept.id), Some(1000)));
    assert_eq!(counted.runs, [kept.runs[0]]);
    let expired = of(LogKind::Expired);
    assert_eq!(
        (&expired.runs, expired.worker.as_deref()),
        (&lost.runs, Some("lost-instance"))
    );
    assert_eq!(
        of(LogKind::Released).worker.as_deref(),
        Some("tired-instance")
    );
    problem(farm.get("/v1/jobs/99/log").await, 404, "not-found").await;
    problem(
        farm.get("/v1/jobs/1/log?page_token=x").await,
        400,
        "bad-request",
    )
    .await;
}
