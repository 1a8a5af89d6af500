//! Linear light as a small picture for a page. Not the view of the coordinator: one
//! exposure for all pictures of a scene, so that they can be compared.

use crate::flip::tone;
use crate::heat::png;
use crate::picture::srgb_of_linear;

/// What the median luminance is shown as, before the curve.
const MIDDLE_GREY: f32 = 0.35;

/// The factor that shows the median of a picture as middle grey; 1 for a black one.
pub(crate) fn exposure_of(rgb: &[[f32; 3]]) -> f32 {
    let mut luminances: Vec<f32> = rgb
        .iter()
        .map(|[r, g, b]| 0.2126 * r + 0.7152 * g + 0.0722 * b)
        .collect();
    if luminances.is_empty() {
        return 1.0;
    }
    let middle = luminances.len() / 2;
    let (_, median, _) = luminances.select_nth_unstable_by(middle, f32::total_cmp);
    if *median > 0.0 {
        MIDDLE_GREY / *median
    } else {
        1.0
    }
}

/// With the ACES curve, as a PNG file.
///
/// # Errors
/// The encoder's.
pub(crate) fn shown_png(
    width: usize,
    rgb: &[[f32; 3]],
    exposure: f32,
) -> Result<Vec<u8>, image::ImageError> {
    let shown = |v: f32| (srgb_of_linear(tone(v * exposure)) * 255.0 + 0.5) as u8;
    png(width, rgb.iter().map(|pixel| pixel.map(shown)))
}
