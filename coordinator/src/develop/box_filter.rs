//! Box filter of any radius at constant cost per pixel, without drift.
//!
//! The usual running sum adds the pixel that enters the window and subtracts
//! the one that leaves it; one pixel of 10^6 then leaves its rounding error
//! behind for the rest of the row. Here nothing is ever subtracted: the row is
//! cut into blocks as long as the window, prefix and suffix sums are taken
//! within each block, and a window, which touches two neighbouring blocks at
//! most, is one suffix plus one prefix (van Herk 1992; Gil & Werman 1993, there
//! for minima). Sums of zeros are exact zeros, sums of positive values are
//! positive, and the relative error is that of adding up the window itself.

use rayon::prelude::*;

/// Columns moved together by [`transpose`]: eight f64 fill a cache line.
const TRANSPOSE_COLUMNS: usize = 8;

/// Mean over the window of half-width `radius` (width 2 radius + 1) along each
/// row of `plane`, in place; beyond its ends a row continues with its end
/// values. Does nothing for `width` 0.
///
/// `plane` is row-major with rows of `width` finite values.
pub(super) fn box_rows(plane: &mut [f64], width: usize, radius: usize) {
    if width == 0 || radius == 0 {
        return;
    }
    plane
        .par_chunks_mut(width)
        .for_each_init(RowScratch::default, |scratch, row| {
            box_row(row, radius, scratch);
        });
}

/// Block sums of one row; kept between rows to save allocations.
#[derive(Default)]
struct RowScratch {
    /// Sum from the start of the block up to and including the entry.
    prefix: Vec<f64>,
    /// Sum from the entry up to and including the end of the block.
    suffix: Vec<f64>,
}

fn box_row(row: &mut [f64], radius: usize, scratch: &mut RowScratch) {
    let (Some(&first), Some(&last)) = (row.first(), row.last()) else {
        return;
    };
    // Most rows of most pictures: nothing bright in them.
    if row.iter().all(|&value| value == 0.0) {
        return;
    }
    let n = row.len();
    let window = 2 * radius + 1;
    fill_block_sums(row, window, scratch);
    let RowScratch { prefix, suffix } = scratch;
    // The last block may be cut off by the end of the row.
    let last_block = (n - 1) / window * window;
    let inverse = 1.0 / window as f64;
    for (i, out) in row.iter_mut().enumerate() {
        let from = i.saturating_sub(radius);
        let to = (i + radius).min(n - 1);
        // A suffix that covers its whole block is stored as zero, so that a
        // window of exactly one block is its prefix alone.
        let inside = if from > last_block {
            suffix[from]
        } else {
            suffix[from] + prefix[to]
        };
        let before = radius.saturating_sub(i) as f64 * first;
        let behind = (i + radius).saturating_sub(n - 1) as f64 * last;
        *out = (before + inside + behind) * inverse;
    }
}

fn fill_block_sums(row: &[f64], window: usize, scratch: &mut RowScratch) {
    scratch.prefix.clear();
    scratch.suffix.clear();
    scratch.suffix.resize(row.len(), 0.0);
    for (block, suffix) in row.chunks(window).zip(scratch.suffix.chunks_mut(window)) {
        let mut sum = 0.0;
        scratch.prefix.extend(block.iter().map(|value| {
            sum += value;
            sum
        }));
        let mut sum = 0.0;
        // Not the first entry: see `box_row`.
        for (value, out) in block.iter().zip(suffix).skip(1).rev() {
            sum += value;
            *out = sum;
        }
    }
}

/// `plane` (rows of `width` values) with rows and columns exchanged.
pub(super) fn transpose(plane: &[f64], width: usize) -> Vec<f64> {
    let mut out = vec![0.0; plane.len()];
    if width == 0 {
        return out;
    }
    let height = plane.len() / width;
    out.par_chunks_mut(height * TRANSPOSE_COLUMNS)
        .enumerate()
        .for_each(|(strip, columns)| {
            let x0 = strip * TRANSPOSE_COLUMNS;
            for (y, row) in plane.chunks_exact(width).enumerate() {
                for (column, &value) in columns.chunks_exact_mut(height).zip(&row[x0..]) {
                    column[y] = value;
                }
            }
        });
    out
}
