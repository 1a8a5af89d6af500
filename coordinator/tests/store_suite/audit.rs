//! Pauses, retries, the log, the audit and what it takes back, on any engine.

use crate::suite::{SETTINGS, beat, claim, part, submit, submit_with};
use shearwater_coordinator::store::{
    Claimed, CommitOutcome, FoldTask, FrameEnd, FrameTile, PartRecord, Store,
};
use shearwater_shared::api::{LogKind, StopCause};
use shearwater_shared::film::{Brightness, TileError};
use shearwater_shared::hash::ContentHash;
use shearwater_shared::job::{JobId, RenderSettings};
use shearwater_shared::plan::Run;
use shearwater_shared::stop::{ErrorTarget, Stop};

pub(crate) async fn run(store: &Store) {
    a_paused_job_gives_no_lease_and_its_time_stands(store).await;
    a_failed_job_goes_on(store).await;
    the_log_is_a_ring(store).await;
    claims_decide(store).await;
    an_audit_holds_its_frame_and_can_be_given_up(store).await;
    a_film_with_wrong_sums_is_begun_again(store).await;
    only_the_wrong_parts_of_an_open_tile_go(store).await;
    a_frame_of_an_error_stop_is_made_again(store).await;
}

async fn row(store: &Store, job: JobId) -> shearwater_coordinator::store::JobRow {
    store.job(job).await.expect("read").expect("job")
}

async fn a_paused_job_gives_no_lease_and_its_time_stands(store: &Store) {
    let job = submit(store).await;
    let first = claim(store, job, 2, 1000, 9000).await.expect("work");
    assert!(store.pause(job, 2000).await.expect("pause"));
    assert!(!store.pause(job, 2500).await.expect("pause"), "once");
    assert!(claim(store, job, 2, 3000, 9000).await.is_none());
    let live = store.live_jobs("b").await.expect("read");
    assert!(live.iter().all(|live| live.id != job));
    let late = part(job, first.runs[0], first.id, 0);
    let outcome = store.commit(&late, 3000).await.expect("commit");
    assert_eq!(outcome, CommitOutcome::Counted);
    assert!(store.resume(job, 5000).await.expect("resume"));
    assert!(!store.resume(job, 5000).await.expect("resume"), "once");
    let after = row(store, job).await;
    assert_eq!((after.paused_ms, after.first_lease_ms), (None, Some(4000)));
    assert_eq!(after.timed_from_ms, Some(4000));
    assert!(claim(store, job, 2, 6000, 9000).await.is_some());
    assert!(store.cancel(job, 6000).await.expect("cancel"));
    assert!(
        !store.pause(job, 6000).await.expect("pause"),
        "it has ended"
    );
    assert!(!store.retry(job, 6000).await.expect("retry"), "not failed");
}

async fn a_failed_job_goes_on(store: &Store) {
    let job = submit(store).await;
    let held = claim(store, job, 4, 1000, 9000).await.expect("work");
    let failure = store.record_failure(job, held.id, &held.runs[..1], "w", "ill", 1000);
    failure.await.expect("record");
    assert!(store.fail_job(job, None, "why", 2000).await.expect("fail"));
    assert!(claim(store, job, 4, 2000, 9000).await.is_none());
    assert!(store.retry(job, 5000).await.expect("retry"));
    assert!(!store.retry(job, 5000).await.expect("retry"), "once");
    let reason = store.failure_reason(job).await.expect("read");
    assert_eq!(reason, None, "failures are forgotten");
    let again = row(store, job).await;
    assert_eq!((again.units_leased, again.finished_ms), (0, None));
    let units = |claimed: &Claimed| -> u32 {
        let runs = claimed.runs.iter();
        runs.map(|run| run.block1 - run.block0).sum()
    };
    let all = claim(store, job, 16, 6000, 9000).await.expect("work");
    assert_eq!(units(&all), 16, "what was leased is ready");
    store.cancel(job, 6000).await.expect("cancel");
}

async fn the_log_is_a_ring(store: &Store) {
    let job = submit(store).await;
    for turn in 0..20 {
        let priority = 1 + turn % 2;
        let changed = store.set_priority(job, priority, i64::from(turn)).await;
        assert!(changed.expect("change"));
    }
    let all = store.log(job, i64::MAX, 100).await.expect("read");
    assert_eq!(all.len(), 20);
    assert!(all.iter().all(|event| event.kind == LogKind::Changed));
    assert_eq!(all[0].text.as_deref(), Some("priority 2"));
    assert!(all.is_sorted_by(|a, b| a.seq > b.seq));
    let some = store.log(job, all[4].seq, 3).await.expect("read");
    assert_eq!(some, all[5..8]);
    store.delete_job(job).await.expect("delete");
    while store.delete_some(job).await.expect("delete") > 0 {}
    assert_eq!(store.log(job, i64::MAX, 9).await.expect("read"), []);
}

/// A result of `worker` that says `word`.
fn said(job: JobId, run: Run, lease: i64, worker: &str, word: &str) -> PartRecord {
    let mut record = part(job, run, lease, 0);
    record.worker = worker.to_owned();
    record.sums_hash = ContentHash::of(word.as_bytes());
    record.object = format!("part/{job}/{run:?}/{worker}");
    record.audited = true;
    record
}

async fn audit(store: &Store, worker: &str) -> (JobId, Claimed) {
    let leased = store.lease_audits(worker, "b", 2000, 9000).await;
    leased.expect("lease").expect("an audit")
}

/// A job of one counted run of `first`, claimed again by each of `others`.
async fn disputed(store: &Store, job: JobId, first: &str, word: &str) -> Run {
    let held = claim(store, job, 1, 1000, 9000).await.expect("work");
    let run = held.runs[0];
    let record = said(job, run, held.id, first, word);
    let outcome = store.commit(&record, 1500).await.expect("commit");
    assert_eq!(outcome, CommitOutcome::Counted);
    run
}

async fn answer(store: &Store, worker: &str, word: &str) -> CommitOutcome {
    let (job, claimed) = audit(store, worker).await;
    let record = said(job, claimed.runs[0], claimed.id, worker, word);
    store.commit(&record, 3000).await.expect("commit")
}

async fn claims_decide(store: &Store) {
    let job = submit(store).await;
    disputed(store, job, "claims-a", "right").await;
    let own = store.lease_audits("claims-a", "b", 2000, 9000).await;
    assert_eq!(own.expect("look"), None, "nobody audits itself");
    let other_build = store.lease_audits("claims-b", "c", 2000, 9000).await;
    assert_eq!(other_build.expect("look"), None);
    let equal = answer(store, "claims-b", "right").await;
    assert_eq!(equal, CommitOutcome::Duplicate);
    assert_eq!(row(store, job).await.audits.equal, 1);

    disputed(store, job, "claims-a", "right").await;
    let (_, lost) = audit(store, "claims-c").await;
    assert!(beat(store, "claims-c", lost.id, 9000).await);
    let again = store.lease_audits("claims-b", "b", 2000, 9000).await;
    assert_eq!(again.expect("look"), None, "one at a time");
    store.expire(10_000).await.expect("expire");
    let unequal = answer(store, "claims-b", "wrong").await;
    let first_worker = "claims-a".to_owned();
    assert_eq!(unequal, CommitOutcome::Unequal { first_worker });
    assert_eq!(store.distrust_of("claims-b").await.expect("read"), None);
    let twice = store.lease_audits("claims-b", "b", 2000, 9000).await;
    assert_eq!(twice.expect("look"), None, "it has said its word");
    let third = answer(store, "claims-c", "right").await;
    assert_eq!(third, CommitOutcome::Duplicate);
    let reason = store.distrust_of("claims-b").await.expect("read");
    assert!(reason.expect("not believed").contains("differ"));
    assert_eq!(store.distrust_of("claims-c").await.expect("read"), None);
    let counts = row(store, job).await.audits;
    assert_eq!((counts.equal, counts.unequal, counts.open), (1, 1, 0));
    assert_eq!(
        store.tiles_to_withdraw(99).await.expect("look"),
        [],
        "nothing of it was counted"
    );
    let held = claim(store, job, 1, 1000, 9000).await.expect("work");
    let refused = said(job, held.runs[0], held.id, "claims-b", "right");
    let outcome = store.commit(&refused, 3000).await.expect("commit");
    assert_eq!(outcome, CommitOutcome::Distrusted);
    store.cancel(job, 4000).await.expect("cancel");
}

fn whole(frame: u32, tile: u32) -> Run {
    Run {
        frame,
        tile,
        block0: 0,
        block1: 4,
    }
}

async fn fold(store: &Store, job: JobId, frame: u32, tile: u32, name: &str) {
    let at = FrameTile { job, frame, tile };
    let old = store.tile_state(&at).await.expect("read").expect("tile");
    let task = FoldTask {
        at,
        old,
        film: format!("film/{job}/{frame}/{tile}/{name}"),
        error: TileError::default(),
        brightness: Brightness::default(),
        samples: 100,
    };
    assert!(store.swap_film(&task).await.expect("swap"));
}

fn end(extended: i64) -> FrameEnd {
    FrameEnd {
        film_hash: ContentHash::of(b"film"),
        cause: StopCause::Samples,
        samples: (512, 512),
        extended,
    }
}

async fn an_audit_holds_its_frame_and_can_be_given_up(store: &Store) {
    let job = submit(store).await;
    while claim(store, job, 64, 1, 9000).await.is_some() {}
    for tile in 0..4 {
        let mut record = said(job, whole(1, tile), 0, "hold-a", "x");
        record.audited = tile == 2;
        store.commit(&record, 5).await.expect("commit");
        fold(store, job, 1, tile, "first").await;
    }
    let ready = async || {
        let frames = store.frames_to_finish(99).await.expect("look");
        frames.contains(&(job, 1))
    };
    assert!(!ready().await, "one audit is open");
    let ended = store.finish_frame(job, 1, &end(0), None, 6).await;
    assert!(!ended.expect("finish"), "nor by whoever looked before");
    let holding = store.holding_audits().await.expect("look");
    let mine = holding.iter().find(|audit| audit.job == job);
    let mine = mine.expect("the audit");
    assert_eq!((mine.run, mine.changed_ms), (whole(1, 2), 5));
    assert_eq!(mine.waiting.claimants, ["hold-a"]);
    assert!(store.skip_audit(job, &whole(1, 2), 9).await.expect("skip"));
    assert!(!store.skip_audit(job, &whole(1, 2), 9).await.expect("skip"));
    assert!(ready().await);
    let counts = row(store, job).await.audits;
    assert_eq!((counts.skipped, counts.open), (1, 0));
    store.cancel(job, 9).await.expect("cancel");
}

/// Make `worker` one that is not believed, in a job of its own.
async fn expose(store: &Store, worker: &str) {
    let job = submit(store).await;
    disputed(store, job, "expose-a", "right").await;
    answer(store, worker, "wrong").await;
    answer(store, "expose-b", "right").await;
    assert!(store.distrust_of(worker).await.expect("read").is_some());
    store.cancel(job, 4000).await.expect("cancel");
}

async fn a_film_with_wrong_sums_is_begun_again(store: &Store) {
    let job = submit(store).await;
    while claim(store, job, 64, 1, 9000).await.is_some() {}
    for tile in 0..4 {
        for block in 0..4 {
            let run = Run {
                block0: block,
                block1: block + 1,
                ..whole(0, tile)
            };
            let liar = tile == 1 && block == 2;
            let worker = if liar { "film-liar" } else { "film-a" };
            let mut record = said(job, run, 0, worker, "x");
            record.audited = false;
            record.bad_samples = u64::from(liar);
            store.commit(&record, 5).await.expect("commit");
        }
        fold(store, job, 0, tile, "first").await;
    }
    assert!(
        store
            .finish_frame(job, 0, &end(0), None, 6)
            .await
            .expect("finish")
    );
    let before = row(store, job).await;
    assert_eq!((before.frames_done, before.units_done), (1, 16));
    expose(store, "film-liar").await;
    let at = FrameTile {
        job,
        frame: 0,
        tile: 1,
    };
    let wrong = store.tiles_to_withdraw(99).await.expect("look");
    assert_eq!(wrong, [at]);
    // Two coordinators find it at the same time.
    let (one, other) = tokio::join!(
        store.withdraw_tile(&before, &at, 7),
        store.withdraw_tile(&before, &at, 7)
    );
    let mut both = [one.expect("withdraw"), other.expect("withdraw")];
    both.sort_by_key(|withdrawn| withdrawn.units);
    let [nothing, withdrawn] = both;
    assert_eq!(nothing.units, 0, "taken back once");
    assert_eq!(withdrawn.units, 4, "honest ones in the same film too");
    assert_eq!(withdrawn.objects, [format!("film/{job}/0/1/first")]);
    assert_eq!(store.tiles_to_withdraw(99).await.expect("look"), []);
    let after = row(store, job).await;
    assert_eq!((after.frames_done, after.units_done), (0, 12));
    // Tile 1 has 32 x 64 of the 96 x 80 pixels.
    let less = 32 * 64 * u64::from(SETTINGS.samples);
    assert_eq!(after.samples_done, before.samples_done - less);
    assert_eq!(after.bad_samples, 0);
    let frame = store.frame(job, 0).await.expect("read").expect("frame");
    assert_eq!((frame.units_done, frame.film_hash), (12, None));
    let state = store.tile_state(&at).await.expect("read").expect("tile");
    assert_eq!((state.blocks, state.film, state.parts.len()), (0, None, 0));
    let again = claim(store, job, 16, 8, 9000).await.expect("work");
    let blocks: u32 = again.runs.iter().map(|run| run.block1 - run.block0).sum();
    assert_eq!(blocks, 4);
    assert!(again.runs.iter().all(|run| run.tile == 1));
    for run in &again.runs {
        let record = said(job, *run, again.id, "film-a", "y");
        let outcome = store
            .commit(
                &PartRecord {
                    audited: false,
                    ..record
                },
                9,
            )
            .await;
        assert_eq!(outcome.expect("commit"), CommitOutcome::Counted);
    }
    fold(store, job, 0, 1, "second").await;
    let late = store
        .finish_frame(job, 0, &end(before.extended), None, 9)
        .await;
    assert!(!late.expect("finish"), "decided before the withdrawal");
    let extended = row(store, job).await.extended;
    let ended = store.finish_frame(job, 0, &end(extended), None, 9).await;
    assert!(ended.expect("finish"));
    assert_eq!(row(store, job).await.samples_done, before.samples_done);
    store.cancel(job, 9).await.expect("cancel");
}

async fn only_the_wrong_parts_of_an_open_tile_go(store: &Store) {
    let job = submit(store).await;
    claim(store, job, 16, 1, 9000).await.expect("frame 0");
    for block in 0..3 {
        let run = Run {
            block0: block,
            block1: block + 1,
            ..whole(0, 0)
        };
        let worker = if block == 1 { "open-liar" } else { "open-a" };
        let mut record = said(job, run, 0, worker, "x");
        record.audited = false;
        store.commit(&record, 5).await.expect("commit");
    }
    expose(store, "open-liar").await;
    let at = FrameTile {
        job,
        frame: 0,
        tile: 0,
    };
    let before = store.tile_state(&at).await.expect("read").expect("tile");
    let job_row = row(store, job).await;
    let withdrawn = store
        .withdraw_tile(&job_row, &at, 7)
        .await
        .expect("withdraw");
    assert_eq!((withdrawn.units, withdrawn.objects.len()), (1, 1));
    // Whoever folds what it read before must look again.
    let task = FoldTask {
        at,
        old: before,
        film: "film/late".into(),
        error: TileError::default(),
        brightness: Brightness::default(),
        samples: 1,
    };
    assert!(!store.swap_film(&task).await.expect("swap"));
    let state = store.tile_state(&at).await.expect("read").expect("tile");
    let blocks: Vec<u32> = state.parts.iter().map(|part| part.block0).collect();
    assert_eq!(blocks, [0, 2]);
    assert_eq!(row(store, job).await.units_done, 2);
    store.cancel(job, 9).await.expect("cancel");
}

async fn a_frame_of_an_error_stop_is_made_again(store: &Store) {
    let stop = Stop {
        error: Some(ErrorTarget::new(0.01).expect("target")),
        ..Stop::NONE
    };
    let settings = RenderSettings {
        stop,
        samples: 1024,
        ..SETTINGS
    };
    let job = submit_with(store, settings).await;
    let before = row(store, job).await;
    let mut units = 0;
    while let Some(claimed) = claim(store, job, 64, 1, 9000).await {
        for run in claimed.runs {
            units += run.block1 - run.block0;
            let worker = if run.tile == 3 { "pass-liar" } else { "pass-a" };
            let mut record = said(job, run, claimed.id, worker, "x");
            record.samples = before.plan().run_samples(&run);
            record.audited = false;
            store.commit(&record, 5).await.expect("commit");
        }
    }
    let full = row(store, job).await;
    assert_eq!(full.units_done, u64::from(units));
    assert_eq!(
        (full.units_due, full.samples_total),
        (before.units_due, before.samples_total)
    );
    expose(store, "pass-liar").await;
    for frame in 0..settings.frames {
        let withdrawn = store.withdraw_frame(&full, frame, 7).await;
        assert!(withdrawn.expect("withdraw").units > 0);
    }
    let after = row(store, job).await;
    assert_eq!((after.units_done, after.samples_done), (0, 0));
    assert_eq!(
        (after.units_due, after.samples_total),
        (before.units_due, before.samples_total)
    );
    assert!(
        store
            .tile_states(job, 0, 0, 99)
            .await
            .expect("tiles")
            .is_empty()
    );
    let mut again = 0;
    while let Some(claimed) = claim(store, job, 64, 8, 9000).await {
        again += claimed
            .runs
            .iter()
            .map(|run| run.block1 - run.block0)
            .sum::<u32>();
    }
    assert_eq!(again, units, "every unit of the first pass, once");
    store.cancel(job, 9).await.expect("cancel");
}
