//! Where a moving mesh can be while the shutter is open.
//!
//! A cloud of points goes through the joints one by one, each joint at all its
//! times: the convex hull of the points, widened by `pad`, holds the mesh
//! throughout. Joints are taken to move independently, which can only be too wide.

use glam::{DAffine3, DVec3};

use super::mesh::TriMesh;
use super::motion::{Joint, Keyed, Motion, PIECES, Turn};

/// Meshes of more vertices are represented by boxes of their tree.
const VERTICES_MAX: usize = 1 << 14;
/// And so are larger ones that turn about an axis, each point of which is looked at.
const RING_VERTICES_MAX: usize = 1 << 18;
/// More points are replaced by the corners of their box.
const POINTS_MAX: usize = 1 << 17;
/// Sides of the polygon around a circle: 2 % wider than the circle.
const SIDES: usize = 16;
/// Turns beyond which the whole circle is taken.
const ARC_MAX: f64 = 0.25;
/// Samples of a shorter arc.
const ARC_SAMPLES: usize = 4;

const TAU: f64 = std::f64::consts::TAU;

struct Swept {
    points: Vec<DVec3>,
    pad: f64,
}

/// Bounds over the shutter; `None` without finite vertices. `exact` looks at every
/// vertex of a mesh that has not too many; otherwise boxes of its tree stand for them.
pub(super) fn swept_bounds(motion: &Motion, mesh: &TriMesh, exact: bool) -> Option<(DVec3, DVec3)> {
    let mut joints = motion.joints().iter().rev().peekable();
    let first = match joints.peek() {
        Some(Joint::Fixed(affine)) => {
            let affine = *affine;
            joints.next();
            affine
        }
        _ => DAffine3::IDENTITY,
    };
    let finite = mesh.positions().iter().filter(|p| p.is_finite());
    let vertices = finite.map(|p| first.transform_point3(p.as_dvec3()));
    let mut swept = Swept {
        points: Vec::new(),
        pad: 0.0,
    };
    match joints.peek() {
        _ if !exact => {
            let corners = mesh.root_corners();
            swept.points = corners.map(|p| first.transform_point3(p)).collect();
        }
        Some(Joint::Turn(turn))
            if is_whole(turn, motion.shutter_s) && mesh.positions().len() <= RING_VERTICES_MAX =>
        {
            swept.points = ring(turn, vertices);
            joints.next();
        }
        _ if mesh.positions().len() <= VERTICES_MAX => swept.points = vertices.collect(),
        _ => {
            let corners = mesh.inner_corners();
            swept.points = corners.map(|p| first.transform_point3(p)).collect();
        }
    }
    for joint in joints {
        swept.advance(joint, motion.shutter_s);
    }
    let (lo, hi) = bounds(&swept.points);
    let pad = DVec3::splat(swept.pad);
    lo.cmple(hi).all().then_some((lo - pad, hi + pad))
}

impl Swept {
    fn advance(&mut self, joint: &Joint, shutter_s: f64) {
        match joint {
            Joint::Fixed(affine) => {
                for p in &mut self.points {
                    *p = affine.transform_point3(*p);
                }
                // The Frobenius norm is no less than the largest stretch.
                let m = &affine.matrix3;
                let columns = m.x_axis.length_squared()
                    + m.y_axis.length_squared()
                    + m.z_axis.length_squared();
                self.pad *= columns.sqrt();
            }
            Joint::Slide(_) => self.sample(joint, &[0.0, shutter_s]),
            Joint::Turn(turn) if is_whole(turn, shutter_s) => {
                self.points = ring(turn, self.points.iter().copied());
            }
            Joint::Turn(turn) => {
                let radius = self.radius();
                let times: Vec<f64> = (0..=ARC_SAMPLES)
                    .map(|i| shutter_s * i as f64 / ARC_SAMPLES as f64)
                    .collect();
                self.sample(joint, &times);
                let angle = TAU * turn.rate.abs() * shutter_s / ARC_SAMPLES as f64;
                self.pad += bulge(angle) * radius;
            }
            Joint::Keyed(keyed) => {
                let radius = self.radius();
                let times: [f64; PIECES + 1] = std::array::from_fn(|i| keyed.piece_s * i as f64);
                self.sample(joint, &times);
                self.pad += bulge(largest_turn(keyed)) * radius;
            }
        }
    }

    /// The points at each of some times.
    fn sample(&mut self, joint: &Joint, times: &[f64]) {
        if self.points.len() * times.len() > POINTS_MAX {
            let (lo, hi) = bounds(&self.points);
            let bound = |corner: usize, axis: usize| [lo, hi][corner >> axis & 1][axis];
            self.points = (0..8)
                .map(|c| DVec3::new(bound(c, 0), bound(c, 1), bound(c, 2)))
                .collect();
        }
        let mut sampled = Vec::with_capacity(self.points.len() * times.len());
        for &time in times {
            let affine = joint.at(time);
            sampled.extend(self.points.iter().map(|&p| affine.transform_point3(p)));
        }
        self.points = sampled;
    }

    /// Largest distance from the origin of this space.
    fn radius(&self) -> f64 {
        let largest = self.points.iter().map(|p| p.length_squared());
        largest.fold(0.0, f64::max).sqrt() + self.pad
    }
}

fn is_whole(turn: &Turn, shutter_s: f64) -> bool {
    turn.rate.abs() * shutter_s > ARC_MAX
}

/// How far, in radii, a point that turns by up to `angle` radians in all leaves the
/// chord between its ends: the second derivative is at most `angle^2`.
fn bulge(angle: f64) -> f64 {
    (angle * angle / 8.0).min(2.0)
}

/// Radians about all three axes together within one piece.
fn largest_turn(keyed: &Keyed) -> f64 {
    let pieces = keyed.turns.windows(2);
    let turns = pieces.map(|w| (w[1] - w[0]).abs().element_sum());
    turns.fold(0.0, f64::max) * TAU
}

/// A prism around everything that some points sweep in a whole turn: the exact
/// largest radius and both heights.
fn ring(turn: &Turn, points: impl Iterator<Item = DVec3>) -> Vec<DVec3> {
    let axis = turn.axis;
    let (mut low, mut high, mut radius) = (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64);
    for p in points {
        let height = p.dot(axis);
        low = low.min(height);
        high = high.max(height);
        radius = radius.max((p - axis * height).length_squared());
    }
    if low > high {
        return Vec::new();
    }
    let (u, v) = axis.any_orthonormal_pair();
    let reach = radius.sqrt() / libm::cos(TAU * 0.5 / SIDES as f64);
    let mut prism = Vec::with_capacity(2 * SIDES);
    for side in 0..SIDES {
        let angle = TAU * side as f64 / SIDES as f64;
        let rim = (u * libm::cos(angle) + v * libm::sin(angle)) * reach;
        prism.extend([rim + axis * low, rim + axis * high]);
    }
    prism
}

fn bounds(points: &[DVec3]) -> (DVec3, DVec3) {
    points
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), &p| {
            (lo.min(p), hi.max(p))
        })
}
