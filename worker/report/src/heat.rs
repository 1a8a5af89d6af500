//! Heat maps: numbers as colours, as PNG files.

use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};

/// Black over violet and orange to pale yellow, rising in lightness, so that it reads
/// without its colours too. sRGB.
const COLOURS: [[f32; 3]; 7] = [
    [0.00, 0.00, 0.02],
    [0.16, 0.05, 0.36],
    [0.45, 0.10, 0.48],
    [0.76, 0.21, 0.39],
    [0.95, 0.44, 0.23],
    [0.99, 0.74, 0.33],
    [1.00, 0.99, 0.82],
];

/// The colour of `value`, 0 (black) to 1 (pale yellow).
fn colour(value: f32) -> [u8; 3] {
    let at = value.clamp(0.0, 1.0) * (COLOURS.len() - 1) as f32;
    let below = (at as usize).min(COLOURS.len() - 2);
    let share = at - below as f32;
    [0, 1, 2].map(|c| {
        let mixed = COLOURS[below][c] * (1.0 - share) + COLOURS[below + 1][c] * share;
        (mixed * 255.0 + 0.5) as u8
    })
}

/// A heat map of `values` as a PNG file; `width` columns. NaN is black.
///
/// # Errors
/// The encoder's.
pub(crate) fn heat_png(width: usize, values: &[f32]) -> Result<Vec<u8>, image::ImageError> {
    png(width, values.iter().map(|&value| colour(value)))
}

/// Pixels of 8 bits as a PNG file.
///
/// # Errors
/// The encoder's.
pub(crate) fn png(
    width: usize,
    pixels: impl Iterator<Item = [u8; 3]>,
) -> Result<Vec<u8>, image::ImageError> {
    let bytes: Vec<u8> = pixels.flatten().collect();
    let height = bytes.len() / (3 * width.max(1));
    let mut file = Vec::new();
    PngEncoder::new(&mut file).write_image(
        &bytes,
        width as u32,
        height as u32,
        ExtendedColorType::Rgb8,
    )?;
    Ok(file)
}

/// Per pixel, `log10` of the mean over channels of (x - r)^2 / (r^2 + `epsilon`), from
/// `darkest` (0) to 0 (1).
pub(crate) fn logarithmic(
    picture: &[[f32; 3]],
    reference: &[[f32; 3]],
    epsilon: f32,
    darkest: f32,
) -> Vec<f32> {
    let error = |x: &[f32; 3], r: &[f32; 3]| -> f32 {
        let squared = |c: usize| {
            let d = x[c] - r[c];
            d * d / (r[c] * r[c] + epsilon)
        };
        (squared(0) + squared(1) + squared(2)) / 3.0
    };
    picture
        .iter()
        .zip(reference)
        .map(|(x, r)| 1.0 - libm::log10f(error(x, r).max(f32::MIN_POSITIVE)) / darkest)
        .map(|value| value.clamp(0.0, 1.0))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_rise_in_lightness() {
        let lightness = |value: f32| {
            let [r, g, b] = colour(value).map(f32::from);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        for step in 0..20 {
            let value = step as f32 / 20.0;
            assert!(lightness(value + 0.05) > lightness(value), "{value}");
        }
        assert_eq!(colour(f32::NAN), [0; 3]);
        assert_eq!(colour(7.0), colour(1.0));
    }

    #[test]
    fn a_logarithmic_scale_ends_where_it_says() {
        let reference = [[1.0f32; 3]; 3];
        let picture = [[1.0f32; 3], [1.01; 3], [3.0; 3]];
        let map = logarithmic(&picture, &reference, 0.0, -4.0);
        assert_eq!((map[0], map[2]), (0.0, 1.0));
        assert!(map[1] < 1e-3, "1e-4 is the dark end: {map:?}");
        let map = logarithmic(&picture, &reference, 0.0, -8.0);
        assert!((map[1] - 0.5).abs() < 1e-2, "{map:?}");
    }
}
