//! One picture against another.

use crate::flip::{Exposures, PIXELS_PER_DEGREE, Plane, hdr_flip, ldr_flip, mean};
use crate::heat::{heat_png, logarithmic};
use crate::metrics::{Metrics, RELATIVE_EPSILON, metrics, psnr_db, rel_mse_trimmed};
use crate::picture::{Picture, Range};
use serde::Serialize;

/// Exponent of ten where the heat map of relative errors begins; it ends at 0.
pub const HEAT_DARKEST: f32 = -6.0;

/// Why two pictures cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    /// They differ in size.
    #[error("the pictures differ in size: {0} and {1}; expected equal ones")]
    Size(String, String),
    /// One is EXR, the other PNG.
    #[error(
        "one picture is EXR (linear light), the other PNG (what a screen shows): \
         expected two of one kind"
    )]
    Kind,
    /// A heat map could not be encoded.
    #[error("difference picture: {0}")]
    Png(#[from] image::ImageError),
}

/// What a comparison finds. Errors are those of the first picture, the second is the
/// reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Errors of linear radiance (EXR), or of display values 0 to 1 (PNG).
    #[serde(flatten)]
    pub metrics: Metrics,
    /// `rel_mse` without the worst thousandth of the pixels.
    pub rel_mse_trimmed: f64,
    /// Peak signal to noise ratio in dB of both as a screen shows them: linear light
    /// clamped to 0..1, sRGB, peak 1. `None` when they are equal there.
    pub psnr_db: Option<f64>,
    /// Mean FLIP of both clamped to 0..1.
    pub flip_ldr: f64,
    /// Mean FLIP over exposures; `None` for PNG and for a black reference.
    pub flip_hdr: Option<f64>,
    /// The exposures of `flip_hdr`, in stops.
    pub exposures: Option<Exposures>,
    /// Pixels per degree of sight that FLIP was asked for.
    pub pixels_per_degree: f32,
}

/// Pictures of the difference, as PNG files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DifferencePictures {
    /// Per pixel, log10 of the mean over channels of (x - r)^2 / (r^2 + 0.01), black at
    /// 10^[`HEAT_DARKEST`], pale yellow at 1; for PNG without the division.
    pub difference: Vec<u8>,
    /// FLIP of the clamped pictures, 0 black to 1 pale yellow.
    pub flip_ldr: Vec<u8>,
    /// FLIP over exposures, likewise; `None` where it is not defined.
    pub flip_hdr: Option<Vec<u8>>,
}

/// Compare `picture` with `reference`.
///
/// # Errors
/// [`CompareError`]: they do not fit together.
pub fn compare(
    picture: &Picture,
    reference: &Picture,
) -> Result<(Comparison, DifferencePictures), CompareError> {
    if (picture.width, picture.height) != (reference.width, reference.height) {
        return Err(CompareError::Size(picture.size(), reference.size()));
    }
    if picture.range != reference.range {
        return Err(CompareError::Kind);
    }
    let size @ (width, height) = (reference.width, reference.height);
    let displayed = metrics(&picture.displayed(), &reference.displayed());
    let (emitted, emitted_reference) = (picture.emitted(), reference.emitted());
    let ldr = ldr_flip(
        &plane(size, &emitted),
        &plane(size, &emitted_reference),
        PIXELS_PER_DEGREE,
    );
    let linear = reference.range == Range::Linear;
    let hdr = linear
        .then(|| {
            hdr_flip(
                &plane(size, &picture.rgb),
                &plane(size, &reference.rgb),
                PIXELS_PER_DEGREE,
            )
        })
        .flatten();
    let comparison = Comparison {
        width,
        height,
        metrics: metrics(&picture.rgb, &reference.rgb),
        rel_mse_trimmed: rel_mse_trimmed(&picture.rgb, &reference.rgb),
        psnr_db: psnr_db(displayed.mse),
        flip_ldr: mean(&ldr),
        flip_hdr: hdr.as_ref().map(|hdr| mean(&hdr.map)),
        exposures: hdr.as_ref().map(|hdr| hdr.exposures),
        pixels_per_degree: PIXELS_PER_DEGREE,
    };
    let heat = if linear {
        logarithmic(
            &picture.rgb,
            &reference.rgb,
            RELATIVE_EPSILON as f32,
            HEAT_DARKEST,
        )
    } else {
        absolute(&picture.rgb, &reference.rgb)
    };
    let pictures = DifferencePictures {
        difference: heat_png(width, &heat)?,
        flip_ldr: heat_png(width, &ldr)?,
        flip_hdr: hdr.map(|hdr| heat_png(width, &hdr.map)).transpose()?,
    };
    Ok((comparison, pictures))
}

const fn plane((width, height): (usize, usize), rgb: &[[f32; 3]]) -> Plane<'_> {
    Plane { width, height, rgb }
}

/// Display values are relative to the eye already.
fn absolute(picture: &[[f32; 3]], reference: &[[f32; 3]]) -> Vec<f32> {
    let relative_to_one = |rgb: &[f32; 3], r: &[f32; 3]| [0, 1, 2].map(|c| 1.0 + rgb[c] - r[c]);
    let shifted: Vec<_> = picture
        .iter()
        .zip(reference)
        .map(|(x, r)| relative_to_one(x, r))
        .collect();
    logarithmic(&shifted, &vec![[1.0; 3]; shifted.len()], 0.0, HEAT_DARKEST)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::Planes;

    fn picture(range: Range, value: f32) -> Picture {
        Picture {
            width: 8,
            height: 4,
            rgb: vec![[value; 3]; 32],
            range,
            planes: Planes::default(),
        }
    }

    #[test]
    fn a_uniform_difference() {
        let (found, pictures) = compare(&picture(Range::Linear, 0.6), &picture(Range::Linear, 0.5))
            .expect("comparable");
        assert!((found.metrics.mse - 0.01).abs() < 1e-6, "{found:?}");
        assert!((found.metrics.rel_mse - 0.01 / 0.26).abs() < 1e-6);
        // sRGB of 0.6 is 0.79774, of 0.5 is 0.73536.
        let psnr = -20.0 * libm::log10(0.797_738 - 0.735_357);
        assert!(
            (found.psnr_db.expect("differ") - psnr).abs() < 1e-2,
            "{found:?}"
        );
        assert!(found.flip_ldr > 0.0 && found.flip_hdr > Some(0.0));
        assert!(pictures.difference.starts_with(b"\x89PNG"));
    }

    #[test]
    fn png_has_no_high_dynamic_range() {
        let same = picture(Range::Display, 0.5);
        let (found, pictures) = compare(&same, &same).expect("comparable");
        assert_eq!((found.flip_hdr, found.psnr_db), (None, None));
        assert_eq!((found.flip_ldr, pictures.flip_hdr), (0.0, None));
    }

    #[test]
    fn what_does_not_fit_is_said() {
        let small = Picture {
            width: 4,
            height: 8,
            ..picture(Range::Linear, 1.0)
        };
        let text = compare(&picture(Range::Linear, 1.0), &small)
            .expect_err("size")
            .to_string();
        assert!(text.contains("8x4 and 4x8"), "{text}");
        let kind = compare(&picture(Range::Linear, 1.0), &picture(Range::Display, 1.0));
        assert!(matches!(kind, Err(CompareError::Kind)));
    }
}
