//! A density on a grid, interpolated, with exact bounds for each of its cells.

use glam::{UVec3, Vec3};

/// Voxels along the side of a cell: the bounds of 8^3 voxels are tight enough for
/// clouds, and walking from cell to cell stays cheap.
pub(super) const CELL_VOXELS: u32 = 8;

/// Smallest and largest density that a lookup in a cell can give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest.
    pub min: f32,
    /// Largest.
    pub max: f32,
}

/// Densities at the centres of voxels, at least 0, and trilinear in between; beyond
/// the outermost centres they stay as they are. Coordinates count voxels: voxel i
/// reaches from i to i + 1.
#[derive(Clone, Debug, PartialEq)]
pub struct DensityGrid {
    size: UVec3,
    values: Vec<f32>,
    cells: UVec3,
    bounds: Vec<Bounds>,
}

impl DensityGrid {
    /// A grid of `size` voxels (each side at least 1), x fastest. `None` when
    /// `values` are not as many, or one is negative or not finite.
    #[must_use]
    pub fn new(size: UVec3, values: Vec<f32>) -> Option<Self> {
        let count = (size.x as usize)
            .checked_mul(size.y as usize)?
            .checked_mul(size.z as usize)?;
        let bad = |v: &f32| !(v.is_finite() && *v >= 0.0);
        if count == 0 || count != values.len() || values.iter().any(bad) {
            return None;
        }
        let mut grid = Self {
            size,
            values,
            cells: (size - UVec3::ONE) / CELL_VOXELS + UVec3::ONE,
            bounds: Vec::new(),
        };
        grid.bounds = (0..grid.cells.z)
            .flat_map(|z| (0..grid.cells.y).map(move |y| (y, z)))
            .flat_map(|(y, z)| (0..grid.cells.x).map(move |x| UVec3::new(x, y, z)))
            .map(|cell| grid.bounds_of_voxels(cell))
            .collect();
        Some(grid)
    }

    /// Voxels along each axis.
    #[must_use]
    pub fn size(&self) -> UVec3 {
        self.size
    }

    /// Cells along each axis.
    #[must_use]
    pub fn cells(&self) -> UVec3 {
        self.cells
    }

    /// Bounds of every lookup within a cell; its index must be below
    /// [`DensityGrid::cells`].
    #[inline]
    #[must_use]
    pub fn bounds(&self, cell: UVec3) -> Bounds {
        let row = cell.z as usize * self.cells.y as usize + cell.y as usize;
        self.bounds[row * self.cells.x as usize + cell.x as usize]
    }

    /// Largest density.
    #[must_use]
    pub fn max(&self) -> f32 {
        self.bounds.iter().fold(0.0, |max, b| b.max.max(max))
    }

    /// The density at `p`, in voxels; points outside count as the nearest inside.
    #[inline]
    #[must_use]
    pub fn density(&self, p: Vec3) -> f32 {
        let last = self.size - UVec3::ONE;
        let at = (p - 0.5).max(Vec3::ZERO).min(last.as_vec3());
        // Positive, so the conversion rounds down; NaN becomes 0.
        let low = at.as_uvec3().min(last);
        let high = (low + UVec3::ONE).min(last);
        let f = at - low.as_vec3();
        let (width, slice) = (
            self.size.x as usize,
            self.size.x as usize * self.size.y as usize,
        );
        let along_x = |row: usize| {
            let (a, b) = (
                self.values[row + low.x as usize],
                self.values[row + high.x as usize],
            );
            a + (b - a) * f.x
        };
        let (y0, y1) = (low.y as usize * width, high.y as usize * width);
        let (z0, z1) = (low.z as usize * slice, high.z as usize * slice);
        let (a, b) = (along_x(z0 + y0), along_x(z0 + y1));
        let near = a + (b - a) * f.y;
        let (a, b) = (along_x(z1 + y0), along_x(z1 + y1));
        let far = a + (b - a) * f.y;
        near + (far - near) * f.z
    }

    // A trilinear value lies between those of its eight corners. A lookup in the
    // cell [8 c, 8 c + 8] reads voxels 8 c - 1 to 8 c + 8, and still the same ones
    // when a rounding puts it up to half a voxel outside.
    fn bounds_of_voxels(&self, cell: UVec3) -> Bounds {
        let first = (cell * CELL_VOXELS).saturating_sub(UVec3::ONE);
        let last = (cell * CELL_VOXELS + CELL_VOXELS).min(self.size - UVec3::ONE);
        let mut bounds = Bounds {
            min: f32::INFINITY,
            max: 0.0,
        };
        for z in first.z..=last.z {
            for y in first.y..=last.y {
                let row = (z as usize * self.size.y as usize + y as usize) * self.size.x as usize;
                for value in &self.values[row + first.x as usize..=row + last.x as usize] {
                    bounds.min = bounds.min.min(*value);
                    bounds.max = bounds.max.max(*value);
                }
            }
        }
        bounds
    }
}
