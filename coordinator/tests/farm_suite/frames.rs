//! Jobs of several frames.

use crate::farm::{Farm, SCENE, expected_hash, json, part, problem, spoil, start};
use reqwest::StatusCode;
use shearwater_shared::api::{FramePage, FrameState, FrameView, JobView, SettingsOverride};
use shearwater_shared::limits::{FILM_HASHES_MAX, FRAMES_MAX};
use shearwater_shared::routes;

fn moving(frames: u32) -> String {
    let animation = format!("\"animation\": {{ \"fps\": 25, \"frames\": {frames} }}, \"job\"");
    SCENE.replace("\"job\"", &animation)
}

async fn try_submit(farm: &Farm, scene: &str, settings: SettingsOverride) -> reqwest::Response {
    let mut request = farm.scene_request().await;
    request.manifest.scene = farm.put_asset(scene.as_bytes()).await;
    request.settings = settings;
    farm.post(routes::JOBS, &request).await
}

async fn submit(farm: &Farm, scene: &str, settings: SettingsOverride) -> JobView {
    let answer = try_submit(farm, scene, settings).await;
    assert_eq!(answer.status(), StatusCode::CREATED);
    json(answer).await
}

fn cut(first_frame: u32, frames: u32) -> SettingsOverride {
    SettingsOverride {
        frames: Some(frames),
        first_frame: Some(first_frame),
        ..SettingsOverride::default()
    }
}

async fn frames(farm: &Farm, job: &JobView, page_size: u32) -> Vec<FrameView> {
    let path = routes::fill(routes::JOB_FRAMES, &job.id.to_string());
    let (mut token, mut frames) = (String::new(), Vec::new());
    loop {
        let query = format!("{path}?page_size={page_size}&page_token={token}");
        let page: FramePage = json(farm.get(&query).await).await;
        assert!(page.frames.len() <= page_size as usize);
        frames.extend(page.frames);
        match page.next_page_token {
            Some(next) => token = next,
            None => return frames,
        }
    }
}

#[tokio::test]
async fn one_frame_of_bad_samples_fails_a_long_film() {
    let farm = start().await;
    let job = submit(&farm, &moving(1000), SettingsOverride::default()).await;
    let lease = farm.lease("w", 1e9).await.expect("work");
    let run = lease.runs[0];
    let mut bad = part(&job, lease.id, &run, "w");
    // Of 3.9 million samples of the frame; nearly none of the film's.
    spoil(&mut bad.sums, 17);
    farm.deliver(&bad).await;
    let failed = farm.job(job.id).await;
    let reason = failed.failure.expect("failed");
    let frame = format!("17 of 3932160 samples of frame {} ", run.frame);
    assert!(reason.contains(&frame), "{reason}");
}

#[tokio::test]
async fn every_frame_has_its_film_error_and_picture() {
    let farm = start().await;
    let job = submit(&farm, &moving(3), SettingsOverride::default()).await;
    assert_eq!((job.settings.first_frame, job.settings.frames), (0, 3));
    assert_eq!((job.units_total, job.fps), (3 * 16, Some(25.0)));
    assert_eq!(job.animation_frames, Some(3));
    let waiting = frames(&farm, &job, 2).await;
    let states: Vec<FrameState> = waiting.iter().map(|frame| frame.state).collect();
    assert_eq!(states, [FrameState::Waiting; 3]);
    farm.work(&job, "w").await;
    let done = farm.wait(job.id, |job| job.done).await;
    let hashes: Vec<_> = (0..3).map(|n| expected_hash(&job.settings, n)).collect();
    assert_eq!((done.frames_done, &done.film_hashes), (3, &hashes));
    let listed = frames(&farm, &job, 2).await;
    let mut worst = (0, 0.0);
    for (number, frame) in (0..).zip(&listed) {
        assert_eq!((frame.frame, frame.state), (number, FrameState::Done));
        assert_eq!((frame.units_done, frame.units_total), (16, 16));
        assert_eq!(frame.film_hash, Some(hashes[number as usize]));
        let nmse = frame.error.expect("error").nmse;
        if nmse > worst.1 {
            worst = (number, nmse);
        }
    }
    let error = done.error.expect("error");
    assert_eq!((done.error_frame, error.nmse), (Some(worst.0), worst.1));
    let png = routes::fill(routes::JOB_PNG, &job.id.to_string());
    let mut tags: Vec<String> = Vec::new();
    for frame in 0..3 {
        let answer = farm.get(&format!("{png}?frame={frame}")).await;
        let tag = answer.headers()["etag"].to_str().expect("text").to_owned();
        assert!(!tags.contains(&tag), "another frame, another picture");
        tags.push(tag);
    }
    problem(farm.get(&format!("{png}?frame=3")).await, 404, "not-found").await;
}

#[tokio::test]
async fn a_job_may_begin_later() {
    let farm = start().await;
    let job = submit(&farm, &moving(3), cut(1, 2)).await;
    let lease = farm.lease("w", 1e9).await.expect("work");
    assert_eq!(lease.settings.first_frame, 1);
    let numbers: std::collections::BTreeSet<u32> = lease.runs.iter().map(|r| r.frame).collect();
    assert_eq!(Vec::from_iter(numbers), [0, 1], "counted from 0 in runs");
    for run in lease.runs.iter().filter(|run| run.frame == 0) {
        farm.deliver_run(&job, lease.id, run, "w").await;
    }
    let half = farm.wait(job.id, |job| job.frames_done == 1).await;
    assert_eq!((half.done, half.error_frame), (false, Some(1)));
    for run in lease.runs.iter().filter(|run| run.frame == 1) {
        farm.deliver_run(&job, lease.id, run, "w").await;
    }
    farm.wait(job.id, |job| job.done).await;
    let numbers: Vec<u32> = frames(&farm, &job, 9)
        .await
        .iter()
        .map(|f| f.frame)
        .collect();
    assert_eq!(numbers, [1, 2]);
    let exr = routes::fill(routes::JOB_EXR, &job.id.to_string());
    for frame in [0, 3] {
        let answer = farm.get(&format!("{exr}?frame={frame}")).await;
        let text = problem(answer, 404, "not-found").await.detail;
        assert!(text.contains("frames 1 to 2"), "{text}");
    }
    for query in ["", "?frame=1", "?frame=2"] {
        let answer = farm.get(&format!("{exr}{query}")).await;
        assert_eq!(answer.status(), StatusCode::OK, "{query}");
    }
}

#[tokio::test]
async fn frames_that_cannot_be_are_refused() {
    let farm = start().await;
    for (scene, settings, words) in [
        (SCENE.to_owned(), cut(0, 2), "no `animation`"),
        (SCENE.to_owned(), cut(1, 1), "no `animation`"),
        (moving(3), cut(0, 0), "settings.frames is 0"),
        (moving(3), cut(0, FRAMES_MAX + 1), "settings.frames"),
        (moving(3), cut(FRAMES_MAX - 1, 2), "settings.first_frame"),
        (moving(3), cut(u32::MAX, 1), "settings.first_frame"),
    ] {
        let answer = try_submit(&farm, &scene, settings).await;
        let text = problem(answer, 422, "invalid").await.detail;
        assert!(text.contains(words), "{words}: {text}");
    }
    let job = submit(&farm, SCENE, cut(0, 1)).await;
    assert_eq!((job.fps, job.settings.frames), (None, 1));
    let path = routes::fill(routes::JOB_FRAMES, &job.id.to_string());
    for bad in ["?page_token=x", "?page_token=7", "?page_size=x", "?nome=1"] {
        let answer = farm.get(&format!("{path}{bad}")).await;
        problem(answer, 400, "bad-request").await;
    }
    let path = routes::fill(routes::JOB_FRAMES, "99");
    problem(farm.get(&path).await, 404, "not-found").await;
}

// One unit for each frame.
#[tokio::test]
async fn many_frames_stay_out_of_the_jobs_own_json() {
    let farm = start().await;
    let small = SettingsOverride {
        width: Some(8),
        height: Some(8),
        samples: Some(2),
        ..SettingsOverride::default()
    };
    let all = FILM_HASHES_MAX + 1;
    let job = submit(&farm, &moving(all), small).await;
    farm.work(&job, "w").await;
    let done = farm.wait(job.id, |job| job.done).await;
    assert_eq!(done.frames_done, u64::from(all));
    assert!(done.film_hashes.is_empty(), "too many to be listed");
    let listed = frames(&farm, &job, 50).await;
    let hashes: Vec<_> = listed.iter().map(|frame| frame.film_hash).collect();
    let expected = (0..all).map(|frame| Some(expected_hash(&job.settings, frame)));
    assert_eq!(hashes, Vec::from_iter(expected));

    let huge = SettingsOverride {
        frames: Some(FRAMES_MAX),
        ..small
    };
    let job = submit(&farm, &moving(all), huge).await;
    let lease = farm.lease("w", 1e9).await.expect("work");
    farm.deliver_run(&job, lease.id, &lease.runs[0], "w").await;
    let path = routes::fill(routes::JOB, &job.id.to_string());
    let text = farm.get(&path).await.text().await.expect("body");
    assert!(text.len() < 2_000, "{text}");
    let path = routes::fill(routes::JOB_FRAMES, &job.id.to_string());
    let page: FramePage = json(farm.get(&format!("{path}?page_size=3")).await).await;
    assert_eq!(page.frames.len(), 3);
    assert!(page.next_page_token.is_some());
}
