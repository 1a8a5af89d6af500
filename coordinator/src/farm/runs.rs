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

/// Join neighbouring units (sorted, each once) to runs: contiguous blocks of
/// one tile, as long as the fixed point allows, at most [`LEASE_RUNS_MAX`].
/// A last run that `wanted` cut off inside its tile is left for the next lease
/// if at least half of what was wanted remains: fewer, larger parts.
#[must_use]
pub fn cut_runs(ready: &[Unit], plan: &Plan, wanted: usize) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for unit in ready {
        let fits = runs.last_mut().filter(|run| {
            run.frame == unit.frame
                && run.tile == unit.tile
                && run.block1 == unit.block
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
    let cut_off = ready.len() >= wanted;
    if let [.., _, last] = runs[..] {
        let remaining = ready.len() - (last.block1 - last.block0) as usize;
        if cut_off && last.block1 < plan.blocks() && 2 * remaining >= wanted {
            runs.pop();
        }
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
            cut_runs(&ready, &plan, 100),
            [run(0, 0, 3), run(0, 5, 8), run(1, 0, 8)]
        );
    }

    #[test]
    fn leaves_a_tile_whole_if_that_costs_little() {
        let plan = plan(1024);
        let ready = [units(0, 0..8), units(1, 0..2)].concat();
        assert_eq!(cut_runs(&ready, &plan, 10), [run(0, 0, 8)]);
        let ready = [units(0, 6..8), units(1, 0..6)].concat();
        assert_eq!(
            cut_runs(&ready, &plan, 8).len(),
            2,
            "half of it would be lost"
        );
        assert_eq!(
            cut_runs(&units(0, 0..3), &plan, 3),
            [run(0, 0, 3)],
            "never nothing"
        );
    }

    #[test]
    fn a_run_never_outgrows_the_fixed_point() {
        let plan = plan(1 << 20);
        for run in cut_runs(&units(0, 0..500), &plan, 10_000) {
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
            let runs = cut_runs(&ready, &plan, usize::MAX);
            let covered: Vec<Unit> = runs
                .iter()
                .flat_map(|r| units(r.tile, r.block0..r.block1))
                .collect();
            prop_assert_eq!(covered, ready);
        }
    }
}
