//! Random orders of everything that can happen; nothing is lost or doubled.

use crate::suite::{SETTINGS, claim, part, submit};
use shearwater_coordinator::store::{CommitOutcome, FoldTask, FrameTile, Store};
use shearwater_shared::film::{Brightness, TileError};
use shearwater_shared::job::JobId;
use shearwater_shared::plan::{Plan, Run};
use std::collections::BTreeSet;

/// Events before the farm is left to finish.
const EVENTS: u64 = 120;

/// A small generator (xorshift, Marsaglia 2003): the same events for a seed.
struct Dice(u64);

impl Dice {
    fn roll(&mut self, sides: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % sides
    }
}

struct Model {
    job: JobId,
    dice: Dice,
    now_ms: i64,
    nonce: u64,
    /// Runs that some worker holds, with its lease.
    held: Vec<(i64, Run)>,
    /// Units that were acknowledged as counted.
    counted: BTreeSet<(u32, u32, u32)>,
}

pub(crate) async fn random_events_count_everything_once(store: &Store, seed: u64) {
    let mut model = Model {
        job: submit(store).await,
        dice: Dice(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15)),
        now_ms: 1,
        nonce: 0,
        held: Vec::new(),
        counted: BTreeSet::new(),
    };
    for _ in 0..EVENTS {
        model.event(store).await;
    }
    // No more accidents: expire what is lost, then work to the end.
    model.now_ms += 1000;
    store.expire(model.now_ms).await.expect("expire");
    while let Some(claimed) = claim(store, model.job, 7, model.now_ms, model.now_ms + 9).await {
        for run in claimed.runs {
            model.deliver(store, claimed.id, run).await;
        }
    }
    model.check(store).await;
}

impl Model {
    async fn event(&mut self, store: &Store) {
        self.now_ms += i64::try_from(self.dice.roll(20)).expect("small");
        let choice = self.dice.roll(100);
        if choice < 30 || self.held.is_empty() {
            let units = 1 + self.dice.roll(12) as usize;
            let until_ms = self.now_ms + 30;
            if let Some(got) = claim(store, self.job, units, self.now_ms, until_ms).await {
                self.held
                    .extend(got.runs.into_iter().map(|run| (got.id, run)));
            }
            return;
        }
        let at = self.dice.roll(self.held.len() as u64) as usize;
        let (lease, run) = self.held[at];
        let runs = [run];
        match choice {
            // Delivered; the worker may forget it or send it again later.
            30..65 => {
                self.deliver(store, lease, run).await;
                if self.dice.roll(3) > 0 {
                    self.held.swap_remove(at);
                }
            }
            // Delivered in another cut than it was leased.
            65..72 => {
                let wider = Run {
                    block1: (run.block1 + 1).min(4),
                    ..run
                };
                self.deliver(store, lease, wider).await;
            }
            72..80 => {
                store.expire(self.now_ms).await.expect("expire");
            }
            80..85 => {
                store
                    .release("w", lease, self.now_ms)
                    .await
                    .expect("release");
            }
            85..88 => {
                let failure = store.record_failure(self.job, lease, &runs, "w", "ill", self.now_ms);
                failure.await.expect("record");
            }
            88..91 => {
                let again = store.reissue(self.job, &runs, "v", self.now_ms, self.now_ms + 30);
                if let Some(again) = again.await.expect("reissue") {
                    self.held
                        .extend(again.runs.into_iter().map(|run| (again.id, run)));
                }
            }
            _ => self.fold(store, run).await,
        }
    }

    async fn deliver(&mut self, store: &Store, lease: i64, run: Run) {
        self.nonce += 1;
        let record = part(self.job, run, lease, self.nonce);
        let outcome = store.commit(&record, self.now_ms).await.expect("commit");
        let units = (run.block0..run.block1).map(|block| (run.frame, run.tile, block));
        match outcome {
            CommitOutcome::Counted => {
                for unit in units {
                    assert!(self.counted.insert(unit), "{unit:?} was counted twice");
                }
            }
            CommitOutcome::Duplicate => {
                for unit in units {
                    assert!(self.counted.contains(&unit), "{unit:?} was lost");
                }
            }
            CommitOutcome::Overlap => {}
            other => panic!("{other:?} of {run:?}"),
        }
    }

    async fn fold(&mut self, store: &Store, run: Run) {
        let at = FrameTile {
            job: self.job,
            frame: run.frame,
            tile: run.tile,
        };
        let old = store.tile_state(&at).await.expect("read").expect("tile");
        self.nonce += 1;
        let fold = FoldTask {
            at,
            old,
            film: format!("film/{}", self.nonce),
            error: TileError::default(),
            brightness: Brightness::default(),
            samples: 0,
        };
        assert!(store.swap_film(&fold).await.expect("swap"));
    }

    async fn check(&self, store: &Store) {
        let plan = Plan::new(&SETTINGS);
        let units = plan.units_per_frame() * u64::from(SETTINGS.frames);
        assert_eq!(self.counted.len() as u64, units, "every unit is counted");
        let row = store.job(self.job).await.expect("read").expect("job");
        assert_eq!((row.units_done, row.units_leased), (units, 0));
        assert_eq!(row.samples_done, row.samples_total);
        for frame in 0..SETTINGS.frames {
            for tile in store
                .tile_states(self.job, frame, 0, 99)
                .await
                .expect("tiles")
            {
                let parts: u32 = tile.parts.iter().map(|p| p.block1 - p.block0).sum();
                assert_eq!(tile.blocks + parts, plan.blocks(), "frame {frame} {tile:?}");
            }
        }
    }
}
