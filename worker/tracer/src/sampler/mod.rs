//! Samples as pure functions.
//!
//! Every random number of a path is a function of (seed, frame, half, pixel,
//! sample index, dimension). Pixel, lens, time and the first scatterings draw
//! from Owen-scrambled Sobol points in groups of four dimensions, each group
//! shuffled and scrambled on its own (Burley 2020, "Practical Hash-based Owen
//! Scrambling"); deeper scatterings draw from a counter-based hash. No state
//! survives a sample.

mod sobol;

pub use sobol::sobol4_owen;

use crate::math::hash::{mix32, mix64, u32_to_unit};
use shearwater_shared::film::Half;

// Groups of four dimensions. The camera has one; each scattering has two.
const CAMERA_GROUP: u32 = 0;
const LENS_GROUP: u32 = 1;
const FIRST_SCATTERING_GROUP: u32 = 2;

/// Which draws come from Sobol points; all others come from the hash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pattern {
    /// The first group that comes from the hash.
    hashed_from: u32,
}

/// Names the pixel of one half of one frame; its samples differ by index.
#[derive(Clone, Copy, Debug)]
pub struct PixelSampler {
    key: u64,
    pattern: Pattern,
}

/// Draws of one sample.
#[derive(Clone, Copy, Debug)]
pub struct SampleStream {
    pixel_key: u64,
    index: u32,
    pattern: Pattern,
}

impl Pattern {
    /// Sobol points for pixel, lens, time and the first `scatterings`.
    #[must_use]
    pub const fn sobol(scatterings: u32) -> Self {
        Self {
            hashed_from: FIRST_SCATTERING_GROUP.saturating_add(scatterings.saturating_mul(2)),
        }
    }

    /// Independent numbers for everything.
    #[must_use]
    pub const fn independent() -> Self {
        Self { hashed_from: 0 }
    }
}

impl PixelSampler {
    /// The sampler of a pixel.
    #[must_use]
    pub fn new(seed: u64, frame: u32, half: Half, x: u32, y: u32, pattern: Pattern) -> Self {
        let frame_key = mix64(seed ^ mix64((u64::from(frame) << 1) | half.index() as u64));
        Self {
            key: mix64(frame_key ^ ((u64::from(y) << 32) | u64::from(x))),
            pattern,
        }
    }

    /// The draws of sample `index`.
    #[inline]
    #[must_use]
    pub fn sample(&self, index: u32) -> SampleStream {
        SampleStream {
            pixel_key: self.key,
            index,
            pattern: self.pattern,
        }
    }
}

impl SampleStream {
    /// Position in the pixel (two), time (one), and one spare, each in [0, 1).
    #[inline]
    #[must_use]
    pub fn camera(&self) -> [f32; 4] {
        self.group(CAMERA_GROUP)
    }

    /// Position on the lens (the first two).
    #[inline]
    #[must_use]
    pub fn lens(&self) -> [f32; 4] {
        self.group(LENS_GROUP)
    }

    /// Draws for scattering number `depth` (from 0): direction (three) and
    /// Russian roulette (one).
    #[inline]
    #[must_use]
    pub fn scatter(&self, depth: u32) -> [f32; 4] {
        self.group(FIRST_SCATTERING_GROUP + 2 * depth)
    }

    /// Draws for the lights seen from scattering number `depth`: sun (two) and
    /// sky (two).
    #[inline]
    #[must_use]
    pub fn lights(&self, depth: u32) -> [f32; 4] {
        self.group(FIRST_SCATTERING_GROUP + 2 * depth + 1)
    }

    /// A draw for whether to trace a faint light sample of scattering `depth`.
    #[inline]
    #[must_use]
    pub fn roulette(&self, depth: u32) -> f32 {
        u32_to_unit(mix64(
            self.pixel_key ^ (u64::from(self.index) << 32) ^ u64::from(depth) ^ 0x0DD5_0F5A_11E5,
        ) as u32)
    }

    /// Key of the path segment `depth`, for decisions on transparent surfaces
    /// along it: two passes through one particle are decided independently.
    #[inline]
    #[must_use]
    pub fn segment_key(&self, depth: u32) -> u64 {
        mix64(
            self.pixel_key
                ^ (u64::from(self.index) << 32)
                ^ u64::from(depth)
                ^ 0x5EED_0F5E_6A3B_17C9,
        )
    }

    #[inline]
    fn group(&self, group: u32) -> [f32; 4] {
        if group < self.pattern.hashed_from {
            self.sobol_group(group)
        } else {
            self.hash_group(group)
        }
    }

    #[inline]
    fn sobol_group(&self, group: u32) -> [f32; 4] {
        let key = mix64(self.pixel_key ^ (u64::from(group) << 40));
        sobol4_owen(self.index, (key >> 32) as u32, key as u32).map(u32_to_unit)
    }

    #[inline]
    fn hash_group(&self, group: u32) -> [f32; 4] {
        let key = mix64(self.pixel_key ^ (u64::from(self.index) << 32) ^ u64::from(group));
        let (low, high) = (key as u32, (key >> 32) as u32);
        [
            low,
            high,
            mix32(low ^ 0x9E37_79B9),
            mix32(high ^ 0x85EB_CA6B),
        ]
        .map(u32_to_unit)
    }
}
