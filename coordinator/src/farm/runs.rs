//! From ready units to the runs of a lease.

use shearwater_shared::limits::{LEASE_RUNS_MAX, RUN_SAMPLES_PER_HALF_MAX};
use shearwater_shared::plan::{Plan, Run};

/// One unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Unit {
    /// Frame.
    pub frame: u32,
    /// Tile.
    pub tile: u32,
    /// Block.
    pub block: u32,
}

/// Runs of one lease that each thread of a worker should get at least: a thread
/// renders one run at a time, so with two of them none waits for long.
const RUNS_PER_THREAD: usize = 2;

/// Join neighbouring units (sorted, each once) to runs: contiguous blocks of
/// one tile, as long as the fixed point and the worker's threads allow, at most
/// [`LEASE_RUNS_MAX`].
#[must_use]
pub fn cut_runs(ready: &[Unit], plan: &Plan, threads: u32) -> Vec<Run> {
    let shares = RUNS_PER_THREAD.saturating_mul(threads.max(1) as usize);
    let blocks_max = u32::try_from(ready.len() / shares)
        .unwrap_or(u32::MAX)
        .max(1);
    let mut runs: Vec<Run> = Vec::new();
    for unit in ready {
        let fits = runs.last_mut().filter(|run| {
            run.frame == unit.frame
                && run.tile == unit.tile
                && run.block1 == unit.block
                && run.block1 - run.block0 < blocks_max
                && samples_with(run, plan) <= RUN_SAMPLES_PER_HALF_MAX
        });
        if let Some(run) = fits {
            run.block1 += 1;
            continue;
        }
        if runs.len() == LEASE_RUNS_MAX {
            return runs;
        }
        runs.push(Run {
            frame: unit.frame,
            tile: unit.tile,
            block0: unit.block,
            block1: unit.block + 1,
        });
    }
    runs
}

/// Samples per half of the run with one more block.
fn samples_with(run: &Run, plan: &Plan) -> u32 {
    let longer = Run {
        block1: run.block1 + 1,
        ..*run
    };
    plan.sample_range(&longer)
        .map_or(u32::MAX, |range| range.end - range.start)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use shearwater_shared::job::RenderSettings;

    fn plan(samples: u32) -> Plan {
        Plan::new(&RenderSettings {
            width: 256,
            height: 64,
            samples,
            seed: 0,
            frames: 1,
            first_frame: 0,
            stop: shearwater_shared::stop::Stop::NONE,
        })
    }

    fn units(tile: u32, blocks: std::ops::Range<u32>) -> Vec<Unit> {
        blocks
            .map(|block| Unit {
                frame: 0,
                tile,
                block,
            })
            .collect()
    }

    fn run(tile: u32, block0: u32, block1: u32) -> Run {
        Run {
            frame: 0,
            tile,
            block0,
            block1,
        }
    }

    #[test]
    fn joins_blocks_and_splits_at_holes_and_tiles() {
        let plan = plan(1024); // 8 blocks
        let ready = [units(0, 0..3), units(0, 5..8), units(1, 0..8)].concat();
        assert_eq!(
            cut_runs(&ready, &plan, 1),
            [run(0, 0, 3), run(0, 5, 8), run(1, 0, 7), run(1, 7, 8)]
        );
    }

    #[test]
    fn every_thread_gets_two_runs_if_there_are_units() {
        let plan = plan(1024);
        let ready = [units(0, 0..8), units(1, 0..8)].concat();
        assert_eq!(cut_runs(&ready, &plan, 1).len(), 2);
        assert_eq!(cut_runs(&ready, &plan, 4).len(), 8);
        assert_eq!(cut_runs(&ready, &plan, 1000).len(), 16);
        assert_eq!(cut_runs(&[], &plan, 4), []);
    }

    #[test]
    fn a_run_never_outgrows_the_fixed_point() {
        let plan = plan(1 << 20);
        for run in cut_runs(&units(0, 0..500), &plan, 1) {
            let range = plan.sample_range(&run).expect("run of the plan");
            assert!(range.end - range.start <= RUN_SAMPLES_PER_HALF_MAX);
        }
    }

    proptest! {
        #[test]
        fn runs_cover_ready_units_once(picks in proptest::collection::btree_set((0u32..4, 0u32..8), 0..32)) {
            let plan = plan(1024);
            let ready: Vec<Unit> = picks
                .iter()
                .map(|&(tile, block)| Unit { frame: 0, tile, block })
                .collect();
            let runs = cut_runs(&ready, &plan, 2);
            let covered: Vec<Unit> = runs
                .iter()
                .flat_map(|r| units(r.tile, r.block0..r.block1))
                .collect();
            prop_assert_eq!(covered, ready);
        }
    }
}
