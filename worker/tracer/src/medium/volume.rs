//! One volume, placed.

use super::density::DensityGrid;
use super::phase::Phase;
use super::walk::Span;
use crate::geometry::Ray;
use glam::{Mat3, Vec3};

/// Where a volume ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outline {
    /// At the faces of its grid.
    Box,
    /// At the ellipsoid that touches them.
    Ellipsoid,
}

/// How light finds its way through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// Unbiased.
    Tracking,
    /// Fixed steps of so many metres.
    March {
        /// Length of a step.
        step_m: f32,
    },
}

/// A volume in render space, ready to be asked.
#[derive(Clone, Debug)]
pub struct Volume {
    /// Density in units of [`Volume::sigma_t_per_m`].
    pub density: DensityGrid,
    /// Extinction at density 1, per metre.
    pub sigma_t_per_m: f32,
    /// How it scatters.
    pub phase: Phase,
    /// Tracking or marching.
    pub method: Method,
    /// Where it ends.
    pub outline: Outline,
    /// Centre in render space, metres.
    pub centre: Vec3,
    /// Takes offsets from the centre to voxels.
    pub voxels_from_world: Mat3,
}

impl Volume {
    /// The piece of a ray up to `t_limit` that lies inside.
    #[inline]
    #[must_use]
    pub fn span(&self, ray: &Ray, t_limit: f32) -> Option<Span> {
        let half = self.density.size().as_vec3() * 0.5;
        let from_centre = self.voxels_from_world * (ray.o - self.centre);
        let direction = self.voxels_from_world * ray.d;
        let (enter, leave) = match self.outline {
            Outline::Box => through_box(from_centre, direction, half),
            Outline::Ellipsoid => through_ball(from_centre / half, direction / half),
        }?;
        let (t0, t1) = (enter.max(0.0), leave.min(t_limit));
        // An infinite end would only come from a ray without direction.
        (t0 < t1 && t1.is_finite()).then_some(Span {
            t0,
            t1,
            origin: from_centre + half,
            direction,
        })
    }

    /// Extinction at a point in voxels, per metre.
    #[inline]
    #[must_use]
    pub fn sigma_t(&self, p: Vec3) -> f32 {
        self.sigma_t_per_m * self.density.density(p)
    }
}

// Slabs (Kay and Kajiya 1986); a ray along a face is inside if its origin is.
#[inline]
fn through_box(o: Vec3, d: Vec3, half: Vec3) -> Option<(f32, f32)> {
    let (mut enter, mut leave) = (f32::NEG_INFINITY, f32::INFINITY);
    for axis in 0..3 {
        if d[axis] == 0.0 {
            if o[axis].abs() > half[axis] {
                return None;
            }
            continue;
        }
        let (a, b) = (
            (-half[axis] - o[axis]) / d[axis],
            (half[axis] - o[axis]) / d[axis],
        );
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    (enter < leave).then_some((enter, leave))
}

// The unit ball, from the point of the ray nearest to its centre: a far origin does
// not cancel.
#[inline]
fn through_ball(o: Vec3, d: Vec3) -> Option<(f32, f32)> {
    let d2 = d.length_squared();
    let middle = -o.dot(d) / d2;
    let nearest = o + d * middle;
    let rest = (1.0 - nearest.length_squared()) / d2;
    if rest > 0.0 {
        let reach = rest.sqrt();
        Some((middle - reach, middle + reach))
    } else {
        None
    }
}
