//! A study: scenes and variants of them, rendered to rising numbers of samples and held
//! against references.

mod bias;
mod fit;
mod key;
mod point;
mod prepare;
mod progress;
mod reference;
mod run;
mod store;

pub use bias::{Bias, Difference, FALSE_ALARM_RATE, test_bias};
pub use fit::{Fit, Reached, fit, seconds_to};
pub use point::{Point, ReferenceError};
pub use prepare::{Load, Loaded};
pub use progress::Told;
pub use run::run_study;
pub use store::{Store, StoreError};

use crate::picture::Picture;
use crate::variants::Variant;
use serde::Serialize;

/// Most numbers of samples in one study.
pub const COUNTS_MAX: usize = 16;
/// Most seeds of one study.
pub const SEEDS_MAX: u32 = 1000;
/// Samples of a reference for each sample of the largest number that is measured: its
/// own error is then 1.6 % of the smallest that is measured.
pub const REFERENCE_FACTOR: u32 = 64;

/// One scene to be studied.
#[derive(Clone, Debug)]
pub struct SceneFile {
    /// As the user named it.
    pub file: String,
    /// Bytes of scene.json.
    pub bytes: Vec<u8>,
}

/// What is to be measured.
#[derive(Clone, Debug)]
pub struct Options {
    /// Scenes, in the order of the report.
    pub scenes: Vec<SceneFile>,
    /// Variants of each.
    pub variants: Vec<Variant>,
    /// Name of the variant that others are compared with.
    pub baseline: String,
    /// Size of the pictures [default: the scene's].
    pub size: Option<(u32, u32)>,
    /// Numbers of samples per pixel: even, rising.
    pub counts: Vec<u32>,
    /// Seeds 0 to this are measured and averaged.
    pub seeds: u32,
    /// Threads of variants that do not name any.
    pub threads: u16,
    /// Samples per pixel of references: even.
    pub reference_spp: u32,
    /// A reference of one's own, with its name.
    pub reference: Option<(String, Picture)>,
}

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct Study {
    /// Name of the build's arithmetic.
    pub build: String,
    /// Baseline of the comparisons.
    pub baseline: String,
    /// Seeds that were averaged.
    pub seeds: u32,
    /// One for each scene.
    pub scenes: Vec<SceneStudy>,
    /// Samples that this run has rendered; 0 when all was there.
    pub rendered_samples: u64,
}

/// What was found about one scene.
#[derive(Clone, Debug, Serialize)]
pub struct SceneStudy {
    /// The scene's name.
    pub name: String,
    /// The file as the user named it.
    pub file: String,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The reference as a PNG file.
    #[serde(skip)]
    pub reference_png: Vec<u8>,
    /// What the reference is; `None` when it could not be made.
    pub reference: Option<ReferenceError>,
    /// In the order of the list.
    pub variants: Vec<VariantStudy>,
}

/// What was found about one variant of one scene.
#[derive(Clone, Debug, Serialize)]
pub struct VariantStudy {
    /// The variant.
    pub variant: Variant,
    /// Threads that rendered it.
    pub threads: u16,
    /// One for each number of samples, rising; the mean over seeds.
    pub points: Vec<Point>,
    /// The test of the last point; `None` without points.
    pub bias: Option<Bias>,
    /// Its own reference, if it has one.
    pub own_reference: Option<ReferenceError>,
    /// Variance and its squares that the reference adds to the bias test.
    #[serde(skip)]
    pub(crate) reference_scatter: (f64, f64),
    /// The picture of the most samples and its FLIP map, as PNG files.
    #[serde(skip)]
    pub pictures: Option<(Vec<u8>, Vec<u8>)>,
    /// Why it could not be rendered.
    pub failure: Option<String>,
}

impl VariantStudy {
    /// Seconds and one of the errors, of each point.
    #[must_use]
    pub fn curve(&self, error: fn(&Point) -> Option<f64>) -> Vec<(f64, f64)> {
        let pair = |point: &Point| Some((point.core_s, error(point)?));
        self.points.iter().filter_map(pair).collect()
    }

    /// Efficiency 1 / (MSE x core seconds): the geometric mean over the numbers of
    /// samples; `None` when an error is 0.
    #[must_use]
    pub fn efficiency(&self, error: fn(&Point) -> f64) -> Option<f64> {
        let n = self.points.len() as f64;
        let logs = self.points.iter().map(|point| {
            let cost = error(point) * point.core_s;
            (cost > 0.0).then(|| libm::log(cost))
        });
        let sum: f64 = logs.collect::<Option<Vec<f64>>>()?.iter().sum();
        (n > 0.0).then(|| libm::exp(-sum / n))
    }
}

/// Why a study ends early.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// Somebody asked for it.
    #[error("interrupted")]
    Cancelled,
    /// A file could not be written.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A scene cannot be rendered at all.
    #[error("{0}")]
    Scene(String),
}

#[cfg(test)]
mod tests;
