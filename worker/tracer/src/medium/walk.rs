//! A ray's way through the cells of a density grid.

use super::density::{Bounds, CELL_VOXELS, DensityGrid};
use glam::{UVec3, Vec3};

/// A piece of a ray inside a volume, `t0 < t1` in metres along the ray, with the ray
/// in voxels: `origin + direction * t`.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    /// Where it begins.
    pub t0: f32,
    /// Where it ends.
    pub t1: f32,
    /// The ray's origin in voxels.
    pub origin: Vec3,
    /// Voxels per metre along the ray.
    pub direction: Vec3,
}

impl Span {
    /// The point at distance `t`, in voxels.
    #[inline]
    #[must_use]
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + self.direction * t
    }
}

/// One cell on the way.
#[derive(Clone, Copy, Debug)]
pub struct Piece {
    /// Where the ray leaves the cell (or the span ends), metres along the ray.
    pub end: f32,
    /// What densities the cell has.
    pub bounds: Bounds,
}

/// The cells along a span, one after the other (Amanatides and Woo 1987, "A fast
/// voxel traversal algorithm"). Crossings are computed from the cell's number, not
/// added up, so no error grows; there are at most as many pieces as cells along the
/// three axes together.
pub struct Walk<'a> {
    grid: &'a DensityGrid,
    span: Span,
    cell: UVec3,
    next: Vec3,
    t: f32,
    done: bool,
}

impl<'a> Walk<'a> {
    /// A walk from the beginning of `span`.
    #[inline]
    #[must_use]
    pub fn new(grid: &'a DensityGrid, span: &Span) -> Self {
        let start = span.at(span.t0) / CELL_VOXELS as f32;
        // Saturating: below 0 is 0.
        let cell = start.as_uvec3().min(grid.cells() - UVec3::ONE);
        let mut walk = Self {
            grid,
            span: *span,
            cell,
            next: Vec3::ZERO,
            t: span.t0,
            done: false,
        };
        for axis in 0..3 {
            walk.next[axis] = walk.crossing(axis);
        }
        walk
    }

    // Where the ray leaves its cell along `axis`.
    #[inline]
    fn crossing(&self, axis: usize) -> f32 {
        let d = self.span.direction[axis];
        if d == 0.0 {
            return f32::INFINITY;
        }
        let wall = (self.cell[axis] + u32::from(d > 0.0)) * CELL_VOXELS;
        (wall as f32 - self.span.origin[axis]) / d
    }
}

impl Iterator for Walk<'_> {
    type Item = Piece;

    #[inline]
    fn next(&mut self) -> Option<Piece> {
        if self.done {
            return None;
        }
        let bounds = self.grid.bounds(self.cell);
        let next = self.next;
        let axis = if next.x <= next.y && next.x <= next.z {
            0
        } else if next.y <= next.z {
            1
        } else {
            2
        };
        // Roundings at a corner never lead back.
        let end = next[axis].min(self.span.t1).max(self.t);
        self.t = end;
        let moved = if self.span.direction[axis] > 0.0 {
            self.cell[axis] + 1
        } else {
            self.cell[axis].wrapping_sub(1)
        };
        if next[axis] >= self.span.t1 || moved >= self.grid.cells()[axis] {
            self.done = true;
            // What a rounding left over of the span belongs to the last cell.
            return Some(Piece {
                end: self.span.t1,
                bounds,
            });
        }
        self.cell[axis] = moved;
        self.next[axis] = self.crossing(axis);
        Some(Piece { end, bounds })
    }
}
