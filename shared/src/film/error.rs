//! How wrong the picture is, from its two halves.

use super::TileFilm;

/// Error of a film, estimated from the difference of its halves. The expected
/// value of (A - B)^2 / 4 is the variance of (A + B) / 2, for independent
/// halves of equal count; nothing is divided by noisy pixels.
#[derive(
    Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
pub struct ErrorEstimate {
    /// Mean squared error per pixel and channel of the mean picture.
    pub mse: f64,
    /// Normalised MSE: sum (A-B)^2/4 over sum A*B.
    pub nmse: f64,
    /// The largest normalised MSE of any 64 x 64 tile that holds light.
    pub worst_tile_nmse: f64,
    /// Number of the tile that has it.
    pub worst_tile: u32,
}

/// What one tile adds to the error of its picture. Small enough to keep beside
/// the tile, so that the error of a picture needs no film in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct TileError {
    /// Sum of (A - B)^2 / 4 over pixels and channels.
    pub error: f64,
    /// Sum of A * B over pixels and channels.
    pub light: f64,
    /// Pixels times channels; 0 without samples.
    pub values: u64,
}

/// The error sums of one tile; pixels in order, in f64.
#[must_use]
pub fn tile_error(film: &TileFilm) -> TileError {
    if film.samples_per_half == 0 {
        return TileError::default();
    }
    let (mut error, mut light) = (0.0, 0.0);
    for pixel in 0..film.pixels() {
        let (a, b) = (film.half_mean(0, pixel), film.half_mean(1, pixel));
        for c in 0..3 {
            error += (a[c] - b[c]) * (a[c] - b[c]) * 0.25;
            light += a[c] * b[c];
        }
    }
    TileError {
        error,
        light,
        values: 3 * film.pixels() as u64,
    }
}

/// Join the error sums of tiles (number and sums, in tile order); `None` when
/// none has samples.
pub fn join_errors(tiles: impl Iterator<Item = (u32, TileError)>) -> Option<ErrorEstimate> {
    let (mut error_sum, mut light_sum, mut values) = (0.0, 0.0, 0u64);
    let (mut worst_tile_nmse, mut worst_tile) = (0.0, 0);
    for (index, tile) in tiles.filter(|(_, tile)| tile.values > 0) {
        values += tile.values;
        error_sum += tile.error;
        light_sum += tile.light;
        if tile.light > 0.0 && tile.error / tile.light > worst_tile_nmse {
            (worst_tile_nmse, worst_tile) = (tile.error / tile.light, index);
        }
    }
    if values == 0 {
        return None;
    }
    let nmse = if light_sum > 0.0 {
        error_sum / light_sum
    } else {
        0.0
    };
    Some(ErrorEstimate {
        mse: error_sum / values as f64,
        nmse,
        worst_tile_nmse,
        worst_tile,
    })
}

/// Estimate the error over all tiles that have samples, in tile order; `None`
/// when there is none. Sums run in f64 in a fixed order.
pub fn estimate_error<'a>(
    tiles: impl Iterator<Item = (u32, &'a TileFilm)>,
) -> Option<ErrorEstimate> {
    join_errors(tiles.map(|(index, film)| (index, tile_error(film))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::TileSums;

    // Two halves of 1 + noise and 1 - noise: MSE of the mean is noise^2.
    #[test]
    fn known_difference_gives_known_error() {
        let mut part = TileSums::zero(4, &(0..1));
        part.radiance[0].fill((1.1 * crate::film::FIXED_ONE) as i64);
        part.radiance[1].fill((0.9 * crate::film::FIXED_ONE) as i64);
        let mut film = TileFilm::zero(4);
        film.add(&part).expect("fits");
        let estimate = estimate_error(std::iter::once((7, &film))).expect("samples");
        assert!((estimate.mse - 0.01).abs() < 1e-6, "{estimate:?}");
        assert!((estimate.nmse - 0.01 / 0.99).abs() < 1e-6);
        assert_eq!(estimate.worst_tile, 7);
    }

    #[test]
    fn no_samples_no_estimate_and_black_is_exact() {
        assert_eq!(estimate_error(std::iter::empty()), None);
        let mut black = TileFilm::zero(4);
        black.samples_per_half = 2;
        let estimate = estimate_error(std::iter::once((0, &black))).expect("samples");
        assert_eq!((estimate.mse, estimate.nmse), (0.0, 0.0));
    }
}
