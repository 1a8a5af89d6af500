//! What clients save: entity tags, ranges, keys, checks without storing, and streams
//! that are taken up again.

use crate::farm::{Farm, json, problem, start};
use reqwest::{Response, StatusCode};
use shearwater_shared::api::{
    AddSamples, FramePage, JobPage, JobView, SettingsOverride, SubmitCheck, WorkerPage,
};
use shearwater_shared::routes;

async fn get_with(farm: &Farm, path: &str, headers: &[(&str, &str)]) -> Response {
    let mut request = farm.http.get(farm.url(path));
    for (name, value) in headers {
        request = request.header(*name, *value);
    }
    request.send().await.expect("answer")
}

fn header(answer: &Response, name: &str) -> String {
    let value = answer.headers().get(name);
    let value = value.unwrap_or_else(|| panic!("no {name}: {answer:?}"));
    value.to_str().expect("text").to_owned()
}

/// Ranges of what is at `path`, whose bytes are `whole`.
async fn has_ranges(farm: &Farm, path: &str, whole: &[u8]) {
    let length = whole.len();
    let first = farm.get(path).await;
    assert_eq!(header(&first, "accept-ranges"), "bytes");
    let tag = header(&first, "etag");
    assert!(!tag.starts_with("W/"), "{tag}");
    for (range, expected) in [
        ("bytes=0-0", 0..1),
        ("bytes=5-14", 5..15),
        ("bytes=-7", length - 7..length),
        (&format!("bytes={}-", length - 3), length - 3..length),
    ] {
        let part = get_with(farm, path, &[("range", range), ("if-range", &tag)]).await;
        assert_eq!(part.status(), StatusCode::PARTIAL_CONTENT, "{range}");
        let place = format!("bytes {}-{}/{length}", expected.start, expected.end - 1);
        assert_eq!(header(&part, "content-range"), place);
        assert_eq!(header(&part, "etag"), tag);
        assert_eq!(header(&part, "content-length"), expected.len().to_string());
        assert_eq!(part.bytes().await.expect("body"), whole[expected]);
    }
    for ignored in ["bytes=0-1,4-5", "lines=1-2", "bytes=9-2"] {
        let all = get_with(farm, path, &[("range", ignored)]).await;
        assert_eq!(all.status(), StatusCode::OK, "{ignored}");
        assert_eq!(all.bytes().await.expect("body"), whole);
    }
    let other = get_with(farm, path, &[("range", "bytes=0-0"), ("if-range", "\"x\"")]).await;
    assert_eq!(other.status(), StatusCode::OK, "another version");
    let behind = get_with(farm, path, &[("range", &format!("bytes={length}-"))]).await;
    assert_eq!(
        header(&behind, "content-range"),
        format!("bytes */{length}")
    );
    problem(behind, 416, "range").await;
    let known = [("range", "bytes=0-0"), ("if-none-match", tag.as_str())];
    let known = get_with(farm, path, &known).await;
    assert_eq!(known.status(), StatusCode::NOT_MODIFIED);
    let head = farm.http.head(farm.url(path)).header("range", "bytes=0-0");
    let head = head.send().await.expect("answer");
    assert_eq!(head.status(), StatusCode::OK);
    assert_eq!(header(&head, "content-length"), length.to_string());
}

#[tokio::test]
async fn finished_pictures_and_assets_come_in_ranges() {
    let farm = start().await;
    let job = farm.submit().await;
    let exr = routes::fill(routes::JOB_EXR, &job.id.to_string());
    let early = get_with(&farm, &exr, &[("range", "bytes=0-9")]).await;
    assert_eq!(early.status(), StatusCode::OK, "what changes comes whole");
    assert_eq!(header(&early, "accept-ranges"), "none");
    assert!(header(&early, "etag").starts_with("W/"));
    farm.work(&job, "w").await;
    farm.wait(job.id, |job| job.done).await;
    for route in [routes::JOB_EXR, routes::JOB_PNG] {
        let path = routes::fill(route, &job.id.to_string());
        let whole = farm.get(&path).await.bytes().await.expect("body");
        has_ranges(&farm, &path, &whole).await;
    }
    let bytes: Vec<u8> = (0..300_000u32).map(|i| (i % 251) as u8).collect();
    let hash = farm.put_asset(&bytes).await;
    let path = routes::fill(routes::ASSET, &hash.to_string());
    has_ranges(&farm, &path, &bytes).await;
}

#[tokio::test]
async fn a_job_and_its_listings_are_sent_once() {
    let farm = start().await;
    let job = farm.submit().await;
    let id = job.id.to_string();
    let (path, frames) = (
        routes::fill(routes::JOB, &id),
        routes::fill(routes::JOB_FRAMES, &id),
    );
    let tags = async || {
        let mut tags = Vec::new();
        for path in [&path, &frames] {
            let tag = header(&farm.get(path).await, "etag");
            let again = get_with(&farm, path, &[("if-none-match", &tag)]).await;
            assert_eq!(again.status(), StatusCode::NOT_MODIFIED, "{path}");
            assert_eq!(header(&again, "etag"), tag);
            tags.push(tag);
        }
        tags
    };
    let before = tags().await;
    let lease = farm.lease("w", 1e9).await.expect("work");
    let leased = header(&farm.get(&path).await, "etag");
    assert_ne!(leased, before[0], "it runs now");
    // Time alone changes the view, not its meaning.
    tokio::time::sleep(std::time::Duration::from_millis(20)).await;
    assert_eq!(header(&farm.get(&path).await, "etag"), leased);
    farm.deliver_run(&job, lease.id, &lease.runs[0], "w").await;
    let after = tags().await;
    assert!(after[0] != leased && after[1] != before[1]);
}

#[tokio::test]
async fn a_check_stores_nothing() {
    let farm = start().await;
    let mut request = farm.scene_request().await;
    let path = format!("{}?validate_only=true", routes::JOBS);
    let check: SubmitCheck = json(farm.post(&path, &request).await).await;
    assert_eq!((check.name.as_str(), check.units_total), ("two by two", 16));
    assert_eq!(check.samples_max, 96 * 80 * 512);
    let page: JobPage = json(farm.get(routes::JOBS).await).await;
    assert_eq!(page.jobs, []);
    // The number that a stored job would have had is not used up either.
    let job = farm.submit().await;
    assert_eq!((job.id.0, job.units_total), (1, check.units_total));
    assert_eq!(job.settings, check.settings);
    request.settings = SettingsOverride {
        samples: Some(3),
        ..request.settings
    };
    problem(farm.post(&path, &request).await, 422, "invalid").await;
    let odd = format!("{}?validate_only=maybe", routes::JOBS);
    problem(farm.post(&odd, &request).await, 400, "bad-request").await;
}

#[tokio::test]
async fn samples_are_added_once_for_a_key() {
    let farm = start().await;
    let job = farm.submit().await;
    let path = routes::fill(routes::JOB_SAMPLES, &job.id.to_string());
    let add = async |path: &str, add: u32, key: &str| {
        let body = AddSamples {
            add: Some(add),
            ..AddSamples::default()
        };
        let request = farm.http.post(farm.url(path)).json(&body);
        let request = request.header("Idempotency-Key", key);
        request.send().await.expect("answer")
    };
    for _ in 0..3 {
        let more: JobView = json(add(&path, 128, "a").await).await;
        assert_eq!(more.settings.samples, 640);
    }
    problem(add(&path, 256, "a").await, 422, "idempotency-key-reused").await;
    let more: JobView = json(add(&path, 128, "b").await).await;
    assert_eq!(more.settings.samples, 768);
    // A key is of one job.
    let other = farm.submit().await;
    let path = routes::fill(routes::JOB_SAMPLES, &other.id.to_string());
    let more: JobView = json(add(&path, 256, "a").await).await;
    assert_eq!(more.settings.samples, 768);
}

#[tokio::test]
async fn pages_stay_where_they_were_when_jobs_come_and_go() {
    let farm = start().await;
    for _ in 0..4 {
        farm.submit().await;
    }
    let first: JobPage = json(farm.get(&format!("{}?page_size=2", routes::JOBS)).await).await;
    let token = first.next_page_token.expect("more");
    farm.submit().await;
    let gone = routes::fill(routes::JOB, "3");
    let gone = farm.http.delete(farm.url(&gone)).send().await;
    assert!(gone.expect("answer").status().is_success());
    let path = format!("{}?page_size=2&page_token={token}", routes::JOBS);
    let second: JobPage = json(farm.get(&path).await).await;
    let ids: Vec<i64> = second.jobs.iter().map(|job| job.id.0).collect();
    assert_eq!((ids, second.next_page_token), (vec![2, 1], None));
    // A token is of one listing and its filter.
    for path in [
        format!("{}?state=queued&page_token={token}", routes::JOBS),
        format!(
            "{}?page_token={token}",
            routes::fill(routes::JOB_FRAMES, "1")
        ),
        format!("{}?page_token={token}", routes::WORKERS),
    ] {
        problem(farm.get(&path).await, 422, "invalid").await;
    }
    let frames: FramePage = json(farm.get(&routes::fill(routes::JOB_FRAMES, "1")).await).await;
    assert_eq!((frames.frames.len(), frames.next_page_token), (1, None));
}

#[tokio::test]
async fn workers_come_in_pages() {
    let farm = start().await;
    for name in ["c", "a", "b"] {
        assert!(farm.lease(name, 0.0).await.is_none());
    }
    let (mut path, mut seen) = (format!("{}?page_size=2", routes::WORKERS), Vec::new());
    loop {
        let page: WorkerPage = json(farm.get(&path).await).await;
        seen.extend(page.workers.into_iter().map(|worker| worker.worker.name));
        let Some(token) = page.next_page_token else {
            break;
        };
        path = format!("{}?page_size=2&page_token={token}", routes::WORKERS);
    }
    assert_eq!(seen, ["a", "b", "c"]);
}

#[tokio::test]
async fn a_stream_that_is_taken_up_again_begins_with_the_present() {
    let farm = start().await;
    let job = farm.submit().await;
    let path = routes::fill(routes::JOB_EVENTS, &job.id.to_string());
    let first = async |seen: &str| {
        let mut stream = get_with(&farm, &path, &[("last-event-id", seen)]).await;
        assert_eq!(stream.status(), StatusCode::OK);
        let chunk = stream.chunk().await.expect("chunk").expect("event");
        String::from_utf8(chunk.to_vec()).expect("text")
    };
    // Whatever was seen, as long as the job goes on.
    for seen in ["1", "0", "what?"] {
        let event = first(seen).await;
        assert!(
            event.contains("id: 1\n") && event.contains("retry: 2000\n"),
            "{event}"
        );
        assert!(event.contains("\"state\":\"queued\""), "{event}");
    }
    let cancel = routes::fill(routes::JOB_CANCEL, &job.id.to_string());
    let ended: JobView = json(farm.post(&cancel, &()).await).await;
    assert!(first("1").await.contains("\"state\":\"cancelled\""));
    let seen = ended.rev.to_string();
    let nothing = get_with(&farm, &path, &[("last-event-id", &seen)]).await;
    assert_eq!(nothing.status(), StatusCode::NO_CONTENT, "do not come back");
}
