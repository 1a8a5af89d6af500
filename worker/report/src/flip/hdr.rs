//! FLIP of radiance: the largest error over a range of exposures.

use super::Plane;
use super::ldr::ldr_flip;
use super::separable::map_pixels;
use serde::{Deserialize, Serialize};

/// Share of white to which the tone curve takes the brightest pixel at the first
/// exposure and the median at the last (2021, section 4).
const WHITE_SHARE: f32 = 0.85;
/// Most exposures: the range of `f32` in stops.
const EXPOSURES_MAX: usize = 300;
/// The median luminance where more than half of the picture is black; the authors'
/// program takes the same since version 1.7.
const MEDIAN_MIN: f32 = f32::EPSILON;

/// Narkowicz, "ACES Filmic Tone Mapping Curve", 2015, with the exposure of 0.6 that
/// ACES brings: (n2 x^2 + n1 x) / (d2 x^2 + d1 x + d0).
const N2: f32 = 0.6 * 0.6 * 2.51;
const N1: f32 = 0.6 * 0.03;
const D2: f32 = 0.6 * 0.6 * 2.43;
const D1: f32 = 0.6 * 0.59;
const D0: f32 = 0.14;

/// Exposures that were looked at, in stops.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Exposures {
    /// The lowest.
    pub start: f32,
    /// The highest.
    pub stop: f32,
    /// How many, evenly spaced.
    pub count: usize,
}

/// What HDR-FLIP finds.
#[derive(Clone, Debug, PartialEq)]
pub struct HdrFlip {
    /// Error of each pixel, 0 to 1.
    pub map: Vec<f32>,
    /// The exposures, chosen by the reference alone.
    pub exposures: Exposures,
}

/// Error of linear pictures of any range; negative values count as black. `None` for a
/// black reference, which has no exposure, and for pictures of different size.
#[must_use]
pub fn hdr_flip(picture: &Plane<'_>, reference: &Plane<'_>, ppd: f32) -> Option<HdrFlip> {
    let exposures = exposures(reference)?;
    let mut map = vec![0.0f32; reference.rgb.len()];
    let step = (exposures.stop - exposures.start) / (exposures.count - 1) as f32;
    for index in 0..exposures.count {
        let factor = libm::exp2f(exposures.start + index as f32 * step);
        let shown = |plane: &Plane<'_>| map_pixels(plane, |rgb| rgb.map(|v| tone(v * factor)));
        let (a, b) = (shown(picture), shown(reference));
        let plane = |rgb| Plane { rgb, ..*reference };
        let test = Plane {
            rgb: &a,
            ..*picture
        };
        let errors = ldr_flip(&test, &plane(&b), ppd);
        if errors.len() != map.len() {
            return None;
        }
        for (most, error) in map.iter_mut().zip(errors) {
            *most = most.max(error);
        }
    }
    Some(HdrFlip { map, exposures })
}

/// The ACES curve; 0 to 1.
pub(crate) fn tone(x: f32) -> f32 {
    // Beyond, both squares overflow; the curve has long been flat.
    let x = x.clamp(0.0, 1e15);
    ((N2 * x + N1) * x / ((D2 * x + D1) * x + D0)).clamp(0.0, 1.0)
}

/// From the exposure that shows the brightest pixel to the one that shows the median.
fn exposures(reference: &Plane<'_>) -> Option<Exposures> {
    let luminance =
        |rgb: &[f32; 3]| (0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]).min(f32::MAX);
    let mut luminances: Vec<f32> = reference.rgb.iter().map(luminance).collect();
    let middle = luminances.len() / 2;
    let brightest = luminances.iter().copied().fold(0.0, f32::max);
    if brightest <= 0.0 {
        return None;
    }
    let (_, median, _) = luminances.select_nth_unstable_by(middle, f32::total_cmp);
    // The x that the curve takes to the share of white: its positive root.
    let (a, b, c) = (
        N2 - WHITE_SHARE * D2,
        N1 - WHITE_SHARE * D1,
        -WHITE_SHARE * D0,
    );
    let half = -0.5 * b / a;
    let x = half + (half * half - c / a).sqrt();
    let start = libm::log2f(x / brightest);
    let stop = libm::log2f(x / median.max(MEDIAN_MIN)).max(start);
    let count = ((stop - start).ceil() as usize).clamp(2, EXPOSURES_MAX);
    Some(Exposures { start, stop, count })
}
