//! A distribution over the directions of an equirectangular map.

use super::AliasTable;
use std::f32::consts::PI;

/// Most cells of the sampling table. Finer maps are sampled in blocks of texels:
/// the table then stays in cache, and a block's texels still all can be drawn.
const CELLS_MAX: usize = 1 << 19;

/// Largest block of texels along each side.
const BLOCK_MAX: usize = 64;

/// Share of the mean below which what lies above it is no light but the rounding
/// of a block's sum: 64 x 64 texels in f32 err by 2.4e-4 at most.
const ROUNDING: f64 = 1e-3;

/// A distribution over blocks of texels.
#[derive(Clone, Debug)]
pub(super) struct CellTables {
    cells_x: usize,
    cells_y: usize,
    /// Probability of a cell times the number of cells: the density in (u, v).
    pub(super) density: Vec<f32>,
    /// Which row of cells.
    rows: AliasTable,
    /// Which cell of a row; absent for black rows. Two draws of 24 bits each leave
    /// both choices fine enough, where one draw for all cells would not.
    columns: Vec<Option<AliasTable>>,
}

impl CellTables {
    /// Tables of a map's radiance above `below`; `None` when there is none.
    pub(super) fn new(width: usize, height: usize, rgb: &[[f32; 3]], below: f64) -> Option<Self> {
        let (cells_x, cells_y, mut weights) = cell_weights(width, height, rgb);
        if below > 0.0 {
            subtract(&mut weights, below, (width, height), (cells_x, cells_y));
        }
        let total: f64 = weights.iter().map(|&w| f64::from(w)).sum();
        let row_weights: Vec<f32> = weights
            .chunks(cells_x)
            .map(|row| row.iter().sum())
            .collect();
        let rows = AliasTable::new(&row_weights)?;
        let columns = weights.chunks(cells_x).map(AliasTable::new).collect();
        let scale = weights.len() as f64 / total;
        let density = weights
            .iter()
            .map(|&w| (f64::from(w) * scale) as f32)
            .collect();
        Some(Self {
            cells_x,
            cells_y,
            density,
            rows,
            columns,
        })
    }

    // Density per solid angle at (u, v).
    #[inline]
    pub(super) fn pdf(&self, uv: [f32; 2], sin_theta: f32) -> f32 {
        let x = ((uv[0] * self.cells_x as f32) as usize).min(self.cells_x - 1);
        let y = ((uv[1] * self.cells_y as f32) as usize).min(self.cells_y - 1);
        if sin_theta > 0.0 {
            self.density[y * self.cells_x + x] / (2.0 * PI * PI * sin_theta)
        } else {
            0.0
        }
    }

    // A point (u, v) of the map and its density there.
    #[inline]
    pub(super) fn sample(&self, u: [f32; 2]) -> Option<([f32; 2], f32)> {
        let (row, rest_v) = self.rows.sample(u[0]);
        let (column, rest_u) = self.columns[row as usize].as_ref()?.sample(u[1]);
        let density = self.density[row as usize * self.cells_x + column as usize];
        let uv = [
            (column as f32 + rest_u) / self.cells_x as f32,
            (row as f32 + rest_v) / self.cells_y as f32,
        ];
        (density > 0.0).then_some((uv, density))
    }
}

// Take from each cell what radiance `below` all over it would give it. By whole
// cells: what is left is proportional to the light above the mean, blurred to the
// cells' size, and any such density is right (the surfaces find the rest).
fn subtract(
    weights: &mut [f32],
    below: f64,
    (width, height): (usize, usize),
    (cells_x, cells_y): (usize, usize),
) {
    let (block_x, block_y) = (width / cells_x, height / cells_y);
    for (cell_y, row) in weights.chunks_mut(cells_x).enumerate() {
        let rows = cell_y * block_y..(cell_y + 1) * block_y;
        let sines: f64 = rows.map(|y| f64::from(row_sine(y, height))).sum();
        let share = below * sines * block_x as f64;
        for weight in row {
            let above = f64::from(*weight) - share;
            // An even map has nothing above its mean but rounding errors.
            *weight = if above > ROUNDING * share {
                above as f32
            } else {
                0.0
            };
        }
    }
}

// The solid angle of a texel of row `y`, up to a common factor.
fn row_sine(y: usize, height: usize) -> f32 {
    libm::sin(std::f64::consts::PI * (y as f64 + 0.5) / height as f64) as f32
}

// The integral of the interpolated luminance over each cell, up to a common
// factor. A texel's footprint sees its neighbours with weights (1, 6, 1) / 8 along
// each axis (the integral of the bilinear hat), so a cell has weight 0 only if the
// interpolated map is black all over it: no light is ever missed.
fn cell_weights(width: usize, height: usize, rgb: &[[f32; 3]]) -> (usize, usize, Vec<f32>) {
    // Larger blocks are not worth it, and some sizes have no common divisor.
    let fits = |b: &usize| {
        width.div_ceil(*b) * height.div_ceil(*b) <= CELLS_MAX
            && width.is_multiple_of(*b)
            && height.is_multiple_of(*b)
    };
    let block = (1..=BLOCK_MAX).find(fits).unwrap_or(1);
    let (cells_x, cells_y) = (width / block, height / block);
    // The brightest channel: no colour may go unseen.
    let light: Vec<f32> = rgb.iter().map(|c| c[0].max(c[1]).max(c[2])).collect();
    let mut weights = vec![0.0f32; cells_x * cells_y];
    for y in 0..height {
        let sin_theta = row_sine(y, height);
        let rows = [
            (y.saturating_sub(1), 0.125f32),
            (y, 0.75),
            ((y + 1).min(height - 1), 0.125),
        ];
        for x in 0..width {
            let columns = [
                ((x + width - 1) % width, 0.125f32),
                (x, 0.75),
                ((x + 1) % width, 0.125),
            ];
            let mut sum = 0.0;
            for (row, wy) in rows {
                for (column, wx) in columns {
                    sum += light[row * width + column] * (wx * wy);
                }
            }
            weights[y / block * cells_x + x / block] += sum * sin_theta;
        }
    }
    (cells_x, cells_y, weights)
}
