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

/// Estimate the error over all tiles that have samples, in tile order; `None`
/// when there is none. Sums run in f64 in a fixed order.
pub fn estimate_error<'a>(
    tiles: impl Iterator<Item = (u32, &'a TileFilm)>,
) -> Option<ErrorEstimate> {
    let (mut error_sum, mut light_sum, mut values) = (0.0, 0.0, 0u64);
    let (mut worst_tile_nmse, mut worst_tile) = (0.0, 0);
    for (index, film) in tiles.filter(|(_, film)| film.samples_per_half > 0) {
        let (mut error, mut light) = (0.0, 0.0);
        for pixel in 0..film.pixels() {
            let (a, b) = (film.half_mean(0, pixel), film.half_mean(1, pixel));
            for c in 0..3 {
                error += (a[c] - b[c]) * (a[c] - b[c]) * 0.25;
                light += a[c] * b[c];
            }
        }
        values += 3 * film.pixels() as u64;
        error_sum += error;
        light_sum += light;
        if light > 0.0 && error / light > worst_tile_nmse {
            (worst_tile_nmse, worst_tile) = (error / light, index);
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
