//! Bloom: light that spreads around what is brighter than a threshold.
//!
//! `B = I + strength * K * E`, `E = max(I - threshold, 0)`, for each channel by
//! itself (a sun near the horizon glows orange), with K a box filter of
//! half-width `round(radius * height)` pixels.
//!
//! Two rules that cannot both be had any other way, so they are stated:
//!
//! - **Border**: the picture continues with its edge values. A constant picture
//!   therefore stays constant up to and including its borders; a bright spot
//!   nearer to the border than the filter's reach gains or loses energy there.
//! - **Energy**: the formula adds `strength * sum(E)`; it does not take the
//!   glow away from where it came from.
//!
//! With several passes the half-width of each box is chosen so that the
//! variance of the whole filter stays that of the single box:
//! `passes * r (r + 1) = R (R + 1)` for half-widths r and R.

use rayon::prelude::*;

use super::box_filter::{box_rows, transpose};
use super::error::DevelopError;
use super::picture::{check_len, check_size};
use super::settings::Bloom;

/// A picture with its glow.
#[derive(Clone, Debug, PartialEq)]
pub struct Bloomed {
    /// Linear values, in the layout of the input. Finite where it was finite.
    pub rgb: Vec<[f32; 3]>,
    /// Values of the input that were NaN or infinite. They are passed on
    /// unchanged and take no part in the glow.
    pub non_finite_values: u64,
}

/// Adds the glow to linear `beauty`, row-major, `width * height` pixels.
///
/// Without bloom, with strength 0, with an infinite threshold and with nothing
/// above the threshold the output is the input, bit for bit.
///
/// # Errors
/// Size, length and settings are checked as [`DevelopError`] says.
pub fn apply_bloom(
    beauty: &[[f32; 3]],
    width: u32,
    height: u32,
    bloom: Option<&Bloom>,
) -> Result<Bloomed, DevelopError> {
    check_len("beauty", beauty.len(), check_size(width, height)?)?;
    let mut rgb = beauty.to_vec();
    if let Some(bloom) = bloom {
        bloom.check()?;
        if bloom.strength > 0.0 && bloom.threshold < f32::INFINITY {
            for channel in 0..3 {
                add_glow(&mut rgb, channel, width, height, bloom);
            }
        }
    }
    Ok(Bloomed {
        rgb,
        non_finite_values: count_non_finite(beauty),
    })
}

fn add_glow(rgb: &mut [[f32; 3]], channel: usize, width: u32, height: u32, bloom: &Bloom) {
    let threshold = f64::from(bloom.threshold);
    let mut glow: Vec<f64> = rgb
        .par_iter()
        .map(|pixel| excess(pixel[channel], threshold))
        .collect();
    if glow.iter().all(|&value| value == 0.0) {
        return;
    }
    let radius = pass_radius_px(bloom, height);
    if radius > 0 {
        let (width, height) = (width as usize, height as usize);
        for _ in 0..bloom.passes {
            box_rows(&mut glow, width, radius);
        }
        let mut columns = transpose(&glow, width);
        for _ in 0..bloom.passes {
            box_rows(&mut columns, height, radius);
        }
        glow = transpose(&columns, height);
    }
    let strength = f64::from(bloom.strength);
    rgb.par_iter_mut().zip(&glow).for_each(|(pixel, &glow)| {
        let value = &mut pixel[channel];
        // Where no glow arrives the bits stay, also those of -0.
        if value.is_finite() && glow > 0.0 {
            let sum = f64::from(*value) + strength * glow;
            *value = sum.min(f64::from(f32::MAX)) as f32;
        }
    });
}

/// `max(value - threshold, 0)`; zero for NaN and both infinities.
fn excess(value: f32, threshold: f64) -> f64 {
    if value.is_finite() {
        (f64::from(value) - threshold).max(0.0)
    } else {
        0.0
    }
}

/// Half-width in pixels of each pass's box.
fn pass_radius_px(bloom: &Bloom, height: u32) -> usize {
    let single_px = f64::from(bloom.radius) * f64::from(height);
    let radius_px = if bloom.passes <= 1 {
        single_px
    } else {
        let product = single_px * (single_px + 1.0) / f64::from(bloom.passes);
        (libm::sqrt(1.0 + 4.0 * product) - 1.0) / 2.0
    };
    // Never negative, so this rounds to nearest, halves up.
    (radius_px + 0.5) as usize
}

fn count_non_finite(beauty: &[[f32; 3]]) -> u64 {
    beauty
        .par_iter()
        .map(|pixel| pixel.iter().filter(|value| !value.is_finite()).count() as u64)
        .sum()
}
