//! Everything at once, from two coordinators: no transaction may fail because of
//! another one, and the counts come out right.

use crate::engines::Database;
use crate::suite::{SETTINGS, beat, claim, part, submit_frames};
use shearwater_coordinator::store::{CommitOutcome, FoldTask, FrameTile, Store};
use shearwater_shared::film::{Brightness, TileError};
use shearwater_shared::job::JobId;
use shearwater_shared::plan::Plan;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::time::Instant;

/// Frames of 16 units: small claims make many transactions of them.
const FRAMES: u32 = 24;
/// Workers of each coordinator.
const WORKERS: u32 = 3;

struct Race {
    job: JobId,
    /// Milliseconds, one for each look at it: leases expire while they are in use.
    clock: AtomicI64,
    over: AtomicBool,
}

pub(crate) async fn everything_at_once(database: &Database) {
    let stores = [database.open().await, database.open().await];
    let race = Arc::new(Race {
        job: submit_frames(&stores[0], FRAMES).await,
        clock: AtomicI64::new(1),
        over: AtomicBool::new(false),
    });
    let started = Instant::now();
    let mut workers = tokio::task::JoinSet::new();
    let mut others = tokio::task::JoinSet::new();
    for (number, store) in (0u32..).zip(&stores) {
        for worker in 0..WORKERS {
            let seed = u64::from(number * WORKERS + worker + 1);
            workers.spawn(work(store.clone(), Arc::clone(&race), seed));
        }
        others.spawn(fold(store.clone(), Arc::clone(&race)));
        others.spawn(reap(store.clone(), Arc::clone(&race)));
    }
    let mut counted = 0;
    while let Some(worker) = workers.join_next().await {
        counted += worker.expect("no transaction failed");
    }
    race.over.store(true, Ordering::Relaxed);
    while let Some(other) = others.join_next().await {
        other.expect("no transaction failed");
    }
    let units = u64::from(FRAMES) * Plan::new(&SETTINGS).units_per_frame();
    assert_eq!(counted, units, "every unit once");
    let row = stores[0].job(race.job).await.expect("read").expect("job");
    assert_eq!((row.units_done, row.units_leased), (units, 0));
    eprintln!("{units} units in {:?}", started.elapsed());
}

impl Race {
    fn now_ms(&self) -> i64 {
        self.clock.fetch_add(1, Ordering::Relaxed)
    }
}

/// Claim, deliver most of it, some twice, give some back, fail on some; how many
/// units were counted.
async fn work(store: Store, race: Arc<Race>, seed: u64) -> u64 {
    let job = race.job;
    let (mut counted, mut idle, mut turn) = (0, 0, seed);
    // What others still hold expires, so nothing ready is not yet the end.
    while idle < 40 {
        turn += 1;
        let now_ms = race.now_ms();
        let Some(claimed) = claim(&store, job, 1 + turn as usize % 7, now_ms, now_ms + 60).await
        else {
            idle += 1;
            tokio::time::sleep(std::time::Duration::from_millis(10)).await;
            continue;
        };
        idle = 0;
        beat(&store, "w", claimed.id, now_ms + 80).await;
        if turn.is_multiple_of(11) {
            store.release("w", claimed.id, 5).await.expect("release");
            continue;
        }
        for run in claimed.runs {
            if turn.is_multiple_of(13) {
                let runs = [run];
                let failed = store.record_failure(job, claimed.id, &runs, "w", "ill", 5);
                failed.await.expect("record failure");
            }
            for nonce in 0..=(turn % 2) {
                let record = part(job, run, claimed.id, seed << 32 | turn << 1 | nonce);
                let outcome = store.commit(&record, race.now_ms()).await.expect("commit");
                if outcome == CommitOutcome::Counted {
                    counted += u64::from(run.block1 - run.block0);
                }
            }
        }
    }
    counted
}

async fn fold(store: Store, race: Arc<Race>) {
    let mut serial = 0;
    while !race.over.load(Ordering::Relaxed) {
        for at in store.tiles_to_fold(2, 8).await.expect("look") {
            fold_one(&store, at, &mut serial).await;
        }
        for (job, frame) in store.frames_to_finish(2).await.expect("look") {
            let _ = store.pass_state(job, frame).await.expect("pass");
        }
        tokio::task::yield_now().await;
    }
}

async fn fold_one(store: &Store, at: FrameTile, serial: &mut u64) {
    let Some(old) = store.tile_state(&at).await.expect("read") else {
        return;
    };
    *serial += 1;
    let task = FoldTask {
        at,
        old,
        film: format!("film/{}/{serial}-{:?}", at.job, std::thread::current().id()),
        error: TileError::default(),
        brightness: Brightness::default(),
        samples: 1,
    };
    store.swap_film(&task).await.expect("swap");
}

async fn reap(store: Store, race: Arc<Race>) {
    while !race.over.load(Ordering::Relaxed) {
        store.expire(race.now_ms()).await.expect("expire");
        store.withhold_all(race.now_ms()).await.expect("withhold");
        tokio::time::sleep(std::time::Duration::from_millis(2)).await;
    }
}
