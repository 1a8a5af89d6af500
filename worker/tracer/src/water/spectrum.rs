//! Tessendorf's sea (2001, "Simulating Ocean Water"): random waves with the
//! Phillips spectrum, summed by an inverse FFT. Heights and slopes, in metres.

use crate::math::hash::mix64;
use num_complex::Complex;
use shearwater_shared::scene::TessendorfWater;
use std::f64::consts::PI;

const GRAVITY_MPS2: f64 = 9.81;
/// Energy of waves that run against the wind, as a share of their mirror image.
const UPWIND: f64 = 0.07;

/// A periodic height field and its slopes; row by row along z, columns along x.
#[derive(Clone, Debug)]
pub struct HeightField {
    /// Points along each side.
    pub n: usize,
    /// Side of the tile in metres.
    pub tile_m: f64,
    /// Heights in metres; their mean is 0.
    pub height: Vec<f64>,
    /// dh/dx.
    pub slope_x: Vec<f64>,
    /// dh/dz.
    pub slope_z: Vec<f64>,
}

/// The Phillips spectrum as a density over wave vectors, m^4: multiply by the
/// area (2 pi / tile)^2 of a grid cell for the variance that one wave carries, so
/// that the sea does not depend on the size of the tile.
#[must_use]
fn phillips(sea: &TessendorfWater, kx: f64, kz: f64) -> f64 {
    let k2 = kx * kx + kz * kz;
    if k2 <= 0.0 || sea.wind_speed_mps <= 0.0 {
        return 0.0;
    }
    let largest_m = sea.wind_speed_mps * sea.wind_speed_mps / GRAVITY_MPS2;
    let azimuth = sea.wind_direction_deg.to_radians();
    let (wind_x, wind_z) = (libm::sin(azimuth), -libm::cos(azimuth));
    let along = (kx * wind_x + kz * wind_z) / libm::sqrt(k2);
    let spread = along * along * if along < 0.0 { UPWIND } else { 1.0 };
    // Without the factor a damped upwind would cost nearly half of the energy.
    let spread = spread * 2.0 / (1.0 + UPWIND);
    let cutoff = libm::exp(-k2 * sea.cutoff_m * sea.cutoff_m);
    sea.amplitude * libm::exp(-1.0 / (k2 * largest_m * largest_m)) / (k2 * k2) * spread * cutoff
}

/// Heights and slopes of the sea at its time.
///
/// Slopes are spectral (i k h), not differences of heights: a central difference
/// loses 36 % of a wave of four texels. The two slopes share one transform.
#[must_use]
pub fn height_field(sea: &TessendorfWater) -> HeightField {
    let n = sea.grid as usize;
    let step = 2.0 * PI / sea.tile_m;
    let signed = |i: usize| {
        if i < n / 2 {
            i as f64
        } else {
            i as f64 - n as f64
        }
    };
    let mut height = vec![Complex::new(0.0, 0.0); n * n];
    let mut slopes = height.clone();
    for row in 0..n {
        for column in 0..n {
            // The Nyquist waves have no partner of opposite direction, so their
            // slopes would not be real; k = 0 is the mean height, which is 0.
            if row == n / 2 || column == n / 2 || (row == 0 && column == 0) {
                continue;
            }
            let (kx, kz) = (signed(column) * step, signed(row) * step);
            let h = amplitude(sea, n, row, column, kx, kz);
            height[row * n + column] = h;
            let slope_x = Complex::new(-kx * h.im, kx * h.re);
            let slope_z = Complex::new(-kz * h.im, kz * h.re);
            // Both fields are real: their sum as X + i Z comes apart again.
            slopes[row * n + column] =
                Complex::new(slope_x.re - slope_z.im, slope_x.im + slope_z.re);
        }
    }
    inverse_2d(&mut height, n);
    inverse_2d(&mut slopes, n);
    HeightField {
        n,
        tile_m: sea.tile_m,
        height: height.iter().map(|h| h.re).collect(),
        slope_x: slopes.iter().map(|s| s.re).collect(),
        slope_z: slopes.iter().map(|s| s.im).collect(),
    }
}

// h(k, t) = h0(k) e^{-iwt} + conj(h0(-k)) e^{iwt}, with w^2 = g k: under e^{ikx}
// the first term travels along k, with the wind where the spectrum has its energy. Each h0 carries
// half of P dk^2, since both terms add theirs: the expected variance is sum P dk^2.
fn amplitude(
    sea: &TessendorfWater,
    n: usize,
    row: usize,
    column: usize,
    kx: f64,
    kz: f64,
) -> Complex<f64> {
    let cell = 2.0 * PI / sea.tile_m;
    let h0 = |row: usize, column: usize, kx: f64, kz: f64| {
        let scale = libm::sqrt(0.5 * 0.5 * phillips(sea, kx, kz)) * cell;
        let (re, im) = gaussian_pair(mix64(sea.seed ^ mix64((row * n + column) as u64)));
        Complex::new(re * scale, im * scale)
    };
    let omega = libm::sqrt(GRAVITY_MPS2 * libm::sqrt(kx * kx + kz * kz));
    let phase = omega * sea.time_s;
    let turn = Complex::new(libm::cos(phase), -libm::sin(phase));
    let forth = h0(row, column, kx, kz) * turn;
    let back = h0((n - row) % n, (n - column) % n, -kx, -kz) * turn;
    forth + back.conj()
}

// Two independent standard normal numbers from one hash (Box and Muller 1958).
fn gaussian_pair(key: u64) -> (f64, f64) {
    let unit = |bits: u64| ((bits >> 11) as f64 + 0.5) / 9_007_199_254_740_992.0;
    let radius = libm::sqrt(-2.0 * libm::log(unit(key)));
    let angle = 2.0 * PI * unit(mix64(key ^ 0xA076_1D64_78BD_642F));
    (radius * libm::cos(angle), radius * libm::sin(angle))
}

// Inverse transform without a factor, rows then columns. Our own few lines: the
// library takes its twiddles from the platform's cos, whose last bits follow CPU
// and libc, and picks other algorithms on other CPUs. It is the oracle of the test.
fn inverse_2d(values: &mut [Complex<f64>], n: usize) {
    let angle = 2.0 * PI / n as f64;
    let turns: Vec<Complex<f64>> = (0..n / 2)
        .map(|k| Complex::new(libm::cos(angle * k as f64), libm::sin(angle * k as f64)))
        .collect();
    for _ in 0..2 {
        for row in values.chunks_exact_mut(n) {
            inverse_1d(row, &turns);
        }
        transpose(values, n);
    }
}

// Radix 2 (Cooley and Tukey 1965); the length is a power of two of at least 2.
fn inverse_1d(row: &mut [Complex<f64>], turns: &[Complex<f64>]) {
    let n = row.len();
    let shift = usize::BITS - n.trailing_zeros();
    for i in 0..n {
        let j = i.reverse_bits() >> shift;
        if i < j {
            row.swap(i, j);
        }
    }
    let mut half = 1;
    while half < n {
        let step = n / (2 * half);
        for block in row.chunks_exact_mut(2 * half) {
            let (low, high) = block.split_at_mut(half);
            for k in 0..half {
                let turned = high[k] * turns[k * step];
                (low[k], high[k]) = (low[k] + turned, low[k] - turned);
            }
        }
        half *= 2;
    }
}

fn transpose(values: &mut [Complex<f64>], n: usize) {
    for row in 0..n {
        for column in row + 1..n {
            values.swap(row * n + column, column * n + row);
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(in crate::water) fn sea() -> TessendorfWater {
        TessendorfWater {
            height_m: 0.0,
            grid: 128,
            tile_m: 200.0,
            wind_speed_mps: 10.0,
            wind_direction_deg: 30.0,
            amplitude: 1.0,
            cutoff_m: 0.0,
            seed: 5,
            body_color: [0.0; 3],
            ior: 1.333,
            roughness: 0.0,
            velocity_mps: [0.0; 2],
            time_s: 3.0,
        }
    }

    fn variance(values: &[f64]) -> f64 {
        values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64
    }

    #[test]
    fn the_field_is_real_and_has_no_mean() {
        let field = height_field(&sea());
        let mean = field.height.iter().sum::<f64>() / field.height.len() as f64;
        assert!(
            mean.abs() < 1e-12 * libm::sqrt(variance(&field.height)),
            "{mean}"
        );
        assert!(
            field
                .height
                .iter()
                .chain(&field.slope_x)
                .chain(&field.slope_z)
                .all(|v| v.is_finite())
        );
    }

    // Sum P dk^2 -> A pi Lw^2 / 2 over the plane: 163.22 for V = 10, A = 1; a
    // tile of 200 m and 128 points holds 162.8 of it. Averaged over seeds.
    #[test]
    fn variance_is_that_of_the_spectrum_for_any_tile() {
        let measured = |tile_m: f64| {
            let seeds = 60;
            let one = |seed| {
                variance(
                    &height_field(&TessendorfWater {
                        grid: 64,
                        tile_m,
                        seed,
                        ..sea()
                    })
                    .height,
                )
            };
            (0..seeds).map(one).sum::<f64>() / seeds as f64
        };
        for tile_m in [200.0, 400.0] {
            let v = measured(tile_m);
            assert!((v / 163.0 - 1.0).abs() < 0.12, "{tile_m} m: {v}");
        }
    }

    // Spectral slopes against sixth-order differences of a smooth field.
    #[test]
    fn slopes_are_the_derivatives_of_the_heights() {
        let field = height_field(&TessendorfWater {
            cutoff_m: 12.0,
            ..sea()
        });
        let (n, d) = (field.n, field.tile_m / field.n as f64);
        let at = |x: usize, z: usize| field.height[(z % n) * n + x % n];
        let rms = libm::sqrt(variance(&field.slope_x) + variance(&field.slope_z));
        for (x, z) in [(0, 0), (5, 77), (127, 127), (64, 3)] {
            let stencil = |f: &dyn Fn(usize) -> f64| {
                (45.0 * (f(1) - f(n - 1)) - 9.0 * (f(2) - f(n - 2)) + (f(3) - f(n - 3)))
                    / (60.0 * d)
            };
            let dx = stencil(&|s| at(x + s, z));
            let dz = stencil(&|s| at(x, z + s));
            assert!(
                (dx - field.slope_x[z * n + x]).abs() < 2e-4 * rms,
                "{dx} {}",
                field.slope_x[z * n + x]
            );
            assert!((dz - field.slope_z[z * n + x]).abs() < 2e-4 * rms);
        }
    }

    // w = sqrt(g k): a sea of one wave length comes back after its period. With
    // waves of 10 m only, T = 2.53079 s.
    #[test]
    fn waves_keep_their_period() {
        let omega = libm::sqrt(GRAVITY_MPS2 * 2.0 * PI / 10.0);
        assert!((2.0 * PI / omega - 2.530_79).abs() < 1e-5);
        let now = |time_s| {
            let sea = TessendorfWater {
                tile_m: 10.0,
                grid: 16,
                time_s,
                ..sea()
            };
            let (kx, kz) = (2.0 * PI / 10.0, 0.0);
            amplitude(&sea, 16, 0, 1, kx, kz)
        };
        let (start, later, half) = (now(0.0), now(2.0 * PI / omega), now(PI / omega));
        assert!((start - later).norm() < 1e-9 * start.norm());
        assert!((start + half).norm() < 1e-9 * start.norm());
    }

    #[test]
    fn the_transform_is_the_library_s() {
        for n in [2usize, 16, 64] {
            let mut ours: Vec<Complex<f64>> = (0..n * n)
                .map(|i| {
                    let (re, im) = gaussian_pair(mix64(i as u64));
                    Complex::new(re, im)
                })
                .collect();
            let mut theirs = ours.clone();
            inverse_2d(&mut ours, n);
            let fft = rustfft::FftPlanner::new().plan_fft_inverse(n);
            for _ in 0..2 {
                fft.process(&mut theirs);
                transpose(&mut theirs, n);
            }
            let worst = ours
                .iter()
                .zip(&theirs)
                .map(|(a, b)| (a - b).norm())
                .fold(0.0, f64::max);
            assert!(worst < 1e-12 * (n * n) as f64, "{n}: {worst}");
        }
    }

    // Of the two waves of a pair the wind drives the one that runs with it: after
    // a time dt its crest has moved by +c dt downwind.
    #[test]
    fn waves_run_with_the_wind() {
        let at = |time_s| {
            let sea = TessendorfWater {
                wind_direction_deg: 90.0,
                amplitude: 0.01,
                cutoff_m: 3.0,
                time_s,
                ..sea()
            };
            height_field(&sea)
        };
        let (now, later) = (at(10.0), at(10.2));
        // Where the surface rises, the wave that brings the crest comes from upwind:
        // dh/dt = -c dh/dx on average, so the sum of dh/dt * dh/dx is negative.
        let rising = now.height.iter().zip(&later.height).map(|(a, b)| b - a);
        let sum: f64 = rising.zip(&now.slope_x).map(|(dh, slope)| dh * slope).sum();
        let size =
            libm::sqrt(variance(&now.height) * variance(&now.slope_x)) * now.height.len() as f64;
        assert!(sum < -0.02 * size, "{sum} of {size}");
    }

    #[test]
    fn the_wind_drives_most_of_the_energy() {
        let sea = sea();
        let azimuth = sea.wind_direction_deg.to_radians();
        let (x, z) = (libm::sin(azimuth) * 0.3, -libm::cos(azimuth) * 0.3);
        assert!((phillips(&sea, -x, -z) / phillips(&sea, x, z) - UPWIND).abs() < 1e-9);
        assert!(phillips(&sea, -z, x) < 1e-20, "across the wind");
        assert_eq!(phillips(&sea, 0.0, 0.0), 0.0);
    }
}
