//! The plan: how a frame falls into units. A function of the job's settings
//! alone, never of the workers, so every process derives the same one.
//!
//! A frame is a grid of tiles; the samples of a tile are cut into blocks. Block
//! `b` covers the sample indices `[b * B, (b + 1) * B)` of *each* half, so both
//! halves of a tile always hold equally many samples. A unit is (frame, tile,
//! block); a run is a contiguous range of blocks of one tile, rendered and
//! delivered as one part.

use crate::job::RenderSettings;
use crate::limits::TILE_SIDE;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Sample indices per half in one block: with 64 x 64 pixels and two halves
/// 2^19 samples, about half a second of one core.
const BLOCK_SAMPLES_PER_HALF: u32 = 64;

/// How the frames of a job fall into units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    width: u32,
    height: u32,
    samples_per_half: u32,
    block_samples: u32,
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
            block_samples: BLOCK_SAMPLES_PER_HALF.min(samples_per_half),
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
    pub const fn blocks(&self) -> u32 {
        self.samples_per_half.div_ceil(self.block_samples)
    }

    /// Units of a frame.
    #[must_use]
    pub const fn units_per_frame(&self) -> u64 {
        self.tiles() as u64 * self.blocks() as u64
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
        let end = (u64::from(run.block1) * u64::from(self.block_samples))
            .min(self.samples_per_half.into());
        Some(run.block0 * self.block_samples..u32::try_from(end).ok()?)
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
        })
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
