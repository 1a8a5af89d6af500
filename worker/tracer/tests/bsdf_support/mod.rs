//! Statistics shared by the sampler tests: a counter-based stream of random
//! numbers, moments, and the chi-square test.
#![allow(dead_code, reason = "each test binary uses its own part")]
#![allow(unreachable_pub, reason = "a module of several test binaries")]

pub mod bins;
pub mod gallery;
pub mod metals;
pub mod quadrature;

use glam::Vec3;
use shearwater_tracer::math::hash::{mix64, u32_to_unit};

/// Level of one whole family of chi-square tests before the Sidak correction.
pub const FAMILY_LEVEL: f64 = 0.01;
/// Cells with fewer expected samples are pooled into one.
const MIN_EXPECTED: f64 = 5.0;

/// Number `index` of the stream `seed`, in [0, 1).
pub fn uniform(seed: u64, index: u64) -> f32 {
    u32_to_unit(
        (mix64(mix64(seed ^ 0x5bf0_3635) ^ index.wrapping_mul(0x9e37_79b9_7f4a_7c15)) >> 32) as u32,
    )
}

/// Three numbers of sample `index`.
pub fn uniform3(seed: u64, index: u64) -> [f32; 3] {
    [0, 1, 2].map(|k| uniform(seed, 3 * index + k))
}

/// A direction at `degrees` from +z and `azimuth` degrees about it.
pub fn direction(degrees: f64, azimuth: f64) -> Vec3 {
    let (t, p) = (degrees.to_radians(), azimuth.to_radians());
    Vec3::new(
        (libm::sin(t) * libm::cos(p)) as f32,
        (libm::sin(t) * libm::sin(p)) as f32,
        // The sine of the complement, so that 90 degrees is exactly 0.
        if degrees == 90.0 {
            0.0
        } else {
            libm::cos(t) as f32
        },
    )
}

/// The chance that a chi-square variable of `freedom` degrees exceeds `x`:
/// the upper regularised gamma function (series below, continued fraction by
/// Lentz above; Press et al. 2007, section 6.2).
pub fn chi_square_tail(x: f64, freedom: f64) -> f64 {
    let (a, x) = (0.5 * freedom, 0.5 * x);
    if x <= 0.0 {
        return 1.0;
    }
    let scale = libm::exp(-x + a * libm::log(x) - libm::lgamma(a));
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > sum * 1e-15 {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return 1.0 - sum * scale;
    }
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (1e300, 1.0 / b);
    let mut h = d;
    for i in 1..100_000 {
        let an = -f64::from(i) * (f64::from(i) - a);
        b += 2.0;
        d = 1.0 / (an * d + b);
        c = b + an / c;
        let step = d * c;
        h *= step;
        if (step - 1.0).abs() < 1e-15 {
            break;
        }
    }
    scale * h
}

/// The p-value of `observed` counts against `expected` ones; small cells are
/// pooled. Panics where nothing is left to compare.
pub fn chi_square_p(observed: &[u32], expected: &[f64]) -> f64 {
    let (mut statistic, mut cells) = (0.0, 0usize);
    let (mut pooled_seen, mut pooled_expected) = (0.0, 0.0);
    for (&seen, &expect) in observed.iter().zip(expected) {
        let seen = f64::from(seen);
        if expect < MIN_EXPECTED {
            pooled_seen += seen;
            pooled_expected += expect;
        } else {
            statistic += (seen - expect) * (seen - expect) / expect;
            cells += 1;
        }
    }
    if pooled_expected > 0.0 || pooled_seen > 0.0 {
        let pooled_expected = pooled_expected.max(1e-9);
        statistic +=
            (pooled_seen - pooled_expected) * (pooled_seen - pooled_expected) / pooled_expected;
        cells += 1;
    }
    assert!(cells >= 2, "{cells} cells");
    chi_square_tail(statistic, (cells - 1) as f64)
}

/// The level of one test so that `tests` of them together stay at
/// [`FAMILY_LEVEL`] (Sidak 1967).
pub fn sidak_level(tests: usize) -> f64 {
    1.0 - libm::pow(1.0 - FAMILY_LEVEL, 1.0 / tests as f64)
}

/// Running mean and variance (Welford 1962).
#[derive(Default)]
pub struct Moments {
    count: f64,
    mean: f64,
    squares: f64,
}

impl Moments {
    /// Of the single values.
    pub fn variance(&self) -> f64 {
        self.squares / self.count
    }
    pub fn add(&mut self, v: f64) {
        self.count += 1.0;
        let delta = v - self.mean;
        self.mean += delta / self.count;
        self.squares += delta * (v - self.mean);
    }
    pub fn mean(&self) -> f64 {
        self.mean
    }
    /// How many values.
    pub fn count(&self) -> f64 {
        self.count
    }
    /// Of the mean.
    pub fn standard_error(&self) -> f64 {
        (self.squares / self.count / self.count).sqrt()
    }
    /// Four standard errors of the mean, with the rounding of f32 added.
    pub fn four_sigma(&self) -> f64 {
        4.0 * (self.squares / self.count / self.count).sqrt() + 1e-6
    }
}
