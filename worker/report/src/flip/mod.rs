//! FLIP: how much a person who flips between two pictures notices.
//!
//! Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom, Fairchild: "FLIP: A
//! Difference Evaluator for Alternating Images", HPG 2020, for pictures of 0 to 1;
//! Andersson, Nilsson, Shirley, Akenine-Moller: "Visualizing Errors in Rendered High
//! Dynamic Range Images", Eurographics 2021, for radiance. Filters are applied one
//! axis after the other, as in the authors' program; its results are the test.

mod colour;
mod feature;
mod hdr;
mod ldr;
mod separable;
mod spatial;

pub(crate) use hdr::tone;
pub use hdr::{Exposures, HdrFlip, hdr_flip};
pub use ldr::ldr_flip;

/// Pixels per degree of sight: a screen of 3840 pixels and 0.7 m, from 0.7 m. The
/// default of the authors' program.
pub const PIXELS_PER_DEGREE: f32 = 67.020_645;

/// A plane of pixels, row by row.
#[derive(Clone, Copy, Debug)]
pub struct Plane<'a> {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// RGB, linear.
    pub rgb: &'a [[f32; 3]],
}

/// Mean of an error map, 0 (equal) to 1; in order, in `f64`.
#[must_use]
pub fn mean(map: &[f32]) -> f64 {
    let sum: f64 = map.iter().map(|&error| f64::from(error)).sum();
    sum / map.len().max(1) as f64
}

#[cfg(test)]
mod tests;
