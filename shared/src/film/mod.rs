//! The exact film: sums of radiance as integers.
//!
//! Each sample's RGB is rounded once to fixed point (2^-24) and added as an
//! integer. Integer addition is associative and commutative, so runs may be cut,
//! joined, reordered and repeated at will and the film has one right value. A
//! run sums in `i64`; the merged film in `i128`.

mod bad;
mod brightness;
mod error;
mod fixed;
mod merge;

pub use bad::{BadCause, BadSample, BadSamples};
pub use brightness::{BRIGHTNESS_BINS, Brightness, BrightnessBin, BrightnessTally, brightness_bin};
pub use error::{
    ErrorDetail, ErrorEstimate, TileDetail, TileError, estimate_error, join_errors, tile_error,
};
pub use fixed::{FIXED_ONE, FIXED_SHIFT, SAMPLE_MAX, fixed_from_f32, rgb_to_fixed};
pub use merge::{FilmError, FilmHasher, TileFilm, film_hash};

use crate::limits::FEATURE_SAMPLES;
use crate::plan::TileRect;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// The two independent halves of a picture. Their difference gives an honest
/// error estimate at any time: mean((A - B)^2) / 4 is the picture's MSE.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Half {
    /// First half.
    A,
    /// Second half, with its own scrambles.
    B,
}

impl Half {
    /// Both halves, in order.
    pub const BOTH: [Self; 2] = [Self::A, Self::B];

    /// 0 for A, 1 for B.
    #[must_use]
    pub const fn index(self) -> usize {
        self as usize
    }
}

/// Features of a pixel, summed over the first [`FEATURE_SAMPLES`] samples of
/// each half: albedo R G B, world normal X Y Z, distance in metres (0 where
/// the ray left the scene), and 1 for each sample that hit something.
pub const FEATURE_CHANNELS: usize = 8;

/// What one run delivers: sums over its samples, for each pixel of its tile.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TileSums {
    /// Samples summed per pixel in each half.
    pub samples_per_half: u32,
    /// RGB sums of half A then half B: `[half][3 * pixel + channel]`, pixels row
    /// by row from the top left, fixed point 2^-24.
    pub radiance: [Vec<i64>; 2],
    /// Feature samples summed per pixel (both halves together); 0 when the run
    /// lies beyond [`FEATURE_SAMPLES`].
    pub feature_samples: u32,
    /// Feature sums, `[FEATURE_CHANNELS * pixel + channel]`, fixed point; empty
    /// when `feature_samples` is 0.
    pub features: Vec<i64>,
    /// Samples that contributed nothing because they were no light.
    pub bad: BadSamples,
    /// Paths that ended at the safety cap on their depth.
    pub depth_cap_hits: u64,
    /// How the light is spread over the samples that are no bad ones.
    pub brightness: Brightness,
}

impl TileSums {
    /// Sums of no samples for `pixels` pixels, about to receive `samples` of
    /// each half.
    #[must_use]
    pub fn zero(pixels: usize, samples: &Range<u32>) -> Self {
        let feature_samples = 2 * feature_samples_of_half(samples);
        Self {
            samples_per_half: samples.end.saturating_sub(samples.start),
            radiance: [vec![0; 3 * pixels], vec![0; 3 * pixels]],
            feature_samples,
            features: if feature_samples == 0 {
                Vec::new()
            } else {
                vec![0; FEATURE_CHANNELS * pixels]
            },
            bad: BadSamples::default(),
            depth_cap_hits: 0,
            brightness: Brightness::zero(),
        }
    }

    /// Whether these sums have the shape that a run of `samples` over `rect`
    /// must have, and values that such a run can reach.
    ///
    /// # Errors
    /// Says which part does not fit.
    pub fn check(&self, rect: &TileRect, samples: &Range<u32>) -> Result<(), FilmError> {
        let expected = Self::zero(0, samples);
        let pixels = rect.pixels();
        if self.samples_per_half != expected.samples_per_half {
            return Err(FilmError::Shape("samples_per_half is not that of the run"));
        }
        if self.radiance.iter().any(|half| half.len() != 3 * pixels) {
            return Err(FilmError::Shape(
                "radiance is not 3 values per pixel of the tile",
            ));
        }
        let features = if expected.feature_samples == 0 {
            0
        } else {
            FEATURE_CHANNELS * pixels
        };
        if self.feature_samples != expected.feature_samples || self.features.len() != features {
            return Err(FilmError::Shape(
                "features are not those of the run's samples",
            ));
        }
        let most = i64::from(self.samples_per_half).saturating_mul(fixed::FIXED_SAMPLE_MAX);
        if self
            .radiance
            .iter()
            .flatten()
            .any(|&sum| sum < 0 || sum > most)
        {
            return Err(FilmError::Shape(
                "a radiance sum is negative or larger than its samples can reach",
            ));
        }
        let most = i64::from(self.feature_samples).saturating_mul(fixed::FIXED_SAMPLE_MAX);
        if self.features.iter().any(|&sum| sum.saturating_abs() > most) {
            return Err(FilmError::Shape(
                "a feature sum is larger than its samples can reach",
            ));
        }
        let samples = pixels as u64 * u64::from(self.samples_per_half) * 2;
        self.bad.check(samples)?;
        let light = self.radiance.iter().flatten();
        let light = light.fold(0u128, |sum, &value| sum + value as u128);
        self.brightness.check(samples - self.bad.total(), light)
    }
}

/// How many of the sample indices `samples` (of one half) carry features.
#[must_use]
pub fn feature_samples_of_half(samples: &Range<u32>) -> u32 {
    samples
        .end
        .min(FEATURE_SAMPLES)
        .saturating_sub(samples.start)
}
