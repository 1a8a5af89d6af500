//! One measurement: a scene, a variant, a number of samples.

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
    /// Variance of `mean_difference`, from the halves of both.
    pub mean_variance: f64,
    /// Samples that were no light.
    pub bad: u64,
}

/// What everything is held against.
#[derive(Clone, Debug)]
pub(super) struct Reference {
    /// The picture.
    pub rgb: Vec<[f32; 3]>,
    /// Variance of its mean over pixels and channels; 0 where nobody knows it.
    pub mean_variance: f64,
    /// Where it comes from, and how wrong it is itself.
    pub about: ReferenceError,
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

/// Variance of the mean over pixels and channels, and mean squared error, of a picture
/// whose halves differ by twice `half_difference`.
pub(super) fn own_errors(half_difference: &[[f64; 3]], rgb: &[[f32; 3]]) -> (f64, f64, f64) {
    let (mut variance, mut mse, mut rel_mse) = (0.0, 0.0, 0.0);
    for (d, r) in half_difference.iter().zip(rgb) {
        let mean = (d[0] + d[1] + d[2]) / 3.0;
        variance += mean * mean;
        for c in 0..3 {
            let r = f64::from(r[c]);
            mse += d[c] * d[c];
            rel_mse += d[c] * d[c] / (r * r + crate::metrics::RELATIVE_EPSILON);
        }
    }
    let n = half_difference.len().max(1) as f64;
    (variance / (n * n), mse / (3.0 * n), rel_mse / (3.0 * n))
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
    let (variance, own_mse, _) = own_errors(&sums.half_difference(), &picture);
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
        mean_variance: variance + reference.mean_variance,
        bad: sums.bad,
    };
    (point, flip.map(|flip| flip.map))
}

/// The mean of one number of samples over seeds; `None` without any.
pub(super) fn averaged(points: &[Point], reference_variance: f64) -> Option<Point> {
    let n = points.len() as f64;
    let first = points.first()?;
    let mean = |value: fn(&Point) -> f64| points.iter().map(value).sum::<f64>() / n;
    // The reference is the same for all seeds: its share does not average out.
    let own = points
        .iter()
        .map(|p| (p.mean_variance - reference_variance).max(0.0))
        .sum::<f64>();
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
        mean_variance: own / (n * n) + reference_variance,
        bad: points.iter().map(|p| p.bad).sum(),
    })
}
