//! One promise after the other, on a store that may hold other jobs.

use shearwater_coordinator::farm::{Unit, cut_runs};
use shearwater_coordinator::store::{
    Claimed, CommitOutcome, ERROR_POINTS_MAX, ErrorRow, FoldTask, Folded, FrameEnd, FrameTile,
    JobFilter, NewJob, PartRecord, ReadyQuery, Store, Submitted,
};
use shearwater_shared::api::StopCause;
use shearwater_shared::film::{Brightness, ErrorDetail, ErrorEstimate, TileError};
use shearwater_shared::hash::ContentHash;
use shearwater_shared::job::{JobId, Manifest, RenderSettings};
use shearwater_shared::plan::{Plan, Run};

pub(crate) const SETTINGS: RenderSettings = RenderSettings {
    width: 96,
    height: 80,
    samples: 512,
    seed: 0,
    frames: 3,
    first_frame: 5,
    stop: shearwater_shared::stop::Stop::NONE,
};

pub(crate) async fn submit(store: &Store) -> JobId {
    submit_frames(store, SETTINGS.frames).await
}

pub(crate) async fn submit_frames(store: &Store, frames: u32) -> JobId {
    let new = NewJob {
        name: "job".into(),
        manifest: Manifest {
            scene: ContentHash::of(b"scene"),
            files: [].into(),
        },
        settings: RenderSettings { frames, ..SETTINGS },
        post: shearwater_shared::scene::Post::default(),
        fps: Some(24.0),
        animation_frames: Some(8),
        priority: 0,
        idempotency: None,
    };
    let scene = new.manifest.scene;
    assert!(store.add_asset(&scene, 5, 1).await.expect("asset"));
    match store.submit(&new, 1).await.expect("submit") {
        Submitted::New(id) => id,
        other => panic!("{other:?}"),
    }
}

pub(crate) async fn claim(
    store: &Store,
    job: JobId,
    units_max: usize,
    now_ms: i64,
    until_ms: i64,
) -> Option<Claimed> {
    let query = ReadyQuery {
        job,
        worker: "w".into(),
        units_max,
        present: 0,
        timed: None,
    };
    let cut = |ready: &[Unit]| cut_runs(ready, &Plan::new(&SETTINGS), 1);
    store
        .claim(&query, cut, now_ms, until_ms)
        .await
        .expect("claim")
}

pub(crate) fn part(job: JobId, run: Run, lease: i64, nonce: u64) -> PartRecord {
    PartRecord {
        job,
        run,
        lease,
        worker: "w".into(),
        build: "b".into(),
        sums_hash: ContentHash::of(format!("{run:?}").as_bytes()),
        object: format!("part/{job}/{run:?}/{nonce}"),
        samples: Plan::new(&SETTINGS).run_samples(&run),
        core_us: 1,
        bad_samples: 0,
        depth_cap_hits: 0,
    }
}

pub(crate) async fn run(store: &Store) {
    frames_are_made_when_they_are_needed(store).await;
    ten_thousand_frames_are_submitted_at_once(store).await;
    the_worst_frame_is_known(store).await;
    errors_are_noted_when_they_have_changed(store).await;
    racing_overlapping_commits_never_tear(store).await;
    racing_folds_take_every_part_once(store).await;
    what_ended_stays_ended(store).await;
    expiry_frees_and_late_results_count(store).await;
    a_clock_set_back_ends_leases_in_time(store).await;
    a_lease_ends_with_its_last_run(store).await;
    everything_of_a_deleted_job_goes(store).await;
}

async fn frames_are_made_when_they_are_needed(store: &Store) {
    let job = submit(store).await;
    let states = async |frame| {
        let states = store.tile_states(job, frame, 0, 99).await;
        states.expect("tiles").len()
    };
    assert_eq!(states(0).await, 0, "nothing before the first claim");
    let first = claim(store, job, 10, 1, 100).await.expect("frame 0");
    assert_eq!((states(0).await, states(1).await), (4, 0));
    assert!(first.runs.iter().all(|run| run.frame == 0));
    // 6 units are left of frame 0: the claim reaches into frame 1.
    let second = claim(store, job, 10, 1, 100).await.expect("frames 0 and 1");
    let frames: Vec<u32> = second.runs.iter().map(|run| run.frame).collect();
    assert!(frames.contains(&0) && frames.contains(&1), "{frames:?}");
    let mut units = 20;
    while let Some(more) = claim(store, job, 10, 1, 100).await {
        units += more
            .runs
            .iter()
            .map(|run| run.block1 - run.block0)
            .sum::<u32>();
    }
    assert_eq!(units, 3 * 16, "every unit of every frame, once");
    let row = store.job(job).await.expect("read").expect("job");
    assert_eq!((row.units_leased, row.units_due), (48, 48));
}

async fn ten_thousand_frames_are_submitted_at_once(store: &Store) {
    const FRAMES: u32 = 10_000;
    let started = std::time::Instant::now();
    let job = submit_frames(store, FRAMES).await;
    let submitted = started.elapsed();
    let rows = async || store.frames(job, 0, FRAMES).await.expect("frames").len();
    assert_eq!(rows().await, 0, "no row before the first claim");
    let started = std::time::Instant::now();
    let first = claim(store, job, 16, 1, 100).await.expect("frame 0");
    let claimed = started.elapsed();
    assert_eq!((first.runs.len(), rows().await), (4, 1));
    // A small claim of a large worker: some frames at once, never all.
    claim(store, job, 8192, 1, 100).await.expect("more frames");
    assert!((2..=16).contains(&rows().await), "{}", rows().await);
    let row = store.job(job).await.expect("read").expect("job");
    assert_eq!(row.units_due, 160_000);
    eprintln!("{FRAMES} frames: submitted in {submitted:?}, first claim {claimed:?}");
    // One row and one frame's rows; ten thousand frames' would take a minute.
    assert!(submitted.as_secs() < 2 && claimed.as_secs() < 2);
    assert!(store.cancel(job, 2).await.expect("cancel"));
}

async fn the_worst_frame_is_known(store: &Store) {
    let job = submit_frames(store, 4).await;
    while claim(store, job, 64, 1, 100).await.is_some() {}
    assert_eq!(store.worst_frame(job).await.expect("read"), None);

    for (frame, nmse, worst) in [(2, 1e-3, 2), (0, 0.0, 2), (3, 2e-3, 3), (1, 2e-3, 1)] {
        let (hash, last) = (ContentHash::of(b"film"), error_row(frame, 7, nmse));
        let error = last.error;
        let end = FrameEnd {
            film_hash: hash,
            cause: StopCause::Samples,
            samples: (512, 512),
            extended: 0,
        };
        let finish = async || {
            let done = store.finish_frame(job, frame, &end, Some(&last), 5).await;
            done.expect("finish")
        };
        assert!(finish().await);
        assert!(!finish().await, "once");
        let row = store.worst_frame(job).await.expect("read").expect("frame");
        assert_eq!(row.frame, worst, "the earliest of the worst");
        let row = store.frame(job, frame).await.expect("read").expect("frame");
        assert_eq!((row.film_hash, row.error), (Some(hash), Some(error)));
        let rows = store.errors(job, frame, 0, 9).await.expect("read");
        assert_eq!(rows, [last], "the final film is a point too");
    }
    let row = store.job(job).await.expect("read").expect("job");
    assert_eq!((row.frames_done, row.finished_ms), (4, Some(5)));
}

fn error_row(frame: u32, samples: u64, nmse: f64) -> ErrorRow {
    ErrorRow {
        frame,
        samples,
        at_ms: samples as i64,
        core_us: 3 * samples,
        error: ErrorEstimate {
            nmse,
            detail: Some(ErrorDetail::default()),
            ..ErrorEstimate::default()
        },
    }
}

fn brightness(light: i64) -> Brightness {
    let mut brightness = Brightness::zero();
    (0..100).for_each(|_| brightness.record(light));
    brightness
}

async fn errors_are_noted_when_they_have_changed(store: &Store) {
    let job = submit(store).await;
    while claim(store, job, 64, 1, 100).await.is_some() {}
    let fold = async |block: u32, core_us: u64| {
        let run = Run {
            frame: 1,
            tile: 0,
            block0: block,
            block1: block + 1,
        };
        let mut record = part(job, run, 0, 0);
        record.core_us = core_us;
        store.commit(&record, 2).await.expect("commit");
        let at = FrameTile {
            job,
            frame: 1,
            tile: 0,
        };
        let old = store.tile_state(&at).await.expect("read").expect("tile");
        let fold = FoldTask {
            at,
            old,
            film: format!("film/{job}/{block}"),
            error: TileError::default(),
            brightness: brightness(1 << block),
            samples: 100,
        };
        assert!(store.swap_film(&fold).await.expect("swap"));
    };
    let due = async || store.error_due(job, 1).await.expect("read");
    assert_eq!(due().await, None, "nothing is folded");
    fold(0, 5).await;
    let folded = |samples, core_us| Some(Folded { samples, core_us });
    assert_eq!(due().await, folded(100, 5));
    let rev = async || store.job_rev(job).await.expect("read");
    let before = rev().await;
    let first = error_row(1, 100, 0.5);
    store.add_error(job, &first).await.expect("add");
    assert!(rev().await > before, "watchers see it");
    assert_eq!(due().await, None, "nothing is new");
    fold(1, 7).await;
    assert_eq!(due().await, folded(200, 12));
    let text = store.brightness(job, 1).await.expect("read");
    assert_eq!(text, brightness(2), "the film's, not the sum of all films");
    // As many samples again, from another coordinator: the first stays.
    store
        .add_error(job, &error_row(1, 100, 0.4))
        .await
        .expect("add");
    store
        .add_error(job, &error_row(1, 180, 0.3))
        .await
        .expect("add");
    assert_eq!(due().await, None, "200 are less than 1.2 times 180");
    let page = async |after, limit| {
        let rows = store.errors(job, 1, after, limit).await.expect("read");
        rows.iter().map(|row| row.samples).collect::<Vec<_>>()
    };
    assert_eq!(
        (page(0, 9).await, page(100, 9).await),
        (vec![100, 180], vec![180])
    );
    assert_eq!(page(0, 1).await, [100]);
    let last = store.last_error(job, 1).await.expect("read");
    assert_eq!(last, Some(error_row(1, 180, 0.3)));
    store
        .add_error(job, &error_row(2, 170, 0.9))
        .await
        .expect("add");
    let newest = store.newest_error(job).await.expect("read");
    assert_eq!(newest.map(|row| (row.frame, row.samples)), Some((1, 180)));
    assert_eq!(page(0, 1).await.len(), 1);
    // A bound, whatever happens.
    for samples in 1..=u64::from(ERROR_POINTS_MAX) {
        store
            .add_error(job, &error_row(1, samples, 0.1))
            .await
            .expect("add");
    }
    fold(2, 1).await;
    assert_eq!(due().await, None);
    store.delete_job(job).await.expect("delete");
    gone(store, job).await;
    assert_eq!(page(0, 9).await, [0; 0], "gone with its job");
    store.add_error(job, &first).await.expect("no job, no row");
    assert_eq!(page(0, 9).await, [0; 0]);
}

async fn racing_overlapping_commits_never_tear(store: &Store) {
    let job = submit(store).await;
    let claimed = claim(store, job, 16, 1, 1000).await.expect("frame 0");
    for tile in 0..4 {
        let mut racers = tokio::task::JoinSet::new();
        for racer in 0..12u32 {
            let store = store.clone();
            let block0 = racer % 4;
            let block1 = (block0 + 1 + racer / 4).min(4);
            let run = Run {
                frame: 0,
                tile,
                block0,
                block1,
            };
            racers.spawn(async move {
                let record = part(job, run, claimed.id, racer.into());
                (run, store.commit(&record, 2).await.expect("commit"))
            });
        }
        let mut counted = Vec::new();
        while let Some(race) = racers.join_next().await {
            let (run, outcome) = race.expect("task");
            if outcome == CommitOutcome::Counted {
                counted.extend(run.block0..run.block1);
            }
        }
        counted.sort_unstable();
        let mut once = counted.clone();
        once.dedup();
        assert_eq!(once, counted, "no block twice");
        assert!(!counted.is_empty(), "whoever comes first is counted");
        let state = store
            .tile_states(job, 0, tile, tile + 1)
            .await
            .expect("tile");
        let parts: Vec<u32> = state[0]
            .parts
            .iter()
            .flat_map(|p| p.block0..p.block1)
            .collect();
        assert_eq!(parts, counted, "the rows are what was acknowledged");
    }
    let row = store.job(job).await.expect("read").expect("job");
    let parts = store.tile_states(job, 0, 0, 4).await.expect("tiles");
    let blocks: u32 = parts
        .iter()
        .flat_map(|t| &t.parts)
        .map(|p| p.block1 - p.block0)
        .sum();
    assert_eq!(row.units_done, u64::from(blocks));
}

async fn racing_folds_take_every_part_once(store: &Store) {
    let job = submit(store).await;
    let claimed = claim(store, job, 16, 1, 1000).await.expect("frame 0");
    let at = FrameTile {
        job,
        frame: 0,
        tile: 2,
    };
    for block in 0..4 {
        let run = Run {
            frame: 0,
            tile: 2,
            block0: block,
            block1: block + 1,
        };
        let record = part(job, run, claimed.id, 0);
        assert_eq!(
            store.commit(&record, 2).await.expect("commit"),
            CommitOutcome::Counted
        );
        let old = store.tile_state(&at).await.expect("read").expect("tile");
        let mut racers = tokio::task::JoinSet::new();
        for racer in 0..6 {
            let (store, old) = (store.clone(), old.clone());
            racers.spawn(async move {
                let fold = FoldTask {
                    at,
                    old,
                    film: format!("film/{job}/{block}-{racer}"),
                    error: TileError::default(),
                    brightness: brightness(1 << block),
                    samples: Plan::new(&SETTINGS).run_samples(&run),
                };
                store.swap_film(&fold).await.expect("swap")
            });
        }
        let won = racers
            .join_all()
            .await
            .into_iter()
            .filter(|&won| won)
            .count();
        assert_eq!(won, 1, "one fold wins");
        let state = store.tile_state(&at).await.expect("read").expect("tile");
        assert_eq!((state.blocks, state.parts.len()), (block + 1, 0));
        let film = state.film.expect("film");
        assert!(store.names_object(&film).await.expect("look"));
    }
}

async fn what_ended_stays_ended(store: &Store) {
    let job = submit(store).await;
    let claimed = claim(store, job, 16, 1, 1000).await.expect("work");
    assert!(store.fail_job(job, None, "why", 5).await.expect("fail"));
    assert!(!store.cancel(job, 6).await.expect("cancel"));
    assert!(!store.fail_job(job, None, "other", 7).await.expect("fail"));
    let row = store.job(job).await.expect("read").expect("job");
    assert_eq!(row.finished_ms, Some(5));
    assert!(claim(store, job, 16, 1, 1000).await.is_none());
    let late = part(job, claimed.runs[0], claimed.id, 0);
    let outcome = store.commit(&late, 9).await.expect("commit");
    assert_eq!(outcome, CommitOutcome::Ended);
    assert!(!store.names_object(&late.object).await.expect("look"));
}

async fn expiry_frees_and_late_results_count(store: &Store) {
    let job = submit(store).await;
    let first = claim(store, job, 4, 1_000_000, 1_000_100)
        .await
        .expect("work");
    store
        .prolong("w", &[first.id], 1_000_200)
        .await
        .expect("prolong");
    store
        .prolong("thief", &[first.id], 9_000_000)
        .await
        .expect("prolong");
    let leased = async || {
        let units = store.leased_units(job, 99).await.expect("units");
        units.len()
    };
    store.expire(1_000_150).await.expect("expire");
    assert_eq!(leased().await, 4, "prolonged");
    store.expire(1_000_201).await.expect("expire");
    assert_eq!(leased().await, 0);
    let second = claim(store, job, 4, 1_000_300, 2_000_000)
        .await
        .expect("work");
    assert_eq!(second.runs, first.runs, "holes are filled first");
    let late = part(job, first.runs[0], first.id, 0);
    let outcome = store.commit(&late, 1_000_400).await.expect("commit");
    assert_eq!(outcome, CommitOutcome::Counted);
    let counted = [first.runs[0]];
    let reissue = store.reissue(job, &counted, "v", 1_000_400, 2_000_000);
    assert_eq!(reissue.await.expect("reissue"), None, "nobody waits for it");
    let again = part(job, second.runs[0], second.id, 1);
    let outcome = store.commit(&again, 1_000_400).await.expect("commit");
    assert_eq!(outcome, CommitOutcome::Duplicate);
}

async fn a_clock_set_back_ends_leases_in_time(store: &Store) {
    let job = submit(store).await;
    let day = 86_400_000;
    let before = claim(store, job, 4, day, day + 100).await.expect("work");
    // A day earlier by the clock.
    store
        .cut_future_times(50, 150, 1000)
        .await
        .expect("cut times");
    let lease = store.lease(before.id).await.expect("read").expect("lease");
    assert_eq!(lease.until_ms, 150);
    store.expire(151).await.expect("expire");
    let after = claim(store, job, 4, 152, 1000).await.expect("work");
    assert_eq!(after.runs, before.runs, "ready again");
}

async fn a_lease_ends_with_its_last_run(store: &Store) {
    let job = submit(store).await;
    let first = claim(store, job, 4, 1, 1000).await.expect("work");
    let second = claim(store, job, 4, 1, 1000).await.expect("work");
    let again = store
        .reissue(job, &second.runs, "v", 2, 1000)
        .await
        .expect("reissue")
        .expect("work");
    let closed = async |id| {
        let lease = store.lease(id).await.expect("read");
        lease.expect("lease").closed
    };
    let last = first.runs.len() - 1;
    for (i, run) in first.runs.iter().enumerate() {
        assert!(!closed(first.id).await, "before run {i} of {last}");
        let outcome = store.commit(&part(job, *run, first.id, 0), 3).await;
        assert_eq!(outcome.expect("commit"), CommitOutcome::Counted);
    }
    assert!(closed(first.id).await);
    assert!(!closed(second.id).await && !closed(again.id).await);
    for run in &second.runs {
        // The first holder still renders what was handed out once more.
        assert!(!closed(second.id).await);
        let outcome = store.commit(&part(job, *run, second.id, 0), 3).await;
        assert_eq!(outcome.expect("commit"), CommitOutcome::Counted);
    }
    assert!(closed(second.id).await);
}

/// Remove a deleted job's rows, as the background does.
async fn gone(store: &Store, job: JobId) {
    assert!(store.deletions().await.expect("read").contains(&job));
    while store.delete_some(job).await.expect("step") > 0 {}
    store.deletion_done(job).await.expect("end");
    assert!(!store.deletions().await.expect("read").contains(&job));
}

async fn everything_of_a_deleted_job_goes(store: &Store) {
    let job = submit(store).await;
    let claimed = claim(store, job, 16, 1, 1000).await.expect("work");
    let record = part(job, claimed.runs[0], claimed.id, 0);
    store.commit(&record, 2).await.expect("commit");
    assert!(store.delete_job(job).await.expect("delete"));
    assert!(!store.delete_job(job).await.expect("delete"));
    gone(store, job).await;
    assert_eq!(store.job(job).await.expect("read"), None);
    assert_eq!(store.lease(claimed.id).await.expect("read"), None);
    assert!(!store.names_object(&record.object).await.expect("look"));
    let late = part(job, claimed.runs[1], claimed.id, 1);
    let outcome = store.commit(&late, 9).await.expect("commit");
    assert_eq!(outcome, CommitOutcome::Unknown);
    assert_ne!(submit(store).await, job, "numbers are never used again");
    let listing = JobFilter {
        below: i64::MAX,
        state: None,
        limit: 100,
    };
    let jobs = store.jobs(&listing).await.expect("list");
    assert!(jobs.iter().all(|row| row.id != job));
}
