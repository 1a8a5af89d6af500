//! A worker against a coordinator that is slow, wrong, rude or gone.

mod fake;

use fake::{Fake, Script, lease_of};
use shearwater_shared::api::FailureKind;
use shearwater_shared::film::TileSums;
use shearwater_shared::plan::Run;
use shearwater_worker::WorkerError;
use std::collections::BTreeMap;
use std::time::Duration;

const SKY: &str = r#"{
  "version": 1, "name": "sky", "image": {"width": 128, "height": 64},
  "camera": {"position_m": [0, 1, 4], "target_m": [0, 0, 0], "vertical_fov_deg": 40},
  "sky": {"type": "constant", "radiance": [0.5, 0.7, 1.0]}
}"#;

/// So many samples that only a cancelled run ends within a test.
const ENDLESS: u32 = 1 << 22;

fn run(tile: u32, block: u32) -> Run {
    Run {
        frame: 0,
        tile,
        block0: block,
        block1: block + 1,
    }
}

fn four_runs() -> Vec<Run> {
    vec![run(0, 0), run(1, 1), run(1, 0), run(0, 1)]
}

#[tokio::test(flavor = "multi_thread")]
async fn a_result_is_kept_until_it_is_acknowledged() {
    let mut script = Script::default();
    lease_of(&mut script, 5, SKY, 256, four_runs());
    script.result_errors = [503, 500, 429, 503].into();
    let fake = Fake::start(script).await;
    let working = fake.work(2);
    fake.until("four parts", |s| s.parts.len() == 4).await;
    let summary = working.stop().await.expect("worker");
    let script = fake.script.lock().expect("script");
    let mut runs: Vec<_> = script.parts.iter().map(|part| part.run).collect();
    runs.sort();
    assert_eq!(runs, [run(0, 0), run(0, 1), run(1, 0), run(1, 1)]);
    assert_eq!((script.tries, summary.runs, summary.refused), (8, 4, 0));
    assert_eq!(summary.samples, 4 * 64 * 64 * 128);
    assert!(script.parts.iter().all(|part| part.lease == 5));
    assert!(script.released.is_empty() && script.failures.is_empty());
}

#[tokio::test(flavor = "multi_thread")]
async fn an_unwanted_result_is_dropped() {
    let mut script = Script::default();
    lease_of(&mut script, 5, SKY, 256, four_runs());
    script.result_errors = [410].into();
    let fake = Fake::start(script).await;
    let working = fake.work(1);
    fake.until("three parts", |s| s.parts.len() == 3).await;
    let summary = working.stop().await.expect("worker");
    assert_eq!((summary.runs, summary.refused), (3, 1));
    assert_eq!(fake.script.lock().expect("script").tries, 4);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_refused_worker_says_why_and_ends() {
    let fake = Fake::start(Script {
        refuse: true,
        ..Script::default()
    })
    .await;
    let error = fake.work(1).end().await.expect_err("refused");
    assert!(matches!(error, WorkerError::Refused { .. }), "{error}");
    assert!(error.to_string().contains("because the test says so"));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_dropped_lease_stops_at_once() {
    let mut script = Script::default();
    lease_of(
        &mut script,
        5,
        SKY,
        ENDLESS,
        vec![Run {
            frame: 0,
            tile: 0,
            block0: 0,
            block1: ENDLESS / 128,
        }],
    );
    let fake = Fake::start(script).await;
    let working = fake.work(1);
    fake.until("a heartbeat", |s| {
        s.heartbeats.iter().any(|beat| beat.leases == [5])
    })
    .await;
    {
        let mut script = fake.script.lock().expect("script");
        script.drop = vec![5];
        lease_of(&mut script, 6, SKY, 256, four_runs());
    }
    fake.until("the next lease's parts", |s| s.parts.len() == 4)
        .await;
    working.stop().await.expect("worker");
    let script = fake.script.lock().expect("script");
    assert!(script.parts.iter().all(|part| part.lease == 6));
    assert!(script.released.is_empty());
}

#[tokio::test(flavor = "multi_thread")]
async fn a_wrong_scene_is_reported_with_its_text() {
    let mut script = Script::default();
    let wrong = SKY.replace("\"radiance\"", "\"brightness\"");
    lease_of(&mut script, 5, &wrong, 256, four_runs());
    let fake = Fake::start(script).await;
    let working = fake.work(1);
    fake.until("a report", |s| !s.failures.is_empty()).await;
    let summary = working.stop().await.expect("worker");
    let script = fake.script.lock().expect("script");
    let report = &script.failures[0];
    assert_eq!((report.kind, report.run), (FailureKind::Scene, None));
    assert!(report.reason.contains("scene.json"), "{}", report.reason);
    assert!(report.reason.contains("brightness"), "{}", report.reason);
    assert_eq!((summary.failures, summary.runs), (1, 0));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_run_that_is_not_of_the_plan_is_reported() {
    let mut script = Script::default();
    lease_of(&mut script, 5, SKY, 256, vec![run(7, 0)]);
    let fake = Fake::start(script).await;
    let working = fake.work(1);
    fake.until("a report", |s| !s.failures.is_empty()).await;
    working.stop().await.expect("worker");
    let script = fake.script.lock().expect("script");
    assert_eq!(script.failures[0].kind, FailureKind::Worker);
}

/// Frames at 1 per second of [`SKY`]; the camera stands in its target at second
/// `blind_s`.
fn film(blind_s: u32) -> String {
    let key = |time_s: u32, y_m: f64, z_m: f64| {
        format!(r#"{{"time_s": {time_s}, "target_offset_m": [0, {y_m}, {z_m}]}}"#)
    };
    let keys = [key(blind_s - 1, 0.5, 2.0), key(blind_s + 1, 1.5, 6.0)].join(", ");
    let path = format!("\"path\": [{keys}], \"vertical");
    let animation = r#""animation": {"fps": 1, "frames": 1000}, "sky""#;
    SKY.replace("\"vertical", &path)
        .replace("\"sky\": {", &format!("{animation}: {{"))
}

/// A lease of one run for each of `frames` frames, the scene's from `first_frame`.
fn lease_of_frames(script: &mut Script, scene: &str, first_frame: u32, frames: u32) {
    let runs = (0..frames).map(|frame| Run { frame, ..run(0, 0) });
    lease_of(script, 5, scene, 512, runs.collect());
    let settings = &mut script.leases[0].settings;
    settings.frames = frames;
    settings.first_frame = first_frame;
}

#[tokio::test(flavor = "multi_thread")]
async fn few_frames_are_built_ahead_and_a_wrong_one_is_named() {
    let mut script = Script::default();
    lease_of_frames(&mut script, &film(40), 20, 32);
    let fake = Fake::start(script).await;
    let working = fake.work(1);
    fake.until("a report", |s| !s.failures.is_empty()).await;
    working.stop().await.expect("worker");
    let script = fake.script.lock().expect("script");
    let report = &script.failures[0];
    assert_eq!(report.kind, FailureKind::Scene);
    assert!(report.reason.starts_with("scene.json"), "{}", report.reason);
    assert!(report.reason.contains("frame 40"), "{}", report.reason);
    // 20 frames come before it; one may wait and one be rendered.
    let rendered = script.parts.len();
    assert!((18..=20).contains(&rendered), "{rendered}");
}

#[tokio::test(flavor = "multi_thread")]
async fn only_the_frame_that_failed_is_reported() {
    let mut script = Script::default();
    lease_of_frames(&mut script, &film(900), 0, 3);
    script.leases[0].runs[1].tile = 7;
    let fake = Fake::start(script).await;
    let working = fake.work(1);
    fake.until("a report and two parts", |s| {
        s.failures.len() == 1 && s.parts.len() == 2
    })
    .await;
    let summary = working.stop().await.expect("worker");
    let script = fake.script.lock().expect("script");
    let report = &script.failures[0];
    assert_eq!((report.frame, report.run), (Some(1), None));
    let frames: Vec<u32> = script.parts.iter().map(|part| part.run.frame).collect();
    assert_eq!((frames, summary.failures), (vec![0, 2], 1));
    assert!(script.released.is_empty(), "nothing is left of the lease");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_damaged_asset_is_fetched_again() {
    let mut script = Script::default();
    lease_of(&mut script, 5, SKY, 256, four_runs());
    script.damaged_first = 2;
    let fake = Fake::start(script).await;
    let working = fake.work(1);
    fake.until("four parts", |s| s.parts.len() == 4).await;
    working.stop().await.expect("worker");
    let script = fake.script.lock().expect("script");
    assert!(script.failures.is_empty());
}

#[tokio::test(flavor = "multi_thread")]
async fn an_asset_goes_on_where_the_line_broke() {
    let mut script = Script::default();
    lease_of(&mut script, 5, SKY, 256, four_runs());
    script.breaks = [40, 0, 60].into();
    let fake = Fake::start(script).await;
    let working = fake.work(1);
    fake.until("four parts", |s| s.parts.len() == 4).await;
    working.stop().await.expect("worker");
    let script = fake.script.lock().expect("script");
    assert_eq!(script.asked_from, [0, 40, 40, 100]);
    assert!(script.failures.is_empty());
}

#[tokio::test(flavor = "multi_thread")]
async fn the_next_lease_is_asked_for_before_the_present_one_ends() {
    const LEASE_MS: u64 = 200;
    const LEASES: i64 = 5;
    let mut script = Script {
        lease_ms: LEASE_MS,
        ..Script::default()
    };
    // A run takes long against the call that it must hide.
    let samples = 1 << 15;
    for lease in 0..LEASES {
        let block = lease as u32 * 2;
        let runs = vec![
            run(0, block),
            run(1, block),
            run(0, block + 1),
            run(1, block + 1),
        ];
        lease_of(&mut script, 5 + lease, SKY, samples, runs);
    }
    let fake = Fake::start(script).await;
    let working = fake.work(1);
    let parts = LEASES as usize * 4;
    fake.until("all parts", |s| s.parts.len() == parts).await;
    working.stop().await.expect("worker");
    let script = fake.script.lock().expect("script");
    let before = &script.parts_at_request[1..LEASES as usize];
    for (lease, &parts) in (1..).zip(before) {
        assert!(
            parts < lease * 4,
            "lease {lease} was asked for after {parts} parts"
        );
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_leaving_worker_delivers_what_it_began_and_releases_the_rest() {
    let mut script = Script::default();
    let runs = (0..64).map(|block| run(0, block)).collect();
    lease_of(&mut script, 5, SKY, 64 * 128, runs);
    let fake = Fake::start(script).await;
    let working = fake.work(1);
    fake.until("a part", |s| !s.parts.is_empty()).await;
    let summary = working.stop().await.expect("worker");
    let script = fake.script.lock().expect("script");
    assert_eq!(script.parts.len() as u64, summary.runs);
    assert!(summary.runs < 64, "stopped in the middle");
    assert_eq!(script.released, [5]);
    assert!(script.failures.is_empty());
}

#[tokio::test(flavor = "multi_thread")]
async fn speed_is_measured_and_told() {
    let mut script = Script::default();
    lease_of(&mut script, 5, SKY, 256, four_runs());
    let fake = Fake::start(script).await;
    let working = fake.work(1);
    fake.until("a request after the work", |s| {
        s.lease_requests
            .last()
            .is_some_and(|last| last.samples_per_s > 0.0)
    })
    .await;
    working.stop().await.expect("worker");
    let script = fake.script.lock().expect("script");
    assert_eq!(script.lease_requests[0].samples_per_s, 0.0);
}

async fn sums_with(threads: usize) -> BTreeMap<Run, TileSums> {
    let mut script = Script::default();
    let runs = (0..4).flat_map(|block| [run(0, block), run(1, block)]);
    lease_of(&mut script, 5, SKY, 512, runs.collect());
    let fake = Fake::start(script).await;
    let working = fake.work(threads);
    fake.until("eight parts", |s| s.parts.len() == 8).await;
    working.stop().await.expect("worker");
    let mut script = fake.script.lock().expect("script");
    script
        .parts
        .drain(..)
        .map(|part| (part.run, part.sums))
        .collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn threads_change_no_bit() {
    let one = sums_with(1).await;
    assert_eq!(one.len(), 8);
    assert!(one == sums_with(3).await);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_coordinator_that_comes_later_is_found() {
    // Bound and not listening: nobody else gets the port, nobody answers.
    let socket = tokio::net::TcpSocket::new_v4().expect("socket");
    socket
        .bind("127.0.0.1:0".parse().expect("address"))
        .expect("port");
    let url = format!("http://{}", socket.local_addr().expect("address"));
    let mut config = shearwater_worker::Config::new(url, "test");
    config.threads = 1;
    let working = Fake::work_with(config);
    tokio::time::sleep(Duration::from_millis(300)).await;
    let mut script = Script::default();
    lease_of(&mut script, 5, SKY, 256, four_runs());
    let fake = Fake::start_on(socket.listen(64).expect("listen"), script);
    fake.until("four parts", |s| s.parts.len() == 4).await;
    assert_eq!(working.stop().await.expect("worker").runs, 4);
}

#[tokio::test(flavor = "multi_thread")]
async fn an_asset_that_is_always_damaged_is_reported() {
    let mut script = Script::default();
    lease_of(&mut script, 5, SKY, 256, four_runs());
    script.damaged_first = u32::MAX;
    let fake = Fake::start(script).await;
    let working = fake.work(1);
    fake.until("a report", |s| !s.failures.is_empty()).await;
    working.stop().await.expect("worker");
    let script = fake.script.lock().expect("script");
    let report = &script.failures[0];
    assert_eq!(report.kind, FailureKind::Worker);
    assert!(report.reason.contains("damaged"), "{}", report.reason);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_result_that_is_refused_is_reported() {
    let mut script = Script::default();
    lease_of(&mut script, 5, SKY, 256, four_runs());
    script.result_errors = [422].into();
    let fake = Fake::start(script).await;
    let working = fake.work(1);
    fake.until("parts and a report", |s| {
        s.parts.len() == 3 && s.failures.len() == 1
    })
    .await;
    let summary = working.stop().await.expect("worker");
    assert_eq!((summary.runs, summary.refused, summary.failures), (3, 1, 1));
    let script = fake.script.lock().expect("script");
    let report = &script.failures[0];
    assert_eq!(report.kind, FailureKind::Worker);
    assert!(report.run.is_some_and(|run| four_runs().contains(&run)));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_result_damaged_on_the_way_is_sent_again() {
    let mut script = Script::default();
    lease_of(&mut script, 5, SKY, 256, four_runs());
    script.result_errors = [400, 400].into();
    let fake = Fake::start(script).await;
    let working = fake.work(1);
    fake.until("four parts", |s| s.parts.len() == 4).await;
    let summary = working.stop().await.expect("worker");
    assert_eq!((summary.runs, summary.refused, summary.failures), (4, 0, 0));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_worker_in_quarantine_waits_unless_it_is_the_only_one() {
    let quarantine = || Script {
        quarantine: u32::MAX,
        ..Script::default()
    };
    let fake = Fake::start(quarantine()).await;
    let working = fake.work(1);
    fake.until("a question", |s| !s.lease_requests.is_empty())
        .await;
    tokio::time::sleep(Duration::from_millis(300)).await;
    working.stop().await.expect("it waits, and can be stopped");

    let fake = Fake::start(quarantine()).await;
    let mut config = shearwater_worker::Config::new(fake.url(), "test");
    config.leave_when_quarantined = true;
    let error = Fake::work_with(config).end().await.expect_err("leaves");
    assert!(matches!(error, WorkerError::Refused { .. }), "{error}");
}

#[tokio::test]
async fn settings_out_of_range_are_named() {
    let never = std::future::pending::<()>;
    let mut config = shearwater_worker::Config::new("http://127.0.0.1:1", "test");
    config.threads = 0;
    let error = shearwater_worker::run(config, never()).await;
    assert!(error.expect_err("threads").to_string().contains("threads"));
    for url in ["", "farm:7788", "ftp://farm"] {
        let config = shearwater_worker::Config::new(url, "test");
        let error = shearwater_worker::run(config, never()).await;
        assert!(matches!(error, Err(WorkerError::Url { .. })), "{url}");
    }
}
