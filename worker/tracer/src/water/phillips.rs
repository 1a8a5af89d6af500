//! The Phillips spectrum: how much energy the wind gives to each wave.

use crate::math::elementary;
use crate::math::hash::mix64;
use shearwater_shared::scene::TessendorfWater;

/// Acceleration of free fall.
pub(super) const GRAVITY_MPS2: f64 = 9.81;
/// Energy of waves that run against the wind, as a share of their mirror image.
pub(super) const UPWIND: f64 = 0.07;

/// The spectrum of one sea.
#[derive(Clone, Copy, Debug)]
pub(super) struct Phillips {
    wind_x: f64,
    wind_z: f64,
    /// Square of the largest wave that the wind can raise, V^2/g, in metres^2.
    largest2: f64,
    cutoff2: f64,
    amplitude: f64,
    /// Points and metres of a side.
    n: usize,
    cell: f64,
    seed: u64,
}

impl Phillips {
    pub(super) fn new(sea: &TessendorfWater) -> Self {
        let azimuth = sea.wind_direction_deg.to_radians();
        let largest_m = sea.wind_speed_mps * sea.wind_speed_mps / GRAVITY_MPS2;
        Self {
            wind_x: libm::sin(azimuth),
            wind_z: -libm::cos(azimuth),
            largest2: largest_m * largest_m,
            cutoff2: sea.cutoff_m * sea.cutoff_m,
            // Without the factor a damped upwind would cost nearly half of the energy.
            amplitude: sea.amplitude * 2.0 / (1.0 + UPWIND),
            n: sea.grid as usize,
            cell: 2.0 * std::f64::consts::PI / sea.tile_m,
            seed: sea.seed,
        }
    }

    /// Density over wave vectors, m^4: multiply by the area (2 pi / tile)^2 of a
    /// grid cell for the variance that one wave carries, so that the sea does not
    /// depend on the size of the tile. Tessendorf 2001, equations 40 and 41.
    pub(super) fn density(&self, kx: f64, kz: f64) -> f64 {
        let k2 = kx * kx + kz * kz;
        if k2 <= 0.0 || self.largest2 <= 0.0 {
            return 0.0;
        }
        let along = kx * self.wind_x + kz * self.wind_z;
        let spread = along * along / k2 * if along < 0.0 { UPWIND } else { 1.0 };
        // Both cut-offs, of the largest waves and of the smallest.
        let ends = libm::exp(-1.0 / (k2 * self.largest2) - k2 * self.cutoff2);
        self.amplitude * spread * ends / (k2 * k2)
    }

    /// The amplitude h0 of the wave of row and column frequency, each 0 to n - 1
    /// (n - 1 is -1), whose vector is (kx, kz). Each h0 carries half of P dk^2,
    /// because h0(k) and h0(-k) both add theirs to a wave: the expected variance of
    /// the sea is sum P dk^2.
    pub(super) fn amplitude(&self, row: usize, column: usize, kx: f64, kz: f64) -> [f32; 2] {
        let scale = (libm::sqrt(0.25 * self.density(kx, kz)) * self.cell) as f32;
        let key = mix64(self.seed ^ mix64((row * self.n + column) as u64));
        gaussian_pair(key).map(|g| g * scale)
    }
}

// Two independent normal numbers (Box and Muller 1958).
fn gaussian_pair(key: u64) -> [f32; 2] {
    let unit = |bits: u64| (((bits >> 11) as f64 + 0.5) / 9_007_199_254_740_992.0) as f32;
    let radius = (-2.0 * elementary::ln(unit(key))).max(0.0).sqrt();
    let angle = std::f32::consts::TAU * unit(mix64(key ^ 0xA076_1D64_78BD_642F));
    let (sin, cos) = elementary::sin_cos(angle);
    [radius * cos, radius * sin]
}

#[cfg(test)]
mod tests {
    use super::super::tests::sea;
    use super::*;

    #[test]
    fn the_wind_drives_most_of_the_energy() {
        let sea = sea();
        let azimuth = sea.wind_direction_deg.to_radians();
        let (x, z) = (libm::sin(azimuth) * 0.3, -libm::cos(azimuth) * 0.3);
        let phillips = Phillips::new(&sea);
        assert!((phillips.density(-x, -z) / phillips.density(x, z) - UPWIND).abs() < 1e-9);
        assert!(phillips.density(-z, x) < 1e-20, "across the wind");
        assert_eq!(phillips.density(0.0, 0.0), 0.0);
    }

    #[test]
    fn random_numbers_are_normal() {
        let count = 200_000_u64;
        let numbers = || (0..count).flat_map(|i| gaussian_pair(mix64(i)));
        let moment = |power: i32| {
            let of = |g: f32| (0..power).fold(1.0, |p, _| p * f64::from(g));
            numbers().map(of).sum::<f64>() / (2 * count) as f64
        };
        // Standard errors of the first, second and fourth moments of 400,000: 1, 1.4
        // and 9.8 times 1/632.
        assert!(moment(1).abs() < 4.0 / 632.0);
        assert!((moment(2) - 1.0).abs() < 4.0 * 1.4 / 632.0);
        assert!((moment(4) - 3.0).abs() < 4.0 * 9.8 / 632.0);
    }
}
