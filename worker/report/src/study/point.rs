//! One measurement: a scene, a variant, a number of samples.

use super::bias::{Difference, Held};
use crate::flip::{PIXELS_PER_DEGREE, Plane, hdr_flip, mean};
use crate::measure::{FrameSums, Spent};
use crate::metrics::metrics;
use serde::{Deserialize, Serialize};

/// Speed and error at one number of samples. Times are those of all samples from the
/// first on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Samples per pixel.
    pub spp: u32,
    /// Time on cores, over all render threads, in seconds.
    pub core_s: f64,
    /// Time on the clock, in seconds.
    pub wall_s: f64,
    /// Mean squared error against the reference.
    pub mse: f64,
    /// Relative mean squared error against the reference.
    pub rel_mse: f64,
    /// Mean FLIP over exposures; `None` for a black reference.
    pub flip_hdr: Option<f64>,
    /// Mean squared error that the two halves of the picture estimate by themselves.
    pub own_mse: f64,
    /// Mean of picture - reference.
    pub mean_difference: f64,
    /// The weighted mean difference that the bias test looks at.
    pub weighted: Difference,
    /// Samples that were no light.
    pub bad: u64,
}

/// What everything is held against.
#[derive(Clone, Debug)]
pub(super) struct Reference {
    /// The picture.
    pub(super) rgb: Vec<[f32; 3]>,
    /// Its side of the bias test.
    pub(super) held: Held,
    /// Where it comes from, and how wrong it is itself.
    pub(super) about: ReferenceError,
    /// Names it in keys.
    pub(super) key: String,
}

/// How good a reference is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReferenceError {
    /// Samples per pixel; `None` for a file.
    pub spp: Option<u32>,
    /// The file.
    pub file: Option<String>,
    /// Its own mean squared error, from its halves; `None` for a file.
    pub mse: Option<f64>,
    /// Its own relative mean squared error.
    pub rel_mse: Option<f64>,
}

/// Mean squared error and relative mean squared error of a picture whose halves differ
/// by twice `half_difference`.
pub(super) fn own_errors(half_difference: &[[f64; 3]], rgb: &[[f32; 3]]) -> (f64, f64) {
    let (mut mse, mut rel_mse) = (0.0, 0.0);
    for (d, r) in half_difference.iter().zip(rgb) {
        for c in 0..3 {
            let r = f64::from(r[c]);
            mse += d[c] * d[c];
            rel_mse += d[c] * d[c] / (r * r + crate::metrics::RELATIVE_EPSILON);
        }
    }
    let values = 3.0 * half_difference.len().max(1) as f64;
    (mse / values, rel_mse / values)
}

/// Measure what `sums` show; also the FLIP map.
pub(super) fn measure(
    sums: &FrameSums,
    spent: Spent,
    reference: &Reference,
) -> (Point, Option<Vec<f32>>) {
    let picture = sums.mean();
    let plane = |rgb| Plane {
        width: sums.width as usize,
        height: sums.height as usize,
        rgb,
    };
    let found = metrics(&picture, &reference.rgb);
    let (own_mse, _) = own_errors(&sums.half_difference(), &picture);
    let flip = hdr_flip(&plane(&picture), &plane(&reference.rgb), PIXELS_PER_DEGREE);
    let point = Point {
        spp: 2 * sums.samples_per_half,
        core_s: spent.core_s,
        wall_s: spent.wall_s,
        mse: found.mse,
        rel_mse: found.rel_mse,
        flip_hdr: flip.as_ref().map(|flip| mean(&flip.map)),
        own_mse,
        mean_difference: found.mean_difference,
        weighted: reference.held.difference(sums),
        bad: sums.bad,
    };
    (point, flip.map(|flip| flip.map))
}

/// The mean of one number of samples over seeds; `None` without any.
pub(super) fn averaged(points: &[Point]) -> Option<Point> {
    let n = points.len() as f64;
    let first = points.first()?;
    let mean = |value: fn(&Point) -> f64| points.iter().map(value).sum::<f64>() / n;
    let flips: Option<Vec<f64>> = points.iter().map(|p| p.flip_hdr).collect();
    Some(Point {
        spp: first.spp,
        core_s: mean(|p| p.core_s),
        wall_s: mean(|p| p.wall_s),
        mse: mean(|p| p.mse),
        rel_mse: mean(|p| p.rel_mse),
        flip_hdr: flips.map(|flips| flips.iter().sum::<f64>() / n),
        own_mse: mean(|p| p.own_mse),
        mean_difference: mean(|p| p.mean_difference),
        weighted: Difference {
            mean: mean(|p| p.weighted.mean),
            variance: mean(|p| p.weighted.variance) / n,
            fourth: mean(|p| p.weighted.fourth) / (n * n * n),
        },
        bad: points.iter().map(|p| p.bad).sum(),
    })
}
