//! How wrong the picture is, from its two halves.

use super::{Brightness, TileFilm};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Side of the squares, in pixels, over which the relative error is formed: few
/// enough pixels to find dark corners, enough that one noisy pixel does not
/// decide what is divided by.
const SUB_TILE_SIDE: usize = 16;
/// What the mean square radiance of a square is raised by before it divides: that
/// of the field's relMSE, so that black does not divide by zero.
const RELATIVE_EPSILON: f64 = 0.01;
/// The share of samples whose light is the firefly gauge.
const FIREFLY_SAMPLES: f64 = 1e-4;
/// Half the width of a 95 % interval, in standard deviations.
const INTERVAL_95: f64 = 1.959_963_985;
/// Samples of each half from which on equal halves are strange.
const REPEAT_SAMPLES_MIN: u64 = 16;
/// Different pixels that must have equal halves. One pixel at an edge between two
/// flat colours has them by chance in one case of about three.
const REPEAT_PIXELS_MIN: u32 = 64;
/// Luminance of linear Rec. 709 (ITU-R BT.709-6, item 3.2).
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Error of a film, estimated from the difference of its halves. The expected
/// value of (A - B)^2 / 4 is the variance of (A + B) / 2, for independent
/// halves of equal count; nothing is divided by noisy pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema, ToSchema)]
pub struct ErrorEstimate {
    /// Mean squared error per pixel and channel of the mean picture.
    pub mse: f64,
    /// Normalised MSE: sum (A-B)^2/4 over sum A*B.
    pub nmse: f64,
    /// The largest normalised MSE of any 64 x 64 tile that holds light.
    pub worst_tile_nmse: f64,
    /// Number of the tile that has it.
    pub worst_tile: u32,
    /// More; absent for films that were merged before there was more.
    #[serde(flatten)]
    pub detail: Option<ErrorDetail>,
}

/// More about the error of a film.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema, ToSchema)]
pub struct ErrorDetail {
    /// Relative MSE: mean over pixels of sum (A-B)^2/4 over (sum A*B + 0.01 n), both
    /// sums over the 16 x 16 pixels (n values) around it.
    pub relmse: f64,
    /// The largest relative MSE of any 64 x 64 tile.
    pub worst_tile_relmse: f64,
    /// Number of the tile that has it.
    pub worst_relmse_tile: u32,
    /// Mean luminance (Rec. 709) of the pixels that have samples.
    pub mean: f64,
    /// Half the width of its 95 % interval.
    pub mean_interval: f64,
    /// Pixels that have samples: all numbers are theirs.
    pub pixels: u64,
    /// Samples of all pixels.
    pub samples: u64,
    /// Tiles whose halves are equal bit for bit although their samples are not: a
    /// repeated seed, and the error of them is unknown. Not 0 is an alarm.
    pub repeated_tiles: u32,
    /// Share of the light, 0 to 1, that the brightest 1e-4 of the samples carries;
    /// null when nothing is known or there is no light.
    pub firefly_share: Option<f64>,
}

/// What one tile adds to the error of its picture. Small enough to keep beside
/// the tile, so that the error of a picture needs no film in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TileError {
    /// Sum of (A - B)^2 / 4 over pixels and channels.
    pub error: f64,
    /// Sum of A * B over pixels and channels.
    pub light: f64,
    /// Pixels times channels; 0 without samples.
    pub values: u64,
    /// More; absent in stores of before there was more.
    #[serde(default)]
    pub detail: Option<TileDetail>,
}

impl TileError {
    /// Mean relative MSE over the tile's values, finite and not negative; 0 without
    /// samples. A tile without details counts as one square.
    #[must_use]
    pub fn relmse(&self) -> f64 {
        if self.values == 0 {
            return 0.0;
        }
        let values = self.values as f64;
        let relmse = match &self.detail {
            Some(detail) => detail.relative / values,
            None => self.error / (self.light.max(0.0) + RELATIVE_EPSILON * values),
        };
        if relmse.is_finite() {
            relmse.max(0.0)
        } else {
            f64::MAX
        }
    }
}

/// More sums of one tile.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TileDetail {
    /// Sum over pixels and channels of the relative MSE of their square.
    pub relative: f64,
    /// Sum of mean luminance over pixels.
    pub luminance: f64,
    /// Sum over pixels of its (A - B)^2 / 4.
    pub luminance_error: f64,
    /// Samples of all pixels, both halves.
    pub samples: u64,
    /// Pixels, none equal to the one before it, whose samples differ from each other.
    pub varied: u32,
    /// Those of them whose halves are equal bit for bit.
    pub repeated: u32,
}

/// The error sums of one tile of `width` columns; pixels in order, in f64.
#[must_use]
pub fn tile_error(film: &TileFilm, width: usize) -> TileError {
    if film.samples_per_half == 0 {
        return TileError::default();
    }
    let mut sums = halves_error(film);
    let mut detail = TileDetail {
        relative: relative_error(film, width),
        samples: film.samples_per_half * 2 * film.pixels() as u64,
        ..TileDetail::default()
    };
    for pixel in 0..film.pixels() {
        let [a, b] = [0, 1].map(|half| luminance(film.half_mean(half, pixel)));
        detail.luminance += (a + b) * 0.5;
        detail.luminance_error += (a - b) * (a - b) * 0.25;
    }
    (detail.varied, detail.repeated) = repetitions(film);
    sums.detail = Some(detail);
    sums
}

/// Error and light of all pixels, without what needs the shape of the tile.
fn halves_error(film: &TileFilm) -> TileError {
    let mut sums = TileError::default();
    if film.samples_per_half > 0 {
        (0..film.pixels()).for_each(|pixel| add_pixel(&mut sums, film, pixel));
    }
    sums
}

fn add_pixel(sums: &mut TileError, film: &TileFilm, pixel: usize) {
    let (a, b) = (film.half_mean(0, pixel), film.half_mean(1, pixel));
    for c in 0..3 {
        sums.error += (a[c] - b[c]) * (a[c] - b[c]) * 0.25;
        sums.light += a[c] * b[c];
    }
    sums.values += 3;
}

/// Sum over the tile's values of the relative error of the square each is in.
fn relative_error(film: &TileFilm, width: usize) -> f64 {
    let width = width.max(1);
    let height = film.pixels() / width;
    let mut relative = 0.0;
    for y0 in (0..height).step_by(SUB_TILE_SIDE) {
        for x0 in (0..width).step_by(SUB_TILE_SIDE) {
            let mut square = TileError::default();
            // Noise in the dark may have A * B below 0.
            for y in y0..(y0 + SUB_TILE_SIDE).min(height) {
                for x in x0..(x0 + SUB_TILE_SIDE).min(width) {
                    add_pixel(&mut square, film, y * width + x);
                }
            }
            let values = square.values as f64;
            relative += values * square.error / (square.light.max(0.0) + RELATIVE_EPSILON * values);
        }
    }
    relative
}

fn luminance(rgb: [f64; 3]) -> f64 {
    rgb[0] * LUMINANCE[0] + rgb[1] * LUMINANCE[1] + rgb[2] * LUMINANCE[2]
}

/// How many pixels must have samples of different values, and how many of those
/// have equal halves. A sum that its samples do not divide is not that of equal
/// samples, so a flat sky counts for nothing; nor does a row of equal pixels, as
/// an edge along the pixels gives, count more than once.
fn repetitions(film: &TileFilm) -> (u32, u32) {
    let samples = i128::from(film.samples_per_half);
    if film.samples_per_half < REPEAT_SAMPLES_MIN {
        return (0, 0);
    }
    let (mut varied, mut repeated) = (0, 0);
    let mut last: Option<(&[i128], &[i128])> = None;
    let [a, b] = &film.radiance;
    for (a, b) in a.chunks_exact(3).zip(b.chunks_exact(3)) {
        let flat = a == b && a.iter().all(|sum| sum % samples == 0);
        if flat || last == Some((a, b)) {
            continue;
        }
        last = Some((a, b));
        varied += 1;
        repeated += u32::from(a == b);
    }
    (varied, repeated)
}

/// Join the error sums of tiles (number and sums, in tile order); `None` when
/// none has samples. The firefly gauge stays unknown:
/// [`ErrorEstimate::with_brightness`].
pub fn join_errors(tiles: impl Iterator<Item = (u32, TileError)>) -> Option<ErrorEstimate> {
    let mut all = TileError::default();
    let mut more = TileDetail::default();
    let mut estimate = ErrorEstimate::default();
    let mut detail = ErrorDetail::default();
    let mut known = true;
    for (index, tile) in tiles.filter(|(_, tile)| tile.values > 0) {
        all.values += tile.values;
        all.error += tile.error;
        all.light += tile.light;
        if tile.light > 0.0 && tile.error / tile.light > estimate.worst_tile_nmse {
            estimate.worst_tile_nmse = tile.error / tile.light;
            estimate.worst_tile = index;
        }
        let Some(sums) = tile.detail else {
            known = false;
            continue;
        };
        more.relative += sums.relative;
        more.luminance += sums.luminance;
        more.luminance_error += sums.luminance_error;
        detail.samples += sums.samples;
        let equal = sums.repeated == sums.varied && sums.repeated >= REPEAT_PIXELS_MIN;
        detail.repeated_tiles += u32::from(equal);
        let relmse = sums.relative / tile.values as f64;
        if relmse > detail.worst_tile_relmse {
            detail.worst_tile_relmse = relmse;
            detail.worst_relmse_tile = index;
        }
    }
    if all.values == 0 {
        return None;
    }
    let values = all.values as f64;
    estimate.mse = all.error / values;
    if all.light > 0.0 {
        estimate.nmse = all.error / all.light;
    }
    detail.relmse = more.relative / values;
    detail.pixels = all.values / 3;
    let pixels = detail.pixels as f64;
    detail.mean = more.luminance / pixels;
    // Pixels are independent: the variance of their mean is that of one over their
    // number.
    detail.mean_interval = INTERVAL_95 * more.luminance_error.sqrt() / pixels;
    estimate.detail = known.then_some(detail);
    Some(estimate)
}

impl ErrorEstimate {
    /// The same with the firefly gauge of the film's samples.
    #[must_use]
    pub fn with_brightness(mut self, brightness: &Brightness) -> Self {
        if let Some(detail) = &mut self.detail {
            detail.firefly_share = brightness.share_of_brightest(FIREFLY_SAMPLES);
        }
        self
    }
}

/// Estimate the error over all tiles that have samples, in tile order, as far as it
/// does not depend on their shape; `None` when there is none. Sums run in f64 in a
/// fixed order.
pub fn estimate_error<'a>(
    tiles: impl Iterator<Item = (u32, &'a TileFilm)>,
) -> Option<ErrorEstimate> {
    join_errors(tiles.map(|(index, film)| (index, halves_error(film))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{FIXED_ONE, TileSums};

    fn film(pixels: usize, half: impl Fn(usize, usize) -> f64, samples: u32) -> TileFilm {
        let mut part = TileSums::zero(pixels, &(0..samples));
        for h in 0..2 {
            for (i, sum) in part.radiance[h].iter_mut().enumerate() {
                *sum = (half(h, i / 3) * f64::from(samples) * FIXED_ONE) as i64;
            }
        }
        let mut film = TileFilm::zero(pixels);
        film.add(&part).expect("fits");
        film
    }

    // Two halves of 1 + noise and 1 - noise: MSE of the mean is noise^2.
    #[test]
    fn known_difference_gives_known_error() {
        let film = film(4, |half, _| [1.1, 0.9][half], 1);
        let estimate = estimate_error(std::iter::once((7, &film))).expect("samples");
        assert!((estimate.mse - 0.01).abs() < 1e-6, "{estimate:?}");
        assert!((estimate.nmse - 0.01 / 0.99).abs() < 1e-6);
        assert_eq!((estimate.worst_tile, estimate.detail), (7, None));
        let whole = join_errors(std::iter::once((7, tile_error(&film, 2)))).expect("samples");
        let detail = whole.detail.expect("known");
        assert_eq!(whole.nmse, estimate.nmse);
        assert!((detail.relmse - 0.01 / 1.0).abs() < 1e-6, "{detail:?}");
        assert!((detail.mean - 1.0).abs() < 1e-6);
        // Standard deviation 0.1 of each of four pixels: 0.05 of their mean.
        assert!((detail.mean_interval - 1.96 * 0.05).abs() < 1e-4);
        assert_eq!((detail.pixels, detail.samples), (4, 8));
        assert_eq!(detail.worst_relmse_tile, 7);
    }

    // Left half bright, right half dim with the same relative noise: the relative
    // error sees the dim squares, the normalised one hardly.
    #[test]
    fn relative_error_is_of_squares_and_weighs_pixels() {
        let (width, height) = (40, 20);
        let level = |pixel: usize| if pixel % width < 32 { 1.0 } else { 0.1 };
        let film = film(
            width * height,
            |half, pixel| match level(pixel) {
                1.0 => [1.01, 0.99][half],
                _ => [0.2, 0.0][half],
            },
            1,
        );
        let estimate = join_errors(std::iter::once((0, tile_error(&film, width))));
        let detail = estimate.expect("samples").detail.expect("known");
        let bright = 1e-4 / (0.9999 + RELATIVE_EPSILON);
        let dim = 0.01 / RELATIVE_EPSILON;
        let expected = (32.0 * bright + 8.0 * dim) / 40.0;
        assert!((detail.relmse / expected - 1.0).abs() < 1e-5, "{detail:?}");
        assert!(estimate.expect("samples").nmse < 4e-3);
    }

    #[test]
    fn no_samples_no_estimate_and_black_is_exact() {
        assert_eq!(estimate_error(std::iter::empty()), None);
        let mut black = TileFilm::zero(4);
        black.samples_per_half = 2;
        let estimate = estimate_error(std::iter::once((0, &black))).expect("samples");
        assert_eq!((estimate.mse, estimate.nmse), (0.0, 0.0));
        let sums = tile_error(&black, 2);
        let estimate = join_errors(std::iter::once((0, sums))).expect("samples");
        let detail = estimate.with_brightness(&black.brightness).detail;
        assert_eq!(
            detail.map(|d| (d.relmse, d.firefly_share)),
            Some((0.0, None))
        );
    }

    #[test]
    fn tiles_of_an_older_store_have_no_detail() {
        let old: TileError =
            serde_json::from_str(r#"{"error":1.0,"light":4.0,"values":3}"#).expect("old");
        let new = tile_error(&film(4, |_, _| 1.0, 1), 2);
        let estimate = join_errors([(0, old), (1, new)].into_iter()).expect("samples");
        assert_eq!((estimate.worst_tile_nmse, estimate.detail), (0.25, None));
        let text = r#"{"mse":1.0,"nmse":2.0,"worst_tile_nmse":3.0,"worst_tile":4}"#;
        let old: ErrorEstimate = serde_json::from_str(text).expect("old");
        assert_eq!((old.worst_tile, old.detail), (4, None));
        let whole = join_errors(std::iter::once((1, new))).expect("samples");
        let text = serde_json::to_string(&whole).expect("JSON");
        assert!(text.contains("\"relmse\":"), "{text}");
        assert_eq!(
            serde_json::from_str::<ErrorEstimate>(&text).ok(),
            Some(whole)
        );
    }

    #[test]
    fn equal_halves_are_an_alarm_unless_every_sample_is_equal() {
        let repeated = |film: &TileFilm| {
            let tile = tile_error(film, 16);
            let estimate = join_errors(std::iter::once((0, tile))).expect("samples");
            estimate.detail.expect("known").repeated_tiles
        };
        let noise = |pixel: usize| 0.3 + 0.001_37 * ((pixel * 7919) % 256) as f64;
        let same = film(256, |_, pixel| noise(pixel), 32);
        assert_eq!(repeated(&same), 1);
        let honest = film(256, |half, pixel| noise(pixel) + 0.01 * half as f64, 32);
        assert_eq!(repeated(&honest), 0);
        // One honest pixel is enough to see that the seeds are not the same.
        let almost = film(
            256,
            |half, pixel| noise(pixel) + if pixel == 99 { 0.1 * half as f64 } else { 0.0 },
            32,
        );
        assert_eq!(repeated(&almost), 0);
        let flat = film(256, |_, pixel| (pixel / 16) as f64, 32);
        assert_eq!(repeated(&flat), 0);
        // The edge of something black along the pixels of a flat sky.
        let edge = film(
            256,
            |_, pixel| if pixel % 16 == 3 { 0.345 } else { 1.0 },
            32,
        );
        assert_eq!(repeated(&edge), 0);
    }
}
