//! FLIP of pictures of 0 to 1.

use super::Plane;
use super::colour::{hunt_lab_of_linear, hyab, linear_of_ycxcz, ycxcz_of_linear};
use super::feature::FeatureFilter;
use super::separable::map_pixels;
use super::spatial::SpatialFilter;
use rayon::prelude::*;

/// Exponent of the colour difference (2020, section 4.1).
const COLOUR_POWER: f32 = 0.7;
/// Share of the largest colour difference that is mapped to [`KNEE_TO`].
const KNEE_FROM: f32 = 0.4;
/// See [`KNEE_FROM`].
const KNEE_TO: f32 = 0.95;

/// Error of each pixel, 0 to 1. Both pictures are linear, 0 to 1 (clamped here), and
/// equally large; `ppd` are the pixels per degree of sight. Empty when they differ in
/// size.
#[must_use]
pub fn ldr_flip(picture: &Plane<'_>, reference: &Plane<'_>, ppd: f32) -> Vec<f32> {
    let size = (reference.width, reference.height);
    let pixels = size.0 * size.1;
    if size != (picture.width, picture.height)
        || picture.rgb.len() != pixels
        || reference.rgb.len() != pixels
    {
        return Vec::new();
    }
    let opponent = |plane: &Plane<'_>| {
        map_pixels(plane, |rgb| ycxcz_of_linear(rgb.map(|v| v.clamp(0.0, 1.0))))
    };
    let (picture, reference) = (opponent(picture), opponent(reference));
    let spatial = SpatialFilter::new(ppd);
    let perceived = |ycxcz: &[[f32; 3]]| -> Vec<[f32; 3]> {
        let seen = |v| hunt_lab_of_linear(linear_of_ycxcz(v).map(|v| v.clamp(0.0, 1.0)));
        let blurred = spatial.apply(size, ycxcz);
        blurred.into_par_iter().map(seen).collect()
    };
    let feature = FeatureFilter::new(ppd);
    let (a, b) = (perceived(&picture), perceived(&reference));
    let (fa, fb) = (
        feature.apply(size, &picture),
        feature.apply(size, &reference),
    );
    let largest = largest_difference();
    (0..pixels)
        .into_par_iter()
        .map(|p| {
            let colour = remapped(libm::powf(hyab(a[p], b[p]), COLOUR_POWER), largest);
            let edge = (fa[p].edge - fb[p].edge).abs();
            let point = (fa[p].point - fb[p].point).abs();
            let feature = (edge.max(point) * std::f32::consts::FRAC_1_SQRT_2).sqrt();
            libm::powf(colour, 1.0 - feature)
        })
        .collect()
}

/// The largest difference that there is, between green and blue.
fn largest_difference() -> f32 {
    let green = hunt_lab_of_linear([0.0, 1.0, 0.0]);
    let blue = hunt_lab_of_linear([0.0, 0.0, 1.0]);
    libm::powf(hyab(green, blue), COLOUR_POWER)
}

fn remapped(difference: f32, largest: f32) -> f32 {
    let knee = KNEE_FROM * largest;
    if difference < knee {
        difference * KNEE_TO / knee
    } else {
        KNEE_TO + (difference - knee) / (largest - knee) * (1.0 - KNEE_TO)
    }
}
