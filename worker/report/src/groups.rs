//! Is what ended early right on average? An adaptive picture by its numbers of samples.
//!
//! A tile that ends early because its own estimate of its error was low by chance is a
//! bias that no picture as a whole shows. So the pixels of each number of samples are
//! compared by themselves. Pixels are sampled independently of each other, so the
//! variance of a mean over n pixels is the scatter of their differences over n; the
//! noise of the reference is in that scatter.

use crate::metrics::{RELATIVE_EPSILON, Z_95, metrics};
use crate::picture::Picture;
use crate::student::student;
use serde::Serialize;
use shearwater_shared::limits::TILE_SIDE;
use std::collections::{BTreeMap, BTreeSet};

/// Most groups: of more different numbers of samples, those from one power of two up to
/// the next are one group, and 32 bits have no more than that.
pub const GROUPS_MAX: usize = 33;
/// Pixels to each side whose light weighs a pixel, itself left out.
const AROUND: usize = 2;

/// A mean over pixels with its scatter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Mean {
    /// The mean.
    pub mean: f64,
    /// Its standard error, the noise of both pictures together.
    pub standard_error: f64,
    /// `mean` over `standard_error`; 0 where both are.
    pub z: f64,
    /// Half of the 95 % interval: Student's t with `effective_pixels`.
    pub interval_95: f64,
    /// Pixels that the scatter effectively comes from. With few (single bright pixels)
    /// it is itself uncertain, and bright samples may be missing on either side.
    pub effective_pixels: f64,
}

/// What the pixels of one number of samples have in common.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Group {
    /// Fewest samples of its pixels.
    pub samples_min: u32,
    /// Most; the same, unless there are more than [`GROUPS_MAX`] different numbers.
    pub samples_max: u32,
    /// How many pixels.
    pub pixels: usize,
    /// Tiles of the farm (64 x 64 pixels) that they lie in.
    pub tiles: usize,
    /// Mean squared error against the reference.
    pub mse: f64,
    /// Relative mean squared error against the reference.
    pub rel_mse: f64,
    /// What the noise of the reference adds to `rel_mse`, where it tells.
    pub reference_rel_mse: Option<f64>,
    /// Mean of x - r.
    pub difference: Mean,
    /// Mean of (x - r) / (l + 0.1), l the reference's light around the pixel without the
    /// pixel: a weight that knows the error of what it weighs would be a bias itself.
    pub relative_difference: Mean,
}

/// The groups of an adaptive picture, by rising number of samples. Empty without
/// [`sample_count`](crate::picture::Planes::sample_count), with one number for all
/// pixels, and for pictures of different sizes.
#[must_use]
pub fn groups(picture: &Picture, reference: &Picture) -> Vec<Group> {
    let Some(counts) = &picture.planes.sample_count else {
        return Vec::new();
    };
    let size = (picture.width, picture.height);
    let fit = size == (reference.width, reference.height) && counts.len() == picture.rgb.len();
    let members = members(counts);
    if !fit || members.len() < 2 {
        return Vec::new();
    }
    let of_group = |pixels: &Vec<usize>| group(pixels, counts, picture, reference);
    members.values().map(of_group).collect()
}

/// What the noise of a picture adds to its relative error as a reference: the mean over
/// pixels and channels of its variance / (r^2 + 0.01). `None` where it does not tell.
#[must_use]
pub fn own_rel_mse(reference: &Picture) -> Option<f64> {
    own_rel_mse_of(reference, 0..reference.rgb.len())
}

fn own_rel_mse_of(
    reference: &Picture,
    pixels: impl ExactSizeIterator<Item = usize>,
) -> Option<f64> {
    let variance = reference.planes.variance.as_ref()?;
    let values = 3.0 * pixels.len().max(1) as f64;
    let mut sum = 0.0;
    for at in pixels {
        for (v, r) in variance.get(at)?.iter().zip(reference.rgb.get(at)?) {
            let r = f64::from(*r);
            sum += f64::from(*v) / (r * r + RELATIVE_EPSILON);
        }
    }
    Some(sum / values)
}

/// Pixels by number of samples, or by its power of two.
fn members(counts: &[u32]) -> BTreeMap<u32, Vec<usize>> {
    let different: BTreeSet<u32> = counts.iter().copied().collect();
    let few = different.len() <= GROUPS_MAX;
    let mut members: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (at, &count) in counts.iter().enumerate() {
        let name = if few {
            count
        } else {
            u32::BITS - count.leading_zeros()
        };
        members.entry(name).or_default().push(at);
    }
    members
}

fn group(pixels: &[usize], counts: &[u32], picture: &Picture, reference: &Picture) -> Group {
    let gather = |of: &Picture| -> Vec<[f32; 3]> { pixels.iter().map(|&at| of.rgb[at]).collect() };
    let (x, r) = (gather(picture), gather(reference));
    let errors = metrics(&x, &r);
    let differences: Vec<f64> = x.iter().zip(&r).map(|(x, r)| grey(x) - grey(r)).collect();
    let relative: Vec<f64> = differences
        .iter()
        .zip(pixels)
        .map(|(d, &at)| d / (light_around(reference, at) + RELATIVE_EPSILON.sqrt()))
        .collect();
    let side = TILE_SIDE as usize;
    let tile = |&at: &usize| (at % picture.width / side, at / picture.width / side);
    let samples = || pixels.iter().map(|&at| counts[at]);
    Group {
        samples_min: samples().min().unwrap_or(0),
        samples_max: samples().max().unwrap_or(0),
        pixels: pixels.len(),
        tiles: pixels.iter().map(tile).collect::<BTreeSet<_>>().len(),
        mse: errors.mse,
        rel_mse: errors.rel_mse,
        reference_rel_mse: own_rel_mse_of(reference, pixels.iter().copied()),
        difference: mean(&differences),
        relative_difference: mean(&relative),
    }
}

fn grey(rgb: &[f32; 3]) -> f64 {
    rgb.iter().map(|&v| f64::from(v)).sum::<f64>() / 3.0
}

/// Mean of the reference around pixel `at` without it; of a picture of one pixel, 0.
fn light_around(reference: &Picture, at: usize) -> f64 {
    let (width, height) = (reference.width, reference.height);
    let (x, y) = (at % width, at / width);
    let (mut sum, mut number) = (0.0, 0.0);
    for row in y.saturating_sub(AROUND)..(y + AROUND + 1).min(height) {
        for column in x.saturating_sub(AROUND)..(x + AROUND + 1).min(width) {
            if (column, row) != (x, y) {
                sum += grey(&reference.rgb[row * width + column]);
                number += 1.0;
            }
        }
    }
    (sum / f64::max(number, 1.0)).max(0.0)
}

fn mean(values: &[f64]) -> Mean {
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    let (mut second, mut fourth) = (0.0, 0.0);
    for value in values {
        let square = (value - mean) * (value - mean);
        second += square;
        fourth += square * square;
    }
    let standard_error = (second / (n - 1.0).max(1.0) / n).sqrt();
    // Satterthwaite (1946), as in the report's bias test: a third of the pixels where
    // their differences are normal and alike, one where a single pixel rules.
    let effective_pixels = if fourth > 0.0 {
        (second * second / fourth).max(1.0)
    } else {
        n
    };
    Mean {
        mean,
        standard_error,
        z: if mean == 0.0 {
            0.0
        } else {
            mean / standard_error
        },
        interval_95: student(Z_95, effective_pixels) * standard_error,
        effective_pixels,
    }
}

#[cfg(test)]
#[path = "groups_tests.rs"]
mod tests;
