//! The plan: how a frame falls into units. A function of the job's settings
//! alone, never of the workers, so every process derives the same one.
//!
//! A frame is a grid of tiles; the samples of a tile are cut into blocks. A block
//! covers the same sample indices of *each* half, so both halves of a tile always
//! hold equally many samples; it ends at the next multiple of 64, at a cut of the
//! settings, or at the last sample. A unit is (frame, tile, block); a run is a
//! contiguous range of blocks of one tile, rendered and delivered as one part.
//!
//! With more samples or another cut behind the last one, every block that there
//! was keeps its number and its samples, if the old last sample is a cut.

use crate::job::RenderSettings;
use crate::limits::TILE_SIDE;
use crate::stop::{Cuts, Stop};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Sample indices per half in one block: with 64 x 64 pixels and two halves
/// 2^19 samples, about half a second of one core.
const BLOCK_SAMPLES_PER_HALF: u32 = 64;

/// Samples per pixel, both halves, at which the first decision about a tile falls:
/// with fewer the error estimate itself is too noisy. A job with an error target
/// cuts its blocks there.
pub const LEVEL_SAMPLES_MIN: u32 = 64;

/// How the frames of a job fall into units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    width: u32,
    height: u32,
    samples_per_half: u32,
    cuts: Cuts,
}

/// The pixels of one tile: `[x0, x0 + width) x [y0, y0 + height)`, y downward.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TileRect {
    /// Left column.
    pub x0: u32,
    /// Top row.
    pub y0: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl TileRect {
    /// Pixels in the tile.
    #[must_use]
    pub const fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }
}

/// A contiguous range of blocks of one tile of one frame.
#[derive(
    Clone,
    Copy,
    Debug,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    Serialize,
    Deserialize,
    schemars::JsonSchema,
    utoipa::ToSchema,
)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// The job's number of the frame, from 0; see
    /// [`RenderSettings::absolute_frame`].
    pub frame: u32,
    /// Tile number, row by row from the top left.
    pub tile: u32,
    /// First block.
    pub block0: u32,
    /// One past the last block.
    pub block1: u32,
}

impl Plan {
    /// The plan of a job. `settings` must be validated.
    #[must_use]
    pub fn new(settings: &RenderSettings) -> Self {
        let samples_per_half = (settings.samples / 2).max(1);
        Self {
            width: settings.width,
            height: settings.height,
            samples_per_half,
            cuts: settings.stop.cuts,
        }
    }

    /// Picture width in pixels.
    #[must_use]
    pub const fn width(&self) -> u32 {
        self.width
    }

    /// Picture height in pixels.
    #[must_use]
    pub const fn height(&self) -> u32 {
        self.height
    }

    /// Tiles per row.
    #[must_use]
    pub const fn tiles_x(&self) -> u32 {
        self.width.div_ceil(TILE_SIDE)
    }

    /// Tiles of a frame.
    #[must_use]
    pub const fn tiles(&self) -> u32 {
        self.tiles_x() * self.height.div_ceil(TILE_SIDE)
    }

    /// Blocks of a tile.
    #[must_use]
    pub fn blocks(&self) -> u32 {
        self.blocks_before(self.samples_per_half)
    }

    /// Blocks of a tile that begin before the sample index `end`.
    fn blocks_before(&self, end: u32) -> u32 {
        let cuts = self.own_cuts().filter(|&cut| cut < end);
        end.div_ceil(BLOCK_SAMPLES_PER_HALF) + u32::try_from(cuts.count()).unwrap_or(0)
    }

    /// Cuts where no block would end otherwise.
    fn own_cuts(&self) -> impl Iterator<Item = u32> {
        let cuts = self.cuts.ends().iter().copied();
        cuts.filter(|&cut| !Self::ends_block(cut))
    }

    /// Whether every plan of more samples ends a block at `samples` of each half.
    #[must_use]
    pub const fn ends_block(samples: u32) -> bool {
        samples.is_multiple_of(BLOCK_SAMPLES_PER_HALF)
    }

    /// One past the last sample index of block `block`, one of this plan.
    fn block_end(&self, block: u32) -> u32 {
        let mut before = 0;
        for cut in self.own_cuts() {
            // The block that ends at this cut.
            let number = cut / BLOCK_SAMPLES_PER_HALF + before;
            if number == block {
                return cut;
            }
            if number > block {
                break;
            }
            before += 1;
        }
        (block - before + 1)
            .saturating_mul(BLOCK_SAMPLES_PER_HALF)
            .min(self.samples_per_half)
    }

    /// Samples of each half in the first `blocks` blocks; all of them when there
    /// are fewer blocks.
    #[must_use]
    pub fn samples_of_blocks(&self, blocks: u32) -> u32 {
        match blocks {
            0 => 0,
            blocks => self.block_end(blocks - 1),
        }
    }

    /// Sample counts of each half at which a job with an error target decides
    /// which tiles go on: powers of two from [`LEVEL_SAMPLES_MIN`] / 2, cuts,
    /// and the last sample; rising.
    #[must_use]
    pub fn levels(&self) -> Vec<u32> {
        let powers = (0..u32::BITS).map(|k| 1u32 << k);
        let mut ends: Vec<u32> = powers
            .chain(self.cuts.ends().iter().copied())
            .filter(|&end| end >= LEVEL_SAMPLES_MIN / 2 && end < self.samples_per_half)
            .collect();
        ends.push(self.samples_per_half);
        ends.sort_unstable();
        ends.dedup();
        ends
    }

    /// Blocks that a frame's rows are made with: all of them, or those of the first
    /// level of a job with an error target.
    #[must_use]
    pub fn first_blocks(&self, stop: &Stop) -> u32 {
        let first = stop.error.and_then(|_| self.level_blocks(0));
        first.unwrap_or_else(|| self.blocks())
    }

    /// Units that a frame's rows are made with; see [`Plan::first_blocks`].
    #[must_use]
    pub fn first_units(&self, stop: &Stop) -> u64 {
        u64::from(self.tiles()) * u64::from(self.first_blocks(stop))
    }

    /// Blocks of a tile up to the first level that has more than `blocks`; `None`
    /// when there is none.
    #[must_use]
    pub fn next_level(&self, blocks: u32) -> Option<u32> {
        let ends = self.levels();
        let level = ends.iter().map(|&end| self.blocks_before(end));
        level.into_iter().find(|&level| level > blocks)
    }

    /// Blocks of a tile up to level `level` of [`Plan::levels`]; `None` when
    /// there is no such level.
    #[must_use]
    pub fn level_blocks(&self, level: u32) -> Option<u32> {
        let end = *self.levels().get(level as usize)?;
        Some(self.blocks_before(end))
    }

    /// Units of a frame.
    #[must_use]
    pub fn units_per_frame(&self) -> u64 {
        self.tiles() as u64 * self.blocks() as u64
    }

    /// Samples of a frame, over all pixels and both halves.
    #[must_use]
    pub const fn frame_samples(&self) -> u64 {
        self.width as u64 * self.height as u64 * 2 * self.samples_per_half as u64
    }

    /// Samples of each half in the finished picture.
    #[must_use]
    pub const fn samples_per_half(&self) -> u32 {
        self.samples_per_half
    }

    /// The pixels of a tile; `None` when there is no such tile.
    #[must_use]
    pub fn tile_rect(&self, tile: u32) -> Option<TileRect> {
        if tile >= self.tiles() {
            return None;
        }
        let x0 = tile % self.tiles_x() * TILE_SIDE;
        let y0 = tile / self.tiles_x() * TILE_SIDE;
        Some(TileRect {
            x0,
            y0,
            width: TILE_SIDE.min(self.width - x0),
            height: TILE_SIDE.min(self.height - y0),
        })
    }

    /// The sample indices (of each half) that a run covers; `None` when the run
    /// is empty or not of this plan.
    #[must_use]
    pub fn sample_range(&self, run: &Run) -> Option<Range<u32>> {
        if run.tile >= self.tiles() || run.block0 >= run.block1 || run.block1 > self.blocks() {
            return None;
        }
        let start = match run.block0 {
            0 => 0,
            block0 => self.block_end(block0 - 1),
        };
        Some(start..self.block_end(run.block1 - 1))
    }

    /// Samples (both halves, all pixels) of a run; 0 when it is not of this plan.
    #[must_use]
    pub fn run_samples(&self, run: &Run) -> u64 {
        match (self.tile_rect(run.tile), self.sample_range(run)) {
            (Some(rect), Some(range)) => {
                rect.pixels() as u64 * u64::from(range.end - range.start) * 2
            }
            _ => 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(width: u32, height: u32, samples: u32) -> Plan {
        Plan::new(&RenderSettings {
            width,
            height,
            samples,
            seed: 0,
            frames: 1,
            first_frame: 0,
            stop: Stop::NONE,
        })
    }

    fn cut_plan(samples: u32, cuts: &[u32]) -> Plan {
        let cuts = Cuts::try_from(cuts.to_vec()).expect("cuts");
        Plan {
            cuts,
            ..plan(64, 64, samples)
        }
    }

    fn ranges(plan: &Plan) -> Vec<Range<u32>> {
        let block = |block| Run {
            frame: 0,
            tile: 0,
            block0: block,
            block1: block + 1,
        };
        let blocks = (0..plan.blocks()).map(|b| plan.sample_range(&block(b)).expect("block"));
        blocks.collect()
    }

    #[test]
    fn cuts_end_blocks_and_leave_the_others() {
        assert_eq!(ranges(&plan(64, 64, 100)), std::slice::from_ref(&(0..50)));
        assert_eq!(ranges(&cut_plan(256, &[50])), [0..50, 50..64, 64..128]);
        assert_eq!(
            ranges(&cut_plan(512, &[32, 50, 130])),
            [0..32, 32..50, 50..64, 64..128, 128..130, 130..192, 192..256]
        );
        // A cut at a block's own end changes nothing.
        assert_eq!(
            ranges(&cut_plan(512, &[64, 128])),
            ranges(&plan(64, 64, 512))
        );
        let whole = |plan: &Plan| Run {
            frame: 0,
            tile: 0,
            block0: 0,
            block1: plan.blocks(),
        };
        let odd = cut_plan(300, &[1, 2, 3, 149]);
        assert_eq!(odd.sample_range(&whole(&odd)), Some(0..150));
    }

    #[test]
    fn additions_keep_every_block_that_there_was() {
        for first in (2..400).step_by(2) {
            let before = ranges(&plan(64, 64, first));
            for more in [2, 30, 128, 500] {
                let after = ranges(&cut_plan(first + more, &[first / 2]));
                assert_eq!(after[..before.len()], before, "{first} + {more}");
                assert_eq!(after.last().map(|r| r.end), Some((first + more) / 2));
                assert!(after.windows(2).all(|w| w[0].end == w[1].start));
                assert!(
                    after
                        .iter()
                        .all(|r| r.end > r.start && r.end - r.start <= 64)
                );
            }
        }
    }

    #[test]
    fn levels_are_powers_of_two_and_ends_of_blocks() {
        let adaptive = cut_plan(1000, &[32]);
        assert_eq!(adaptive.levels(), [32, 64, 128, 256, 500]);
        let blocks: Vec<_> = (0..6).map(|level| adaptive.level_blocks(level)).collect();
        assert_eq!(blocks, [Some(1), Some(2), Some(3), Some(5), Some(9), None]);
        let ends: Vec<u32> = ranges(&adaptive).iter().map(|range| range.end).collect();
        for level in adaptive.levels() {
            assert!(ends.contains(&level), "{level}");
        }
        // Levels of before keep their numbers.
        let longer = cut_plan(4000, &[32, 500]);
        assert_eq!(longer.levels(), [32, 64, 128, 256, 500, 512, 1024, 2000]);
        assert_eq!(plan(64, 64, 16).levels(), [8]);
    }

    #[test]
    fn tiles_cover_every_pixel_once() {
        let plan = plan(150, 70, 16);
        let mut seen = vec![0u8; 150 * 70];
        for tile in 0..plan.tiles() {
            let r = plan.tile_rect(tile).expect("tile");
            for y in r.y0..r.y0 + r.height {
                for x in r.x0..r.x0 + r.width {
                    seen[(y * 150 + x) as usize] += 1;
                }
            }
        }
        assert!(seen.iter().all(|&n| n == 1));
        assert_eq!(plan.tile_rect(plan.tiles()), None);
    }

    #[test]
    fn blocks_cover_every_sample_once() {
        for samples in [2, 4, 126, 128, 130, 512, 1000] {
            let plan = plan(64, 64, samples);
            let mut next = 0;
            for block in 0..plan.blocks() {
                let run = Run {
                    frame: 0,
                    tile: 0,
                    block0: block,
                    block1: block + 1,
                };
                let range = plan.sample_range(&run).expect("block");
                assert_eq!(range.start, next);
                next = range.end;
            }
            assert_eq!(next, samples / 2);
            let whole = Run {
                frame: 0,
                tile: 0,
                block0: 0,
                block1: plan.blocks(),
            };
            assert_eq!(plan.sample_range(&whole), Some(0..samples / 2));
            let beyond = Run {
                block1: plan.blocks() + 1,
                ..whole
            };
            assert_eq!(plan.sample_range(&beyond), None);
        }
    }
}
