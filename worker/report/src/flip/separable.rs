//! Filters along rows and columns, edges repeated.

use super::Plane;
use rayon::prelude::*;

/// Filter along rows: for each pixel `sum over taps of weigh(tap, source)`, with
/// `source` the value of the neighbour; pixels beyond an edge are those at it.
pub(super) fn along_rows<S: Copy + Sync, const N: usize>(
    (width, height): (usize, usize),
    source: &[S],
    radius: usize,
    weigh: impl Fn(usize, S) -> [f32; N] + Sync,
) -> Vec<[f32; N]> {
    let mut out = vec![[0.0; N]; width * height];
    out.par_chunks_mut(width.max(1))
        .zip(source.par_chunks(width.max(1)))
        .for_each(|(out, row)| {
            for (x, value) in out.iter_mut().enumerate() {
                for tap in 0..=2 * radius {
                    let at = (x + tap).saturating_sub(radius).min(width - 1);
                    add(value, weigh(tap, row[at]));
                }
            }
        });
    out
}

/// The same along columns.
pub(super) fn along_columns<S: Copy + Sync, const N: usize>(
    (width, height): (usize, usize),
    source: &[S],
    radius: usize,
    weigh: impl Fn(usize, S) -> [f32; N] + Sync,
) -> Vec<[f32; N]> {
    let mut out = vec![[0.0; N]; width * height];
    out.par_chunks_mut(width.max(1))
        .enumerate()
        .for_each(|(y, out)| {
            for tap in 0..=2 * radius {
                let at = (y + tap).saturating_sub(radius).min(height - 1);
                let row = &source[at * width..(at + 1) * width];
                for (value, &neighbour) in out.iter_mut().zip(row) {
                    add(value, weigh(tap, neighbour));
                }
            }
        });
    out
}

fn add<const N: usize>(sum: &mut [f32; N], more: [f32; N]) {
    for (sum, more) in sum.iter_mut().zip(more) {
        *sum += more;
    }
}

/// Apply a function to every pixel.
pub(super) fn map_pixels(
    plane: &Plane<'_>,
    f: impl Fn([f32; 3]) -> [f32; 3] + Sync,
) -> Vec<[f32; 3]> {
    plane.rgb.par_iter().map(|&rgb| f(rgb)).collect()
}
