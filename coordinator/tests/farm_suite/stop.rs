//! Stop rules, and samples added to a job.

use crate::farm::{Farm, SCENE, config, expected_hash, json, part, problem, start, start_with};
use reqwest::StatusCode;
use shearwater_coordinator::Coordinator;
use shearwater_coordinator::farm::{TileAtLevel, Verdict, verdict};
use shearwater_shared::api::{AddSamples, JobView, Lease, SettingsOverride, StopCause};
use shearwater_shared::film::{FIXED_ONE, TileFilm, TileSums, film_hash, tile_error};
use shearwater_shared::hash::ContentHash;
use shearwater_shared::job::RenderSettings;
use shearwater_shared::plan::{Plan, Run};
use shearwater_shared::routes;
use shearwater_shared::stop::ErrorTarget;
use std::time::Duration;

async fn submit(farm: &Farm, scene: &str, settings: SettingsOverride) -> JobView {
    let mut request = farm.scene_request().await;
    request.manifest.scene = farm.put_asset(scene.as_bytes()).await;
    request.settings = settings;
    let answer = farm.post(routes::JOBS, &request).await;
    assert_eq!(answer.status(), StatusCode::CREATED);
    json(answer).await
}

fn samples(samples: u32) -> SettingsOverride {
    SettingsOverride {
        samples: Some(samples),
        ..SettingsOverride::default()
    }
}

fn target(error: f64) -> Option<ErrorTarget> {
    ErrorTarget::new(error).ok()
}

async fn try_add(farm: &Farm, job: &JobView, asked: &AddSamples) -> reqwest::Response {
    let path = routes::fill(routes::JOB_SAMPLES, &job.id.to_string());
    farm.post(&path, asked).await
}

async fn add(farm: &Farm, job: &JobView, asked: &AddSamples) -> JobView {
    let answer = try_add(farm, job, asked).await;
    assert_eq!(answer.status(), StatusCode::OK);
    json(answer).await
}

fn to(samples: u32) -> AddSamples {
    AddSamples {
        samples: Some(samples),
        ..AddSamples::default()
    }
}

/// Work until the job is done; how many units were delivered.
async fn work(farm: &Farm, job: &JobView) -> u32 {
    let mut units = 0;
    loop {
        let now = farm.job(job.id).await;
        if now.done {
            return units;
        }
        let Some(lease) = farm.lease("w", 1e6).await else {
            tokio::time::sleep(Duration::from_millis(10)).await;
            continue;
        };
        for run in &lease.runs {
            units += run.block1 - run.block0;
            farm.deliver_run(&now, lease.id, run, "w").await;
        }
    }
}

#[tokio::test]
async fn added_samples_give_the_film_of_all_of_them() {
    let farm = start().await;
    for (first, then) in [(128, 256), (100, 256), (6, 130)] {
        let moving = SCENE.replace(
            "\"job\"",
            r#""animation": { "fps": 25, "frames": 2 }, "job""#,
        );
        let job = submit(&farm, &moving, samples(first)).await;
        let units = work(&farm, &job).await;
        let done = farm.job(job.id).await;
        assert_eq!(done.film_hashes[1], expected_hash(&done.settings, 1));
        assert_eq!(done.stopped_by, Some(StopCause::Samples));
        let more = add(&farm, &job, &to(then)).await;
        assert!(!more.done && more.finished_ms.is_none(), "{more:?}");
        assert_eq!(more.units_done, u64::from(units), "what is done stays");
        let new_units = work(&farm, &job).await;
        let done = farm.job(job.id).await;
        assert_eq!(u64::from(units + new_units), done.units_total);
        let whole = RenderSettings {
            stop: shearwater_shared::stop::Stop::NONE,
            ..done.settings
        };
        for frame in 0..2 {
            let expected = expected_hash(&whole, frame);
            assert_eq!(
                done.film_hashes[frame as usize], expected,
                "{first} to {then}"
            );
        }
        assert_eq!(
            (done.samples_min, done.samples_max),
            (Some(then), Some(then))
        );
    }
}

#[tokio::test]
async fn a_running_job_can_be_added_to() {
    let farm = start().await;
    let job = submit(&farm, SCENE, samples(100)).await;
    let lease = farm.lease("w", 1e3).await.expect("work");
    let more = add(
        &farm,
        &job,
        &AddSamples {
            add: Some(100),
            ..AddSamples::default()
        },
    )
    .await;
    assert_eq!((more.settings.samples, more.units_done), (200, 0));
    // A lease of before is as good as one of after.
    for run in &lease.runs {
        assert!(!farm.deliver_run(&job, lease.id, run, "w").await);
    }
    work(&farm, &job).await;
    let done = farm.job(job.id).await;
    assert_eq!(done.film_hashes, [expected_hash(&done.settings, 0)]);
}

#[tokio::test]
async fn what_cannot_be_added_is_refused_with_a_reason() {
    let farm = start().await;
    let job = submit(&farm, SCENE, samples(128)).await;
    for (asked, why) in [
        (to(64), "has 128 per pixel already"),
        (to(128), "nothing to add"),
        (to(129), "settings.samples is 129"),
        (
            AddSamples {
                error: target(0.1),
                ..to(256)
            },
            "no error target",
        ),
        (
            AddSamples {
                add: Some(2),
                ..to(256)
            },
            "not both",
        ),
    ] {
        let refused = problem(try_add(&farm, &job, &asked).await, 422, "invalid").await;
        assert!(refused.detail.contains(why), "{refused:?}");
    }
    let path = routes::fill(routes::JOB_CANCEL, &job.id.to_string());
    farm.post(&path, &()).await;
    problem(try_add(&farm, &job, &to(256)).await, 409, "job-ended-early").await;
    let path = routes::fill(routes::JOB_SAMPLES, "999");
    problem(farm.post(&path, &to(256)).await, 404, "not-found").await;
}

/// Sums with noise: tile 2 has the most, tile 0 hardly any. Each sample is a function
/// of its numbers.
fn noisy(plan: &Plan, run: &Run) -> TileSums {
    let range = plan.sample_range(run).expect("run of the plan");
    let pixels = plan.tile_rect(run.tile).expect("tile").pixels();
    let mut sums = TileSums::zero(pixels, &range);
    let noise = [0.01, 0.3, 0.9, 0.1][run.tile as usize] * FIXED_ONE;
    for (half, values) in sums.radiance.iter_mut().enumerate() {
        for (pixel, rgb) in values.chunks_exact_mut(3).enumerate() {
            for sample in range.clone() {
                let place = (pixel as u64) << 32 | u64::from(run.tile) << 28 | u64::from(sample);
                let mut key = (place << 1 | half as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
                key = (key ^ key >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9);
                let unit = ((key >> 40) as f64) / f64::from(1 << 23) - 1.0;
                let light = (FIXED_ONE + noise * unit) as i64;
                sums.brightness.record(3 * light);
                rgb.iter_mut().for_each(|sum| *sum += light);
            }
        }
    }
    sums
}

/// What an error stop must come to, without any farm: film hash and samples of each
/// tile.
fn expected_adaptive(settings: &RenderSettings) -> (ContentHash, Vec<u32>) {
    let plan = Plan::new(settings);
    let target = settings.stop.error.expect("target");
    let rect = |tile| plan.tile_rect(tile).expect("tile");
    let mut films: Vec<TileFilm> = (0..4).map(|t| TileFilm::zero(rect(t).pixels())).collect();
    let mut blocks = [0u32; 4];
    let mut go_on: Vec<u32> = (0..4).collect();
    loop {
        for &tile in &go_on {
            let (from, film) = (blocks[tile as usize], &mut films[tile as usize]);
            let block1 = plan.next_level(from).expect("level");
            let run = Run {
                frame: 0,
                tile,
                block0: from,
                block1,
            };
            film.add(&noisy(&plan, &run)).expect("fits");
            blocks[tile as usize] = block1;
        }
        let tiles: Vec<TileAtLevel> = (0u32..4)
            .map(|tile| TileAtLevel {
                samples: 2 * films[tile as usize].samples_per_half as u32,
                can_go_on: plan.next_level(blocks[tile as usize]).is_some(),
                pixels: rect(tile).pixels() as u32,
                relmse: tile_error(&films[tile as usize], rect(tile).width as usize).relmse(),
            })
            .collect();
        match verdict(&tiles, 2, target) {
            Verdict::GoOn(tiles) => go_on = tiles,
            _ => break,
        }
    }
    let samples = films.iter().map(|film| 2 * film.samples_per_half as u32);
    let hash = film_hash(&plan, |tile| &films[tile as usize]).expect("hash");
    (hash, samples.collect())
}

async fn deliver_noisy(farm: &Farm, job: &JobView, lease: &Lease, run: &Run, name: &str) {
    let mut delivery = part(job, lease.id, run, name);
    delivery.sums = noisy(&Plan::new(&job.settings), run);
    let answer = farm.deliver(&delivery).await;
    assert_eq!(answer.status(), StatusCode::OK, "{answer:?}");
}

/// Work with `workers` in turns, the last run first; every fifth lease is lost.
async fn work_noisy(farm: &Farm, job: &JobView, workers: usize, lose: bool) -> JobView {
    for turn in 0usize.. {
        let now = farm.job(job.id).await;
        if now.done {
            return now;
        }
        let name = ["a", "b", "c"][turn % workers];
        let Some(lease) = farm.lease(name, 2e5).await else {
            tokio::time::sleep(Duration::from_millis(10)).await;
            continue;
        };
        if lose && turn % 5 == 1 {
            continue;
        }
        for run in lease.runs.iter().rev() {
            deliver_noisy(farm, &now, &lease, run, name).await;
        }
    }
    unreachable!("the job ends")
}

fn adaptive(error: f64, most: u32) -> SettingsOverride {
    SettingsOverride {
        error: target(error),
        ..samples(most)
    }
}

#[tokio::test]
async fn an_error_stop_is_one_picture_whoever_works_and_whatever_is_lost() {
    let farm = start_with(|config| {
        config.heartbeat_ms = 50;
        config.lease_ttl_ms = 300;
    })
    .await;
    let mut ends = Vec::new();
    for (workers, lose) in [(1, false), (3, true)] {
        let job = submit(&farm, SCENE, adaptive(1e-4, 4096)).await;
        assert_eq!(job.settings.stop.cuts.ends(), [32]);
        assert_eq!(job.units_total, 4, "the first pass has 64 samples");
        ends.push(work_noisy(&farm, &job, workers, lose).await);
    }
    let (hash, samples) = expected_adaptive(&ends[0].settings);
    assert_eq!(ends[0].film_hashes, [hash]);
    assert_eq!(ends[1].film_hashes, [hash]);
    let (least, most) = (samples.iter().min().copied(), samples.iter().max().copied());
    assert!(least < most, "{samples:?}");
    let end = &ends[1];
    assert_eq!((end.samples_min, end.samples_max), (least, most));
    assert_eq!(end.stopped_by, Some(StopCause::Error));
    assert_eq!(end.progress, 1.0);
}

#[tokio::test]
async fn an_error_stop_goes_on_to_a_smaller_error_or_more_samples() {
    let farm = start().await;
    let job = submit(&farm, SCENE, adaptive(1e-9, 128)).await;
    let most = work_noisy(&farm, &job, 1, false).await;
    assert_eq!(most.stopped_by, Some(StopCause::Samples), "not reached");
    // A power of two as the most: as if it had been more from the start.
    let more = add(&farm, &job, &to(512)).await;
    assert!(!more.done);
    let more = work_noisy(&farm, &job, 1, false).await;
    assert_eq!(more.film_hashes, [expected_adaptive(&more.settings).0]);
    assert_eq!(more.samples_max, Some(512));

    let job = submit(&farm, SCENE, adaptive(1e-3, 4096)).await;
    let first = work_noisy(&farm, &job, 1, false).await;
    let smaller = AddSamples {
        error: target(1e-4),
        ..AddSamples::default()
    };
    assert!(!add(&farm, &job, &smaller).await.done);
    let second = work_noisy(&farm, &job, 1, false).await;
    assert_eq!(second.stopped_by, Some(StopCause::Error));
    assert!(second.samples_done > first.samples_done);
    assert_ne!(second.film_hashes, first.film_hashes);
    let larger = AddSamples {
        error: target(1e-2),
        ..AddSamples::default()
    };
    problem(try_add(&farm, &job, &larger).await, 422, "invalid").await;
}

#[tokio::test]
async fn a_time_stop_ends_with_what_is_there_and_can_be_continued() {
    let farm = start().await;
    let timed = SettingsOverride {
        seconds: Some(1),
        ..samples(512)
    };
    let job = submit(&farm, SCENE, timed).await;
    assert_eq!(job.settings.stop.cuts.ends(), [8, 16, 32]);
    assert_eq!(job.units_total, 28);
    // Tiles grow together: three first blocks before any second one.
    let lease = farm.lease("w", 3e6).await.expect("work");
    assert!(lease.runs.len() >= 3, "{lease:?}");
    assert!(
        lease.runs[..3]
            .iter()
            .all(|run| (run.block0, run.block1) == (0, 1))
    );
    for run in &lease.runs[..3] {
        farm.deliver_run(&job, lease.id, run, "w").await;
    }
    let release = shearwater_shared::api::ReleaseRequest {
        worker: crate::farm::worker("w"),
        leases: vec![lease.id],
    };
    farm.post(routes::WORKER_RELEASE, &release).await;
    tokio::time::sleep(Duration::from_millis(1100)).await;
    // The first block of the fourth tile is still handed out, and nothing else.
    let last = farm.lease("w", 1e9).await.expect("a tile has no samples");
    assert_eq!(
        last.runs,
        [Run {
            frame: 0,
            tile: 3,
            block0: 0,
            block1: 1
        }]
    );
    assert!(farm.lease("v", 1e9).await.is_none());
    assert!(!farm.job(job.id).await.done);
    farm.deliver_run(&job, last.id, &last.runs[0], "w").await;
    let done = farm.wait(job.id, |job| job.done).await;
    assert_eq!(done.stopped_by, Some(StopCause::Seconds));
    assert_eq!((done.samples_min, done.samples_max), (Some(16), Some(16)));
    assert_eq!((done.units_total, done.units_done), (4, 4));

    assert!(!add(&farm, &job, &to(512)).await.done);
    work(&farm, &job).await;
    let done = farm.job(job.id).await;
    assert_eq!(
        (done.units_total, done.stopped_by),
        (28, Some(StopCause::Samples))
    );
    let whole = RenderSettings {
        stop: shearwater_shared::stop::Stop::NONE,
        ..done.settings
    };
    assert_eq!(done.film_hashes, [expected_hash(&whole, 0)]);
}

#[tokio::test]
async fn the_first_result_fixes_the_numeric_build_of_a_job() {
    let farm = start().await;
    let (begun, fresh) = (
        submit(&farm, SCENE, samples(512)).await,
        farm.submit().await,
    );
    let lease = farm.lease("w", 3e6).await.expect("work");
    assert_eq!(lease.job, begun.id);
    farm.deliver_run(&begun, lease.id, &lease.runs[0], "w")
        .await;
    let Farm {
        coordinator,
        http,
        dir,
    } = farm;
    coordinator.shutdown().await;
    let mut config = config(dir.path());
    config.build = "another-build".to_owned();
    let coordinator = Coordinator::start(config).await.expect("start");
    let farm = Farm {
        coordinator,
        http,
        dir,
    };
    let mut late = part(&begun, lease.id, &lease.runs[1], "w");
    late.build = "another-build".to_owned();
    let refused = problem(farm.deliver(&late).await, 409, "job-build").await;
    assert!(refused.detail.contains("test-build"), "{refused:?}");
    problem(try_add(&farm, &begun, &to(1024)).await, 409, "job-build").await;
    let note = farm.job(begun.id).await.note.expect("a reason");
    assert!(
        note.contains("test-build") && note.contains("another-build"),
        "{note}"
    );
    // The other job has no result yet: it is taken up.
    let mut request = crate::farm::lease_request("w", 1e9, 0);
    request.build = "another-build".to_owned();
    let answer = farm.post(routes::WORKER_LEASES, &request).await;
    assert_eq!(json::<Lease>(answer).await.job, fresh.id);
    assert_eq!(farm.job(fresh.id).await.note, None);
}
