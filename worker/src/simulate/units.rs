//! Which units something happened to: one bit each.

use shearwater_shared::plan::{Plan, Run};

/// A set of the units of one job.
#[derive(Clone, Debug)]
pub(super) struct Units {
    words: Vec<u64>,
    per_frame: u64,
    blocks: u64,
    len: u64,
    total: u64,
}

impl Units {
    /// None of a job of `frames` frames.
    pub(super) fn none(plan: &Plan, frames: u32) -> Self {
        let per_frame = plan.units_per_frame();
        let total = per_frame.saturating_mul(frames.into());
        Self {
            words: vec![0; usize::try_from(total.div_ceil(64)).unwrap_or(0)],
            per_frame,
            blocks: plan.blocks().into(),
            len: 0,
            total,
        }
    }

    /// Put the units of a run in; how many were not in yet.
    pub(super) fn insert(&mut self, run: &Run) -> u64 {
        let before = self.len;
        for block in run.block0..run.block1 {
            let unit = u64::from(run.frame) * self.per_frame
                + u64::from(run.tile) * self.blocks
                + u64::from(block);
            let Some(word) = self.words.get_mut((unit / 64) as usize) else {
                continue;
            };
            let bit = 1 << (unit % 64);
            self.len += u64::from(*word & bit == 0);
            *word |= bit;
        }
        self.len - before
    }

    /// Whether all are.
    pub(super) const fn is_full(&self) -> bool {
        self.len >= self.total
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shearwater_shared::job::RenderSettings;
    use shearwater_shared::stop::Stop;

    #[test]
    fn every_unit_has_a_bit_of_its_own() {
        let plan = Plan::new(&RenderSettings {
            width: 130,
            height: 1,
            samples: 640,
            seed: 0,
            frames: 7,
            first_frame: 0,
            stop: Stop::default(),
        });
        let mut units = Units::none(&plan, 7);
        for frame in 0..7 {
            for tile in 0..plan.tiles() {
                let run = |block0, block1| Run {
                    frame,
                    tile,
                    block0,
                    block1,
                };
                assert_eq!(units.insert(&run(0, 3)), 3);
                assert!(!units.is_full());
                assert_eq!(units.insert(&run(2, 5)), 2);
                assert_eq!(units.insert(&run(0, 5)), 0);
            }
        }
        assert!(units.is_full());
    }
}
