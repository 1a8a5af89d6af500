//! Tessendorf's sea (2001, "Simulating Ocean Water"): random waves, summed by an
//! inverse FFT. What does not change with time is a [`Spectrum`]; heights and slopes at
//! a time come from it.

use super::fft::{Block, LANES, Plan};
use super::phillips::{GRAVITY_MPS2, Phillips};
use crate::math::elementary::sin_cos_turns;
use rayon::prelude::*;
use shearwater_shared::scene::TessendorfWater;
use std::f64::consts::PI;

/// The waves of a sea: amplitudes and frequencies.
///
/// h(k, t) = h0(k) e^{-iwt} + conj(h0(-k)) e^{iwt} with w^2 = g k (Tessendorf 2001,
/// equation 43): under e^{ikx} the first term travels along k. The field is real, so
/// half of the plane of k suffices: kz = 0 .. n/2 - 1 and every kx.
#[derive(Clone, Debug)]
pub struct Spectrum {
    n: usize,
    tile_m: f64,
    plan: Plan,
    /// By block of `LANES` rows, then column; lanes are rows.
    waves: Vec<Waves>,
    /// Seconds after which all waves are back.
    loop_s: Option<f64>,
}

// LANES waves with neighbouring kz. With a = h0(k), b = h0(-k), c = cos wt and
// s = sin wt: Re h = even_c c + even_s s, Im h = odd_c c - odd_s s.
#[derive(Clone, Copy, Debug)]
struct Waves {
    even_c: [f32; LANES],
    even_s: [f32; LANES],
    odd_c: [f32; LANES],
    odd_s: [f32; LANES],
    /// Quarter turns per second, or per loop.
    quarters: [f64; LANES],
}

/// A periodic height field and its slopes; row by row along z, columns along x.
#[derive(Clone, Debug)]
pub struct HeightField {
    /// Points along each side.
    pub n: usize,
    /// Side of the tile in metres.
    pub tile_m: f64,
    /// Heights in metres; their mean is 0.
    pub height: Vec<f32>,
    /// dh/dx.
    pub slope_x: Vec<f32>,
    /// dh/dz.
    pub slope_z: Vec<f32>,
}

/// A linear map of the height field, as what each wave h is multiplied with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Field {
    /// 1: the height.
    Height,
    /// i kx: dh/dx. Spectral, since a difference of heights loses 36 % of a wave of
    /// four texels.
    SlopeX,
    /// i kz: dh/dz.
    SlopeZ,
    /// kx^2/k: how much the choppy displacement squeezes along x; then along z, and
    /// both.
    SqueezeX,
    SqueezeZ,
    SqueezeXz,
}

impl Spectrum {
    /// The waves of a sea.
    #[must_use]
    pub fn new(sea: &TessendorfWater) -> Self {
        let n = sea.grid as usize;
        let phillips = Phillips::new(sea);
        let step = 2.0 * PI / sea.tile_m;
        let mut waves = vec![Waves::NONE; n * n / (2 * LANES)];
        let fill = |(b, waves): (usize, &mut [Waves])| {
            for (column, waves) in waves.iter_mut().enumerate() {
                for lane in 0..LANES {
                    waves.set(lane, &phillips, sea, n, step, b * LANES + lane, column);
                }
            }
        };
        // Rows do not depend on each other: the same for any number of threads.
        waves.par_chunks_mut(n).enumerate().for_each(fill);
        Self {
            n,
            tile_m: sea.tile_m,
            plan: Plan::new(n),
            waves,
            loop_s: sea.loop_s,
        }
    }

    /// Points along a side.
    #[must_use]
    pub fn n(&self) -> usize {
        self.n
    }

    /// Heights and slopes at a time.
    #[must_use]
    pub fn at(&self, time_s: f64) -> HeightField {
        let [height, slope_x, slope_z] =
            self.fields(time_s, [Field::Height, Field::SlopeX, Field::SlopeZ]);
        HeightField {
            n: self.n,
            tile_m: self.tile_m,
            height,
            slope_x,
            slope_z,
        }
    }

    /// Any fields at a time, n x n each.
    pub(super) fn fields<const N: usize>(&self, time_s: f64, wanted: [Field; N]) -> [Vec<f32>; N] {
        let h = self.waves_at(time_s);
        let mut scratch = self.plan.scratch();
        wanted.map(|field| {
            self.plan.inverse_real(&mut scratch, |b, input| {
                self.multiply(field, &h, b, input);
            })
        })
    }

    // Every wave at a time.
    fn waves_at(&self, time_s: f64) -> Block {
        // Whole loops are taken away before they can cost digits.
        let time = match self.loop_s {
            Some(loop_s) => time_s / loop_s - libm::floor(time_s / loop_s),
            None => time_s,
        };
        let mut h = Block::new(self.waves.len());
        for (waves, (re, im)) in self.waves.iter().zip(h.re.iter_mut().zip(&mut h.im)) {
            for l in 0..LANES {
                let (sin, cos) = sin_cos_turns(waves.quarters[l] * time);
                re[l] = waves.even_c[l] * cos + waves.even_s[l] * sin;
                im[l] = waves.odd_c[l] * cos - waves.odd_s[l] * sin;
            }
        }
        h
    }

    // The waves of one block of rows, times what makes `field` of them.
    fn multiply(&self, field: Field, h: &Block, b: usize, input: &mut Block) {
        let n = self.n;
        let step = (2.0 * PI / self.tile_m) as f32;
        let kz: [f32; LANES] = std::array::from_fn(|l| (b * LANES + l) as f32 * step);
        let rows = b * n..(b + 1) * n;
        let h = h.re[rows.clone()].iter().zip(&h.im[rows]);
        let input = input.re.iter_mut().zip(&mut input.im);
        for (column, ((h_re, h_im), (re, im))) in h.zip(input).enumerate() {
            let kx = signed(column, n) as f32 * step;
            let real = |weight: &dyn Fn(f32) -> f32| kz.map(weight);
            let weight = match field {
                Field::Height => [1.0; LANES],
                Field::SlopeX => [kx; LANES],
                Field::SlopeZ => kz,
                Field::SqueezeX => real(&|kz| kx * kx * inverse_length(kx, kz)),
                Field::SqueezeZ => real(&|kz| kz * kz * inverse_length(kx, kz)),
                Field::SqueezeXz => real(&|kz| kx * kz * inverse_length(kx, kz)),
            };
            let turned = matches!(field, Field::SlopeX | Field::SlopeZ);
            for l in 0..LANES {
                let (a, b) = (h_re[l] * weight[l], h_im[l] * weight[l]);
                (re[l], im[l]) = if turned { (-b, a) } else { (a, b) };
            }
        }
    }
}

impl Waves {
    const NONE: Self = Self {
        even_c: [0.0; LANES],
        even_s: [0.0; LANES],
        odd_c: [0.0; LANES],
        odd_s: [0.0; LANES],
        quarters: [0.0; LANES],
    };

    fn set(
        &mut self,
        lane: usize,
        phillips: &Phillips,
        sea: &TessendorfWater,
        n: usize,
        step: f64,
        row: usize,
        column: usize,
    ) {
        // The Nyquist waves have no partner of opposite direction, so their slopes
        // would not be real; k = 0 is the mean height, which is 0.
        if column == n / 2 || (row == 0 && column == 0) {
            return;
        }
        let (kx, kz) = (signed(column, n) * step, row as f64 * step);
        let [a_re, a_im] = phillips.amplitude(row, column, kx, kz);
        let [b_re, b_im] = phillips.amplitude((n - row) % n, (n - column) % n, -kx, -kz);
        self.even_c[lane] = a_re + b_re;
        self.even_s[lane] = a_im + b_im;
        self.odd_c[lane] = a_im - b_im;
        self.odd_s[lane] = a_re - b_re;
        let turns_per_s = frequency_hz(libm::sqrt(kx * kx + kz * kz));
        self.quarters[lane] = 4.0
            * match sea.loop_s {
                None => turns_per_s,
                Some(loop_s) => whole_turns(turns_per_s * loop_s),
            };
    }
}

/// Turns per second of a deep-water wave of wave number `k` in radians per metre.
pub(super) fn frequency_hz(k: f64) -> f64 {
    libm::sqrt(GRAVITY_MPS2 * k) / (2.0 * PI)
}

/// The nearest number of turns that closes a loop; no wave stands still.
pub(super) fn whole_turns(turns: f64) -> f64 {
    libm::round(turns).max(1.0)
}

#[inline]
fn signed(i: usize, n: usize) -> f64 {
    if i < n / 2 {
        i as f64
    } else {
        i as f64 - n as f64
    }
}

// 1/k, and 0 for the mean.
#[inline]
fn inverse_length(kx: f32, kz: f32) -> f32 {
    let k2 = kx * kx + kz * kz;
    if k2 > 0.0 { 1.0 / k2.sqrt() } else { 0.0 }
}
