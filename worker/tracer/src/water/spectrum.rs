//! Tessendorf's sea (2001, "Simulating Ocean Water"): random waves, summed by an
//! inverse FFT. What does not change with time is a [`Spectrum`]; heights and slopes at
//! a time come from it.

use super::fft::{Block, LANES, Plan, VECTORS};
use super::phillips::{GRAVITY_MPS2, Phillips};
use crate::math::elementary::{reduce_quarters, sin_cos_reduced};
use glam::Vec4;
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
    waves: Waves,
    /// Seconds after which all waves are back.
    loop_s: Option<f64>,
}

// By block of `LANES` rows, then column, then row. With a = h0(k), b = h0(-k),
// c = cos wt and s = sin wt: Re h = even_c c + even_s s, Im h = odd_c c - odd_s s.
#[derive(Clone, Debug)]
struct Waves {
    even_c: Vec<f32>,
    even_s: Vec<f32>,
    odd_c: Vec<f32>,
    odd_s: Vec<f32>,
    /// Quarter turns per second, or per loop.
    quarters: Vec<f64>,
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
        Self {
            n,
            tile_m: sea.tile_m,
            plan: Plan::new(n),
            waves: Waves::new(sea, n),
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
        let mut h = Block::new(self.n * self.n / (2 * LANES));
        self.waves.at(
            time,
            bytemuck::cast_slice_mut(&mut h.re),
            bytemuck::cast_slice_mut(&mut h.im),
        );
        h
    }

    /// Sum of |h|^2 over all waves.
    #[cfg(test)]
    pub(super) fn energy(&self, time_s: f64) -> f64 {
        let h = self.waves_at(time_s);
        let mut sum = 0.0;
        for (i, (re, im)) in h.re.iter().zip(&h.im).enumerate() {
            // The other half of the plane has as much, but for its border.
            let border = i < self.n * VECTORS && i % VECTORS == 0;
            let twice = Vec4::new(if border { 1.0 } else { 2.0 }, 2.0, 2.0, 2.0);
            sum += f64::from(((*re * *re + *im * *im) * twice).element_sum());
        }
        sum
    }

    // The waves of one block of rows, times what makes `field` of them.
    fn multiply(&self, field: Field, h: &Block, b: usize, input: &mut Block) {
        let n = self.n;
        let step = (2.0 * PI / self.tile_m) as f32;
        for column in 0..n {
            let kx = Vec4::splat(signed(column, n) as f32 * step);
            for v in 0..VECTORS {
                let row = (b * LANES + 4 * v) as f32;
                let kz = (Vec4::splat(row) + Vec4::new(0.0, 1.0, 2.0, 3.0)) * step;
                let (to, from) = (column * VECTORS + v, (b * n + column) * VECTORS + v);
                let (re, im) = (h.re[from], h.im[from]);
                (input.re[to], input.im[to]) = match field {
                    Field::Height => (re, im),
                    Field::SlopeX => (-im * kx, re * kx),
                    Field::SlopeZ => (-im * kz, re * kz),
                    Field::SqueezeX => scaled(re, im, kx * kx * inverse_length(kx, kz)),
                    Field::SqueezeZ => scaled(re, im, kz * kz * inverse_length(kx, kz)),
                    Field::SqueezeXz => scaled(re, im, kx * kz * inverse_length(kx, kz)),
                };
            }
        }
    }
}

impl Waves {
    fn new(sea: &TessendorfWater, n: usize) -> Self {
        let phillips = Phillips::new(sea);
        let step = 2.0 * PI / sea.tile_m;
        let zeros = || vec![0.0_f32; n * n / 2];
        let (mut even_c, mut even_s, mut odd_c, mut odd_s) = (zeros(), zeros(), zeros(), zeros());
        let mut quarters = vec![0.0; n * n / 2];
        let per_block = n * LANES;
        let blocks = (
            even_c.par_chunks_mut(per_block),
            even_s.par_chunks_mut(per_block),
            odd_c.par_chunks_mut(per_block),
            odd_s.par_chunks_mut(per_block),
            quarters.par_chunks_mut(per_block),
        );
        // Waves do not depend on each other: the same for any number of threads.
        blocks.into_par_iter().enumerate().for_each(|(b, block)| {
            let (even_c, even_s, odd_c, odd_s, quarters) = block;
            for i in 0..per_block {
                let (row, column) = (b * LANES + i % LANES, i / LANES);
                // The Nyquist waves have no partner of opposite direction, so their
                // slopes would not be real; k = 0 is the mean height, which is 0.
                if column == n / 2 || (row == 0 && column == 0) {
                    continue;
                }
                let (kx, kz) = (signed(column, n) * step, row as f64 * step);
                let [a_re, a_im] = phillips.amplitude(row, column, kx, kz);
                let [b_re, b_im] = phillips.amplitude((n - row) % n, n - column, -kx, -kz);
                (even_c[i], even_s[i]) = (a_re + b_re, a_im + b_im);
                (odd_c[i], odd_s[i]) = (a_im - b_im, a_re - b_re);
                let hz = frequency_hz(libm::sqrt(kx * kx + kz * kz));
                let turns = sea.loop_s.map_or(hz, |loop_s| whole_turns(hz * loop_s));
                quarters[i] = 4.0 * turns;
            }
        });
        Self {
            even_c,
            even_s,
            odd_c,
            odd_s,
            quarters,
        }
    }

    // Every wave at a time, in seconds or loops. Loops over plain slices become
    // vector code; sine and cosine together would not.
    fn at(&self, time: f64, re: &mut [f32], im: &mut [f32]) {
        const PART: usize = 64;
        let (mut angle, mut quadrant) = ([0.0_f32; PART], [0_u32; PART]);
        for (part, (re, im)) in re.chunks_mut(PART).zip(im.chunks_mut(PART)).enumerate() {
            let len = re.len();
            let here = part * PART..part * PART + len;
            for (i, quarters) in self.quarters[here.clone()].iter().enumerate() {
                (angle[i], quadrant[i]) = reduce_quarters(quarters * time);
            }
            let (even_c, even_s) = (&self.even_c[here.clone()], &self.even_s[here.clone()]);
            let (odd_c, odd_s) = (&self.odd_c[here.clone()], &self.odd_s[here]);
            let im = &mut im[..len];
            for i in 0..len {
                let (sin, cos) = sin_cos_reduced(angle[i], quadrant[i]);
                re[i] = even_c[i] * cos + even_s[i] * sin;
                im[i] = odd_c[i] * cos - odd_s[i] * sin;
            }
        }
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

#[inline]
fn scaled(re: Vec4, im: Vec4, weight: Vec4) -> (Vec4, Vec4) {
    (re * weight, im * weight)
}

// 1/k; something finite for the mean, whose wave is 0.
#[inline]
fn inverse_length(kx: Vec4, kz: Vec4) -> Vec4 {
    let k2 = (kx * kx + kz * kz).max(Vec4::splat(f32::MIN_POSITIVE));
    Vec4::ONE / Vec4::from_array(k2.to_array().map(f32::sqrt))
}
