//! The re-execution audit: what a worker says is checked by others.

use crate::farm::{Farm, brighten, expected_hash, json, lease_request, part, problem, start_with};
use crate::steer::{kinds, log};
use shearwater_shared::api::{JobView, Lease, LogKind, WorkerPage};
use shearwater_shared::plan::Run;
use shearwater_shared::routes;
use std::time::{Duration, Instant};

async fn farm_of(share_ppm: u32) -> Farm {
    start_with(|config| config.audit_ppm = share_ppm).await
}

/// Deliver a run as a liar does: one sample a step brighter, all else as it should be.
async fn lie(farm: &Farm, job: &JobView, lease: i64, run: &Run, name: &str) -> reqwest::Response {
    let mut part = part(job, lease, run, name);
    brighten(&mut part.sums);
    farm.deliver(&part).await
}

/// Ask until there is work: audits open with results.
async fn lease(farm: &Farm, name: &str) -> Lease {
    let started = Instant::now();
    loop {
        if let Some(lease) = farm.lease(name, 1e5).await {
            return lease;
        }
        assert!(started.elapsed() < Duration::from_secs(20), "no work");
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}

/// Work in turn until the job is done; `liars` lie.
async fn work_all(farm: &Farm, job: &JobView, names: &[&str], liars: &[&str]) -> JobView {
    let started = Instant::now();
    loop {
        for name in names {
            let request = lease_request(name, 1e5, 0);
            let answer = farm.post(routes::WORKER_LEASES, &request).await;
            if answer.status() != reqwest::StatusCode::OK {
                continue;
            }
            let lease: Lease = json(answer).await;
            for run in &lease.runs {
                if liars.contains(name) {
                    lie(farm, job, lease.id, run, name).await;
                } else {
                    farm.deliver(&part(job, lease.id, run, name)).await;
                }
            }
        }
        let now = farm.job(job.id).await;
        if now.done {
            return now;
        }
        assert!(started.elapsed() < Duration::from_secs(60), "{now:?}");
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
}

#[tokio::test]
async fn a_worker_alone_is_not_held_up() {
    let farm = farm_of(1_000_000).await;
    let job = farm.submit().await;
    let started = Instant::now();
    farm.work(&job, "only").await;
    let done = farm.wait(job.id, |job| job.done).await;
    assert!(started.elapsed() < Duration::from_secs(5), "{started:?}");
    assert_eq!(done.film_hashes, [expected_hash(&job.settings, 0)]);
    assert!(done.audits.skipped > 0 && done.audits.open == 0, "{done:?}");
    assert_eq!((done.audits.equal, done.audits.unequal), (0, 0));
}

#[tokio::test]
async fn every_run_is_rendered_again_by_another_worker_when_all_are_audited() {
    let farm = farm_of(1_000_000).await;
    let job = farm.submit().await;
    let done = work_all(&farm, &job, &["a", "b"], &[]).await;
    assert_eq!(done.film_hashes, [expected_hash(&job.settings, 0)]);
    assert_eq!((done.units_done, done.audits.unequal), (16, 0));
    assert!(
        done.audits.equal > 0 && done.audits.skipped == 0,
        "{done:?}"
    );
    let events = log(&farm, job.id).await;
    for event in events.iter().filter(|e| e.kind == LogKind::AuditLeased) {
        for run in &event.runs {
            let first = events
                .iter()
                .find(|e| e.kind == LogKind::Counted && e.runs == [*run]);
            let first = first.and_then(|e| e.worker.clone());
            assert_ne!(first, event.worker, "{run:?}");
        }
    }
}

#[tokio::test]
async fn a_share_of_none_audits_nothing() {
    let farm = farm_of(0).await;
    let job = farm.submit().await;
    let done = work_all(&farm, &job, &["a", "b"], &[]).await;
    assert_eq!(done.audits, shearwater_shared::api::AuditCounts::default());
}

#[tokio::test]
async fn a_liar_is_found_sent_away_and_its_results_are_rendered_again() {
    let farm = farm_of(1_000_000).await;
    let job = farm.submit().await;
    let done = work_all(&farm, &job, &["liar", "a", "b"], &["liar"]).await;
    assert_eq!(done.film_hashes, [expected_hash(&job.settings, 0)]);
    assert!(done.audits.unequal > 0, "{done:?}");
    assert_eq!((done.units_done, done.samples_done), (16, 16 * 245_760));
    let workers = json::<WorkerPage>(farm.get(routes::WORKERS).await)
        .await
        .workers;
    for shown in &workers {
        let is_liar = shown.worker.name == "liar";
        assert_eq!(shown.quarantined_s.is_some(), is_liar, "{shown:?}");
        let reason = shown.quarantine_reason.as_deref().unwrap_or_default();
        assert_eq!(reason.contains("differ"), is_liar, "{shown:?}");
    }
    let request = lease_request("liar", 1e5, 0);
    let answer = farm.post(routes::WORKER_LEASES, &request).await;
    let text = problem(answer, 403, "quarantined").await.detail;
    assert!(text.contains("differ"), "{text}");
    let kinds = kinds(&log(&farm, job.id).await);
    for kind in [
        LogKind::AuditUnequal,
        LogKind::Distrusted,
        LogKind::Withdrawn,
    ] {
        assert!(kinds.contains(&kind), "{kind:?} in {kinds:?}");
    }
}

#[tokio::test]
async fn what_is_in_a_film_already_is_withdrawn_too() {
    let farm = farm_of(1_000_000).await;
    let job = farm.submit().await;
    // Whole tiles, so that they are folded before anybody else has rendered anything.
    let all = farm.lease("liar", 1e9).await.expect("all of it");
    assert_eq!(all.runs.len(), 4);
    for run in &all.runs[..2] {
        lie(&farm, &job, all.id, run, "liar").await;
    }
    let films = farm.dir.path().join("objects/film/1/0");
    let folded = || std::fs::read_dir(&films).is_ok_and(|films| films.count() >= 2);
    while !folded() {
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    for name in ["a", "b"] {
        let lease = lease(&farm, name).await;
        assert_eq!(lease.runs, all.runs[..2], "what is counted is audited");
        for run in &lease.runs {
            farm.deliver(&part(&job, lease.id, run, name)).await;
        }
    }
    let done = work_all(&farm, &job, &["a", "b"], &[]).await;
    assert_eq!(done.film_hashes, [expected_hash(&job.settings, 0)]);
    assert!(done.audits.unequal > 0, "{done:?}");
    assert_eq!((done.units_done, done.samples_done), (16, 16 * 245_760));
}

#[tokio::test]
async fn a_result_of_a_liar_that_comes_late_is_refused() {
    let farm = farm_of(1_000_000).await;
    let job = farm.submit().await;
    let held = farm.lease("liar", 1e5).await.expect("work");
    let more = farm.lease("liar", 1e5).await.expect("work");
    for run in &held.runs {
        lie(&farm, &job, held.id, run, "liar").await;
    }
    for name in ["a", "b"] {
        let lease = lease(&farm, name).await;
        assert_eq!(lease.runs[0], held.runs[0], "audits come first");
        farm.deliver(&part(&job, lease.id, &lease.runs[0], name))
            .await;
    }
    problem(
        lie(&farm, &job, more.id, &more.runs[0], "liar").await,
        403,
        "quarantined",
    )
    .await;
    let done = work_all(&farm, &job, &["a", "b"], &[]).await;
    assert_eq!(done.film_hashes, [expected_hash(&job.settings, 0)]);
}

#[tokio::test]
async fn nobody_is_believed_about_what_was_not_leased_to_it() {
    let farm = farm_of(1_000_000).await;
    let job = farm.submit().await;
    let held = farm.lease("honest", 1e5).await.expect("work");
    let run = held.runs[0];
    farm.deliver_run(&job, held.id, &run, "honest").await;
    for name in ["x", "y"] {
        // With a lease of another, or with none.
        problem(
            lie(&farm, &job, held.id, &run, name).await,
            409,
            "unequal-result",
        )
        .await;
        problem(
            lie(&farm, &job, 99, &run, name).await,
            409,
            "unequal-result",
        )
        .await;
    }
    let workers = json::<WorkerPage>(farm.get(routes::WORKERS).await)
        .await
        .workers;
    assert!(workers.iter().all(|shown| shown.quarantined_s.is_none()));
    for run in &held.runs[1..] {
        farm.deliver_run(&job, held.id, run, "honest").await;
    }
    farm.work(&job, "honest").await;
    let done = farm.wait(job.id, |job| job.done).await;
    assert_eq!(done.film_hashes, [expected_hash(&job.settings, 0)]);
}
