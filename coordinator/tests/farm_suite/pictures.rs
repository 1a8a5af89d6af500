//! Pictures of finished and unfinished jobs.

use crate::farm::{Farm, json, problem, start};
use reqwest::{Response, StatusCode};
use shearwater_shared::api::JobView;
use shearwater_shared::routes;

async fn with_tag(farm: &Farm, path: &str, tag: &str) -> Response {
    let request = farm.http.get(farm.url(path)).header("if-none-match", tag);
    request.send().await.expect("answer")
}

fn tag(answer: &Response) -> String {
    answer.headers()["etag"].to_str().expect("text").to_owned()
}

#[tokio::test]
async fn a_picture_exists_at_any_time_and_changes_its_tag() {
    let farm = start().await;
    let job = farm.submit().await;
    let id = job.id.to_string();
    let (png, exr) = (
        routes::fill(routes::JOB_PNG, &id),
        routes::fill(routes::JOB_EXR, &id),
    );
    let empty = farm.get(&png).await;
    assert_eq!(empty.headers()["content-type"], "image/png");
    let empty_tag = tag(&empty);
    let black = empty.bytes().await.expect("body");
    assert!(black.starts_with(b"\x89PNG"));
    assert_eq!(
        with_tag(&farm, &png, &empty_tag).await.status(),
        StatusCode::NOT_MODIFIED
    );

    let lease = farm.lease("w", 1e9).await.expect("work");
    farm.deliver_run(&job, lease.id, &lease.runs[0], "w").await;
    let partial = with_tag(&farm, &png, &empty_tag).await;
    assert_eq!(partial.status(), StatusCode::OK, "something changed");
    assert_ne!(partial.bytes().await.expect("body"), black);

    for run in &lease.runs[1..] {
        farm.deliver_run(&job, lease.id, run, "w").await;
    }
    let done: JobView = farm.wait(job.id, |job| job.done).await;
    let full = farm.get(&png).await;
    let full_tag = tag(&full);
    let full = full.bytes().await.expect("body");
    let again = with_tag(&farm, &png, &format!("\"x\", W/{full_tag}")).await;
    assert_eq!(again.status(), StatusCode::NOT_MODIFIED);
    assert_eq!(farm.get(&png).await.bytes().await.expect("body"), full);
    let standard = farm
        .get(&format!("{png}?view=standard&exposure_ev=1"))
        .await;
    assert_ne!(tag(&standard), full_tag);
    assert_ne!(standard.bytes().await.expect("body"), full);

    let linear = farm.get(&exr).await;
    assert_eq!(linear.headers()["content-type"], "image/x-exr");
    let bytes = linear.bytes().await.expect("body");
    let hash = done.film_hashes[0].to_string();
    let holds = |text: &str| bytes.windows(text.len()).any(|w| w == text.as_bytes());
    assert!(holds(&hash) && holds(&job.scene_hash.to_string()));
}

#[tokio::test]
async fn bad_questions_about_pictures_are_problems() {
    let farm = start().await;
    let job = farm.submit().await;
    let png = routes::fill(routes::JOB_PNG, &job.id.to_string());
    problem(farm.get(&format!("{png}?frame=1")).await, 404, "not-found").await;
    for bad in [
        "view=sepia",
        "exposure_ev=NaN",
        "exposure_ev=99",
        "frame=-1",
        "depth=9",
        "nome=1",
    ] {
        let answer = farm.get(&format!("{png}?{bad}")).await;
        problem(answer, 400, "bad-request").await;
    }
}

#[tokio::test]
async fn health_is_told() {
    let farm = start().await;
    let health: serde_json::Value = json(farm.get(routes::HEALTHZ).await).await;
    assert_eq!(health["status"], "ok");
    let ready: serde_json::Value = json(farm.get(routes::READYZ).await).await;
    assert_eq!(ready["status"], "ready");
    std::fs::remove_dir_all(farm.dir.path().join("objects")).expect("remove");
    std::fs::write(farm.dir.path().join("objects"), b"in the way").expect("write");
    // Noticed by the coordinator's own next try at writing.
    let started = std::time::Instant::now();
    while farm.get(routes::READYZ).await.status() == 200 {
        assert!(started.elapsed().as_secs() < 30, "never noticed");
        tokio::time::sleep(std::time::Duration::from_millis(50)).await;
    }
    let why = problem(farm.get(routes::READYZ).await, 503, "not-ready").await;
    assert!(why.detail.contains("object store"), "{}", why.detail);
}
