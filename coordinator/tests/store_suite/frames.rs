//! Frames: made when they are needed, counted, the worst of them known.

use crate::errors::error_row;
use crate::suite::{claim, submit, submit_frames};
use shearwater_coordinator::store::{FrameEnd, Store};
use shearwater_shared::api::StopCause;
use shearwater_shared::hash::ContentHash;

pub(crate) async fn frames_are_made_when_they_are_needed(store: &Store) {
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

pub(crate) async fn ten_thousand_frames_are_submitted_at_once(store: &Store) {
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

pub(crate) async fn the_worst_frame_is_known(store: &Store) {
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
