//! An inverse FFT of our own in f32, from half a spectrum to a real field.
//!
//! Stockham's radix-4 algorithm (see Van Loan, "Computational Frameworks for the
//! Fast Fourier Transform", 1992, section 1.7): no bit reversal, and [`LANES`]
//! transforms run side by side, in vectors of four (the compiler makes a fifth of
//! the speed of plain arrays here). Libraries take twiddles from the platform or pick
//! algorithms by CPU; these are the same operations in the same order everywhere.
//!
//! A real field has h(-k) = conj h(k). So only kz = 0 .. n/2 - 1 is given (the
//! Nyquist waves are absent), the first pass transforms n/2 rows along x, and the
//! second packs two real columns into one complex one: half the work of a complex
//! transform.

use glam::Vec4;
use std::f64::consts::PI;

/// Transforms side by side: two SSE registers. A multiple of it must divide half
/// of the smallest grid, 16.
pub(super) const LANES: usize = 8;

/// Vectors of an entry.
pub(super) const VECTORS: usize = LANES / 4;

/// Twiddles of one butterfly: w, w^2, w^3, each as (re, im).
type Turn = [f32; 6];

/// What all transforms of one length share.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    n: usize,
    /// Twiddles of each radix-4 stage.
    stages: Vec<Vec<Turn>>,
}

/// Complex numbers, `LANES` to an entry, real and imaginary parts apart.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub re: Vec<Vec4>,
    pub im: Vec<Vec4>,
}

impl Block {
    /// `len` entries of zeros.
    pub(super) fn new(len: usize) -> Self {
        Self {
            re: vec![Vec4::ZERO; len * VECTORS],
            im: vec![Vec4::ZERO; len * VECTORS],
        }
    }
}

/// Buffers of a transform, to be used again.
#[derive(Debug)]
pub(super) struct Scratch {
    /// Input of the next transform.
    pub input: Block,
    other: Block,
    // After the first pass: row kz, column x; n floats a row.
    half_re: Vec<f32>,
    half_im: Vec<f32>,
}

impl Plan {
    /// For `n` points, a power of two of at least 16.
    pub(super) fn new(n: usize) -> Self {
        let mut stages = Vec::new();
        let mut len = n;
        while len >= 4 {
            let angle = 2.0 * PI / len as f64;
            let turn = |p: usize| -> Turn {
                let part = |j: usize| {
                    let a = angle * (j * p) as f64;
                    [libm::cos(a) as f32, libm::sin(a) as f32]
                };
                let [[a, b], [c, d], [e, f]] = [part(1), part(2), part(3)];
                [a, b, c, d, e, f]
            };
            stages.push((0..len / 4).map(turn).collect());
            len /= 4;
        }
        Self { n, stages }
    }

    /// Buffers for this length.
    pub(super) fn scratch(&self) -> Scratch {
        let half = self.n / 2 * self.n;
        Scratch {
            input: Block::new(self.n),
            other: Block::new(self.n),
            half_re: vec![0.0; half],
            half_im: vec![0.0; half],
        }
    }

    /// Sum over all k of h(k) e^{ikx}, real. `fill(b, block)` must set entry
    /// i, lane l of the block to h at column frequency i (n - 1 is -1) and row
    /// frequency `b * LANES + l`; entry n/2 must be zero. Rows of the result run
    /// along x.
    pub(super) fn inverse_real(
        &self,
        scratch: &mut Scratch,
        mut fill: impl FnMut(usize, &mut Block),
    ) -> Vec<f32> {
        let n = self.n;
        for b in 0..n / (2 * LANES) {
            fill(b, &mut scratch.input);
            self.run(&mut scratch.input, &mut scratch.other);
            let rows = b * LANES * n..(b + 1) * LANES * n;
            transpose(&scratch.input.re, &mut scratch.half_re[rows.clone()]);
            transpose(&scratch.input.im, &mut scratch.half_im[rows]);
        }
        let mut field = vec![0.0; n * n];
        for x in (0..n).step_by(2 * LANES) {
            self.pack_columns(scratch, x);
            self.run(&mut scratch.input, &mut scratch.other);
            let (left, right) = (&scratch.input.re, &scratch.input.im);
            let columns = left.chunks_exact(VECTORS).zip(right.chunks_exact(VECTORS));
            for (row, (left, right)) in field.chunks_exact_mut(n).zip(columns) {
                row[x..x + LANES].copy_from_slice(bytemuck::cast_slice(left));
                row[x + LANES..x + 2 * LANES].copy_from_slice(bytemuck::cast_slice(right));
            }
        }
        field
    }

    // Columns x .. x + LANES as A and the next LANES as B: A + iB, and at -kz, by
    // symmetry, conj A + i conj B.
    fn pack_columns(&self, scratch: &mut Scratch, x: usize) {
        let n = self.n;
        let Block { re, im } = &mut scratch.input;
        for v in 0..VECTORS {
            // The mean over z is real but for rounding; Nyquist waves are absent.
            let at = x + 4 * v;
            re[v] = Vec4::from_slice(&scratch.half_re[at..]);
            im[v] = Vec4::from_slice(&scratch.half_re[at + LANES..]);
            re[n / 2 * VECTORS + v] = Vec4::ZERO;
            im[n / 2 * VECTORS + v] = Vec4::ZERO;
        }
        for kz in 1..n / 2 {
            let half_re = &scratch.half_re[kz * n + x..][..2 * LANES];
            let half_im = &scratch.half_im[kz * n + x..][..2 * LANES];
            for v in 0..VECTORS {
                let a_re = Vec4::from_slice(&half_re[4 * v..]);
                let a_im = Vec4::from_slice(&half_im[4 * v..]);
                let b_re = Vec4::from_slice(&half_re[LANES + 4 * v..]);
                let b_im = Vec4::from_slice(&half_im[LANES + 4 * v..]);
                let (here, mirror) = (kz * VECTORS + v, (n - kz) * VECTORS + v);
                (re[here], im[here]) = (a_re - b_im, a_im + b_re);
                (re[mirror], im[mirror]) = (a_re + b_im, b_re - a_im);
            }
        }
    }

    // Transform `data` in every lane; `other` is overwritten.
    fn run(&self, data: &mut Block, other: &mut Block) {
        let mut stride = VECTORS;
        for turns in &self.stages {
            let quarter = turns.len() * stride;
            for (p, turn) in turns.iter().enumerate() {
                // The first is no turn.
                if p == 0 {
                    radix4::<false>(data, other, 0, quarter, stride, turn);
                } else {
                    radix4::<true>(data, other, p * stride, quarter, stride, turn);
                }
            }
            std::mem::swap(data, other);
            stride *= 4;
        }
        if stride < self.n * VECTORS {
            radix2(data, other, stride);
            std::mem::swap(data, other);
        }
    }
}

// Vectors first .. first + len and the same of the other three quarters; the four
// results lie one after another from 4 * first.
#[inline]
fn radix4<const TURN: bool>(
    from: &Block,
    to: &mut Block,
    first: usize,
    quarter: usize,
    len: usize,
    turn: &Turn,
) {
    let [a_re, b_re, c_re, d_re] = quarters(&from.re, first, quarter, len);
    let [a_im, b_im, c_im, d_im] = quarters(&from.im, first, quarter, len);
    let [p_re, q_re, r_re, s_re] = results(&mut to.re, first, len);
    let [p_im, q_im, r_im, s_im] = results(&mut to.im, first, len);
    let [w1_re, w1_im, w2_re, w2_im, w3_re, w3_im] = turn.map(Vec4::splat);
    let times = |re: Vec4, im: Vec4, w_re: Vec4, w_im: Vec4| {
        if TURN {
            (re * w_re - im * w_im, re * w_im + im * w_re)
        } else {
            (re, im)
        }
    };
    for i in 0..len {
        let (ac_re, ac_im) = (a_re[i] + c_re[i], a_im[i] + c_im[i]);
        let (a_c_re, a_c_im) = (a_re[i] - c_re[i], a_im[i] - c_im[i]);
        let (bd_re, bd_im) = (b_re[i] + d_re[i], b_im[i] + d_im[i]);
        let (b_d_re, b_d_im) = (b_re[i] - d_re[i], b_im[i] - d_im[i]);
        (p_re[i], p_im[i]) = (ac_re + bd_re, ac_im + bd_im);
        (q_re[i], q_im[i]) = times(a_c_re - b_d_im, a_c_im + b_d_re, w1_re, w1_im);
        (r_re[i], r_im[i]) = times(ac_re - bd_re, ac_im - bd_im, w2_re, w2_im);
        (s_re[i], s_im[i]) = times(a_c_re + b_d_im, a_c_im - b_d_re, w3_re, w3_im);
    }
}

#[inline]
fn quarters(values: &[Vec4], first: usize, quarter: usize, len: usize) -> [&[Vec4]; 4] {
    [0, 1, 2, 3].map(|j| &values[first + j * quarter..][..len])
}

#[inline]
fn results(values: &mut [Vec4], first: usize, len: usize) -> [&mut [Vec4]; 4] {
    let (low, high) = values[4 * first..][..4 * len].split_at_mut(2 * len);
    let ((a, b), (c, d)) = (low.split_at_mut(len), high.split_at_mut(len));
    [a, b, c, d]
}

// The last stage of an odd power of two: both halves, no twiddles.
fn radix2(from: &Block, to: &mut Block, half: usize) {
    for (from, to) in [(&from.re, &mut to.re), (&from.im, &mut to.im)] {
        let (a, b) = from.split_at(half);
        let (sum, difference) = to.split_at_mut(half);
        for i in 0..half {
            sum[i] = a[i] + b[i];
            difference[i] = a[i] - b[i];
        }
    }
}

// Lane l of entry x to row l, column x.
fn transpose(block: &[Vec4], rows: &mut [f32]) {
    let block: &[f32] = bytemuck::cast_slice(block);
    for (lane, row) in rows.chunks_exact_mut(block.len() / LANES).enumerate() {
        for (value, lanes) in row.iter_mut().zip(block.chunks_exact(LANES)) {
            *value = lanes[lane];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::mix64;
    use num_complex::Complex;

    // A Hermitian spectrum without Nyquist waves.
    fn spectrum(n: usize) -> Vec<Complex<f64>> {
        let unit = |key: usize| (mix64(key as u64) >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
        let mut h = vec![Complex::new(0.0, 0.0); n * n];
        for row in 0..n {
            for column in 0..n {
                let mirror = (n - row) % n * n + (n - column) % n;
                let at = row * n + column;
                if row == n / 2 || column == n / 2 || at > mirror {
                    continue;
                }
                let im = if at == mirror { 0.0 } else { unit(2 * at + 1) };
                h[at] = Complex::new(unit(2 * at), im);
                h[mirror] = h[at].conj();
            }
        }
        h
    }

    // The library in f64, from the whole spectrum; every size, odd powers too.
    #[test]
    fn the_transform_is_the_library_s() {
        for n in [16usize, 32, 64, 256, 512] {
            let h = spectrum(n);
            let plan = Plan::new(n);
            let ours = plan.inverse_real(&mut plan.scratch(), |b, block| {
                let re: &mut [f32] = bytemuck::cast_slice_mut(&mut block.re);
                let im: &mut [f32] = bytemuck::cast_slice_mut(&mut block.im);
                for (i, (re, im)) in re.iter_mut().zip(im).enumerate() {
                    let value = h[(b * LANES + i % LANES) * n + i / LANES];
                    (*re, *im) = (value.re as f32, value.im as f32);
                }
            });
            let mut theirs = h;
            let fft = rustfft::FftPlanner::new().plan_fft_inverse(n);
            for _ in 0..2 {
                fft.process(&mut theirs);
                theirs = (0..n * n).map(|i| theirs[i % n * n + i / n]).collect();
            }
            let rms = libm::sqrt(theirs.iter().map(Complex::norm_sqr).sum::<f64>()) / n as f64;
            for (i, (a, b)) in ours.iter().zip(&theirs).enumerate() {
                let error = (f64::from(*a) - b.re).abs();
                assert!(error < 2e-6 * rms, "{n}, {i}: {a} is not {}", b.re);
                assert!(b.im.abs() < 1e-12 * rms);
            }
        }
    }
}
