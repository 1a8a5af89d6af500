//! Jobs from submission to film.

use crate::farm::{SCENE, asset_ref, expected_hash, files, json, problem, start};
use reqwest::StatusCode;
use shearwater_shared::api::{JobPage, JobView, SettingsOverride};
use shearwater_shared::job::JobState;
use shearwater_shared::routes;
use std::time::Duration;

#[tokio::test]
async fn from_submission_to_the_exact_film() {
    let farm = start().await;
    let job = farm.submit().await;
    assert_eq!(job.state, JobState::Queued);
    assert_eq!((job.settings.samples, job.units_total), (512, 16));
    farm.work(&job, "w").await;
    let done = farm.wait(job.id, |job| job.done).await;
    assert_eq!(done.state, JobState::Done, "{done:?}");
    assert_eq!(done.film_hashes, [expected_hash(&job.settings, 0)]);
    assert_eq!((done.units_done, done.progress), (16, 1.0));
    assert_eq!(done.samples_done, 96 * 80 * 512);
    assert!(done.core_s >= 1.0 && done.finished_ms.is_some());
    assert!(done.error.is_some_and(|error| error.mse > 0.0));
    assert!(done.rev > job.rev);
    // Parts and old films are gone, one film per tile stays.
    let objects = files(&farm.dir.path().join("objects"));
    assert_eq!(objects.iter().filter(|f| f.contains("/part/")).count(), 0);
    assert_eq!(objects.iter().filter(|f| f.contains("/film/")).count(), 4);
    farm.coordinator.shutdown().await;
}

#[tokio::test]
async fn submissions_are_checked() {
    let farm = start().await;
    let good = farm.scene_request().await;
    let mut no_scene = good.clone();
    no_scene.manifest.scene = asset_ref(b"nowhere").hash;
    let answer = farm.post(routes::JOBS, &no_scene).await;
    let text = problem(answer, 422, "invalid").await.detail;
    assert!(text.contains("PUT it to /v1/assets/"), "{text}");

    let mut no_file = good.clone();
    no_file.manifest.files = [("a.obj".to_owned(), asset_ref(b"nowhere"))].into();
    problem(farm.post(routes::JOBS, &no_file).await, 422, "invalid").await;

    let broken = SCENE.replace("\"name\"", "\"nome\"");
    let mut bad_scene = good.clone();
    bad_scene.manifest.scene = farm.put_asset(broken.as_bytes()).await;
    let answer = farm.post(routes::JOBS, &bad_scene).await;
    let text = problem(answer, 422, "invalid").await.detail;
    assert!(
        text.contains("scene.json") && text.contains("nome"),
        "{text}"
    );

    for (settings, word) in [
        (
            SettingsOverride {
                samples: Some(3),
                ..good.settings
            },
            "samples",
        ),
        (
            SettingsOverride {
                width: Some(0),
                ..good.settings
            },
            "width",
        ),
        (
            SettingsOverride {
                width: Some(8192),
                height: Some(8192),
                samples: Some(1 << 24),
                ..good.settings
            },
            "units",
        ),
    ] {
        let mut bad = good.clone();
        bad.settings = settings;
        let text = problem(farm.post(routes::JOBS, &bad).await, 422, "invalid")
            .await
            .detail;
        assert!(text.contains(word), "{text}");
    }
    let page: JobPage = json(farm.get(routes::JOBS).await).await;
    assert_eq!(page.jobs, []);
}

#[tokio::test]
async fn an_idempotency_key_makes_one_job() {
    let farm = start().await;
    let request = farm.scene_request().await;
    let send = async |request: &shearwater_shared::api::SubmitRequest, key: &str| {
        let post = farm.http.post(farm.url(routes::JOBS)).json(request);
        post.header("Idempotency-Key", key)
            .send()
            .await
            .expect("answer")
    };
    let first = send(&request, "a").await;
    assert_eq!(first.status(), StatusCode::CREATED);
    assert_eq!(first.headers()["location"], "/v1/jobs/1");
    let again = send(&request, "a").await;
    assert_eq!(again.status(), StatusCode::OK);
    assert_eq!(
        json::<JobView>(first).await.id,
        json::<JobView>(again).await.id
    );
    let mut other = request.clone();
    other.priority = 1;
    problem(send(&other, "a").await, 422, "idempotency-key-reused").await;
    assert_eq!(send(&other, "b").await.status(), StatusCode::CREATED);
    problem(send(&other, &"x".repeat(300)).await, 400, "bad-request").await;
    let page: JobPage = json(farm.get(routes::JOBS).await).await;
    assert_eq!(page.jobs.len(), 2);
}

#[tokio::test]
async fn listing_pages_and_filters() {
    let farm = start().await;
    for _ in 0..5 {
        farm.submit().await;
    }
    let first: JobView = farm.job(shearwater_shared::job::JobId(1)).await;
    assert_eq!(farm.lease("w", 1e6).await.expect("work").job, first.id);
    let cancel = farm.post(&routes::fill(routes::JOB_CANCEL, "2"), &()).await;
    assert_eq!(json::<JobView>(cancel).await.state, JobState::Cancelled);
    let (mut path, mut seen) = (format!("{}?page_size=2", routes::JOBS), Vec::new());
    loop {
        let page: JobPage = json(farm.get(&path).await).await;
        seen.extend(page.jobs.iter().map(|job| job.id.0));
        let Some(token) = page.next_page_token else {
            break;
        };
        path = format!("{}?page_size=2&page_token={token}", routes::JOBS);
    }
    assert_eq!(seen, [5, 4, 3, 2, 1]);
    for (state, expected) in [
        ("queued", vec![5, 4, 3]),
        ("running", vec![1]),
        ("cancelled", vec![2]),
        ("done", vec![]),
        ("failed", vec![]),
    ] {
        let path = format!("{}?state={state}", routes::JOBS);
        let page: JobPage = json(farm.get(&path).await).await;
        let ids: Vec<i64> = page.jobs.iter().map(|job| job.id.0).collect();
        assert_eq!(ids, expected, "{state}");
    }
    for bad in ["?page_size=x", "?state=gone", "?page_token=x", "?nome=1"] {
        let answer = farm.get(&format!("{}{bad}", routes::JOBS)).await;
        problem(answer, 400, "bad-request").await;
    }
}

#[tokio::test]
async fn a_cancelled_or_deleted_job_takes_nothing_more() {
    let farm = start().await;
    let job = farm.submit().await;
    let lease = farm.lease("w", 1e6).await.expect("work");
    farm.deliver_run(&job, lease.id, &lease.runs[0], "w").await;
    let path = routes::fill(routes::JOB_CANCEL, &job.id.to_string());
    for _ in 0..2 {
        let answer = farm.post(&path, &()).await;
        assert_eq!(json::<JobView>(answer).await.state, JobState::Cancelled);
    }
    let late = crate::farm::part(&job, lease.id, &lease.runs[1], "w");
    problem(farm.deliver(&late).await, 410, "job-ended").await;
    assert!(farm.lease("w", 1e6).await.is_none());
    let path = routes::fill(routes::JOB, &job.id.to_string());
    let delete = async || {
        farm.http
            .delete(farm.url(&path))
            .send()
            .await
            .expect("answer")
    };
    assert_eq!(delete().await.status(), StatusCode::NO_CONTENT);
    problem(delete().await, 404, "not-found").await;
    problem(farm.get(&path).await, 404, "not-found").await;
    problem(farm.deliver(&late).await, 404, "not-found").await;
    // Objects go after the answer.
    let started = std::time::Instant::now();
    loop {
        let left = files(&farm.dir.path().join("objects"));
        if left.iter().all(|file| file.contains("/asset/")) {
            break;
        }
        assert!(started.elapsed() < Duration::from_secs(30), "{left:?}");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
}

#[tokio::test]
async fn events_tell_every_step_and_end_with_the_job() {
    let farm = start().await;
    let job = farm.submit().await;
    let path = routes::fill(routes::JOB_EVENTS, &job.id.to_string());
    let mut stream = farm.get(&path).await;
    assert_eq!(stream.headers()["content-type"], "text/event-stream");
    let first = stream.chunk().await.expect("chunk").expect("event");
    let first = String::from_utf8(first.to_vec()).expect("text");
    assert!(
        first.contains("\"state\":\"queued\"") && first.contains("id: 1"),
        "{first}"
    );
    farm.work(&job, "w").await;
    let mut rest = String::new();
    while let Some(chunk) = stream.chunk().await.expect("chunk") {
        rest.push_str(&String::from_utf8_lossy(&chunk));
    }
    let last = rest
        .lines()
        .rfind(|line| line.starts_with("data:"))
        .expect("event");
    let last: JobView = serde_json::from_str(&last[5..]).expect("view");
    assert_eq!(last.state, JobState::Done);
    assert_eq!(last.film_hashes, [expected_hash(&job.settings, 0)]);
}

#[tokio::test]
async fn a_shutdown_ends_streams_and_polls() {
    let farm = start().await;
    let job = farm.submit().await;
    farm.work(&job, "w").await;
    let idle = farm.submit().await;
    assert!(farm.lease("w", 0.0).await.is_some());
    let path = routes::fill(routes::JOB_EVENTS, &idle.id.to_string());
    let mut stream = farm.get(&path).await;
    let (url, http) = (farm.url(routes::WORKER_LEASES), farm.http.clone());
    // A worker that waits for twenty seconds.
    farm.http
        .post(farm.url(&routes::fill(routes::JOB_CANCEL, &idle.id.to_string())))
        .send()
        .await
        .expect("answer");
    let poll = tokio::spawn(async move {
        let request = crate::farm::lease_request("idle", 0.0, 20_000);
        http.post(url).json(&request).send().await
    });
    tokio::time::sleep(Duration::from_millis(200)).await;
    let started = std::time::Instant::now();
    farm.coordinator.shutdown().await;
    assert!(started.elapsed() < Duration::from_secs(5));
    while let Ok(Some(_)) = stream.chunk().await {}
    let answer = poll.await.expect("task").expect("an answer, not a reset");
    assert_eq!(answer.status(), StatusCode::NO_CONTENT);
}
