//! Steel members: boxes, beams between two points, prisms.

use crate::loft::frame;
use crate::mesh::Mesh;
use crate::vec3::{Vec3, vec3};

/// Corners of a box as (low/high x, low/high y, low/high z) bits.
const FACES: [[usize; 4]; 6] = [
    [0, 4, 6, 2],
    [1, 3, 7, 5],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 2, 3, 1],
    [4, 5, 7, 6],
];

/// Box with edges along the axes.
pub(super) fn block(mesh: &mut Mesh, low: Vec3, high: Vec3) {
    let corners = corners(|bx, by, bz| {
        vec3(
            if bx { high.x } else { low.x },
            if by { high.y } else { low.y },
            if bz { high.z } else { low.z },
        )
    });
    hexahedron(mesh, corners);
}

/// Box of the given half sizes around `middle`.
pub(super) fn block_around(mesh: &mut Mesh, middle: Vec3, half: Vec3) {
    block(mesh, middle - half, middle + half);
}

/// Straight beam of rectangular section from `a` to `b`: `width` sideways and
/// `height` upwards (for an upright beam: along z and x).
pub(super) fn beam(mesh: &mut Mesh, a: Vec3, b: Vec3, width: f64, height: f64) {
    let (right, up) = frame((b - a).normalized());
    let corners = corners(|bx, by, bz| {
        let sign = |bit: bool| if bit { 0.5 } else { -0.5 };
        (if bz { b } else { a }) + right * (width * sign(bx)) + up * (height * sign(by))
    });
    hexahedron(mesh, corners);
}

/// Beam of I section: two flanges and a web between them.
pub(super) fn i_beam(mesh: &mut Mesh, a: Vec3, b: Vec3, width: f64, height: f64, plate: f64) {
    let (_, up) = frame((b - a).normalized());
    let lift = up * (0.5 * (height - plate));
    beam(mesh, a + lift, b + lift, width, plate);
    beam(mesh, a - lift, b - lift, width, plate);
    beam(mesh, a, b, plate, height - 2.0 * plate);
}

fn corners(at: impl Fn(bool, bool, bool) -> Vec3) -> [Vec3; 8] {
    std::array::from_fn(|i| at(i & 1 != 0, i & 2 != 0, i & 4 != 0))
}

fn hexahedron(mesh: &mut Mesh, corners: [Vec3; 8]) {
    let indices = corners.map(|p| mesh.vertex(p));
    for face in FACES {
        mesh.face(&face.map(|i| indices[i]));
    }
}

/// A plan outline (x, z), anticlockwise seen from below (x towards z), and a
/// height, for [`prism`].
pub(super) struct Level {
    /// Height of the level.
    pub y: f64,
    /// Factors of the outline in x and z.
    pub scale: (f64, f64),
}

/// Upright solid over a star-shaped outline around `middle`, scaled from level
/// to level; closed at both ends.
pub(super) fn prism(mesh: &mut Mesh, middle: Vec3, outline: &[(f64, f64)], levels: &[Level]) {
    let rings: Vec<Vec<Vec3>> = levels
        .iter()
        .map(|level| {
            outline
                .iter()
                .rev()
                .map(|&(x, z)| {
                    vec3(
                        middle.x + x * level.scale.0,
                        level.y,
                        middle.z + z * level.scale.1,
                    )
                })
                .collect()
        })
        .collect();
    crate::loft::loft(mesh, &rings, crate::loft::End::Fan, crate::loft::End::Fan);
}

/// Outline of unit half sizes whose corners are stepped like a stair: the plan
/// of a fluted leg. `steps` descends in x and ascends in z.
#[must_use]
pub(super) fn stepped_outline(steps: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut quarter = Vec::new();
    for (i, &(x, z)) in steps.iter().enumerate() {
        if i > 0 {
            quarter.push((x, steps[i - 1].1));
        }
        quarter.push((x, z));
    }
    let mut outline = quarter.clone();
    outline.extend(quarter.iter().rev().map(|&(x, z)| (-x, z)));
    outline.extend(quarter.iter().map(|&(x, z)| (-x, -z)));
    outline.extend(quarter.iter().rev().map(|&(x, z)| (x, -z)));
    outline
}

/// Outline of a rectangle of unit half sizes with round ends in x.
#[must_use]
pub(super) fn boat_outline(sides: usize) -> Vec<(f64, f64)> {
    (0..sides)
        .map(|i| {
            let angle = std::f64::consts::TAU * i as f64 / sides as f64;
            let power = |v: f64, e: f64| crate::curve::signed_pow(v, e);
            (power(libm::cos(angle), 0.9), power(libm::sin(angle), 0.55))
        })
        .collect()
}
