//! What the coordinator stored before histograms of brightness: version 1.
//! Read, never written.

use crate::film::{BadSamples, Brightness, TileFilm, TileSums};
use serde::Deserialize;

/// [`TileSums`] of version 1.
#[derive(Deserialize)]
pub(super) struct TileSums1 {
    samples_per_half: u32,
    radiance: [Vec<i64>; 2],
    feature_samples: u32,
    features: Vec<i64>,
    bad: BadSamples,
    depth_cap_hits: u64,
}

impl From<TileSums1> for TileSums {
    fn from(old: TileSums1) -> Self {
        Self {
            samples_per_half: old.samples_per_half,
            radiance: old.radiance,
            feature_samples: old.feature_samples,
            features: old.features,
            bad: old.bad,
            depth_cap_hits: old.depth_cap_hits,
            brightness: Brightness::default(),
        }
    }
}

/// [`TileFilm`] of version 1.
#[derive(Deserialize)]
pub(super) struct TileFilm1 {
    samples_per_half: u64,
    radiance: [Vec<i128>; 2],
    feature_samples: u64,
    features: Vec<i128>,
    bad: BadSamples,
    depth_cap_hits: u64,
}

impl From<TileFilm1> for TileFilm {
    fn from(old: TileFilm1) -> Self {
        Self {
            samples_per_half: old.samples_per_half,
            radiance: old.radiance,
            feature_samples: old.feature_samples,
            features: old.features,
            bad: old.bad,
            depth_cap_hits: old.depth_cap_hits,
            brightness: Brightness::default(),
        }
    }
}
