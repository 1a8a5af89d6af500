//! Lifting surfaces: a skin over airfoil ribs, closed at both tips.

use crate::airfoil::Airfoil;
use crate::mesh::Mesh;
use crate::vec3::{Vec3, vec3};

/// One section of a wing, a tailplane or a fin; its chord runs along +z.
pub(super) struct Rib {
    /// Leading edge.
    pub front: Vec3,
    /// Chord length.
    pub chord: f64,
    /// Nose-up turn about the quarter chord, radians (small).
    pub twist: f64,
    /// The section.
    pub airfoil: Airfoil,
}

/// Texture coordinates of a point of the skin, on the upper or lower side.
pub(super) type SideUv<'a> = &'a dyn Fn(Vec3, bool) -> [f64; 2];

/// Skins the ribs; `lift` is the direction of the sections' upper side, and
/// the ribs follow each other along `lift` x (-z). `half` steps per side.
pub(super) fn skin(mesh: &mut Mesh, ribs: &[Rib], lift: Vec3, half: usize, uv: SideUv) {
    let count = 2 * half;
    let mut rings: Vec<Vec<u32>> = Vec::new();
    let mut uvs: Vec<[Vec<u32>; 2]> = Vec::new();
    for rib in ribs {
        let points: Vec<Vec3> = rib
            .airfoil
            .outline(half)
            .iter()
            .map(|&(x, y)| {
                let along = x * rib.chord;
                let up = y * rib.chord - rib.twist * (along - 0.25 * rib.chord);
                rib.front + vec3(0.0, 0.0, along) + lift * up
            })
            .collect();
        rings.push(points.iter().map(|&p| mesh.vertex(p)).collect());
        uvs.push([
            points.iter().map(|&p| mesh.uv(uv(p, true))).collect(),
            points.iter().map(|&p| mesh.uv(uv(p, false))).collect(),
        ]);
    }
    for i in 0..rings.len().saturating_sub(1) {
        for j in 0..count {
            let k = (j + 1) % count;
            let side = usize::from(j >= half);
            let at = |ring: usize, point: usize| (rings[ring][point], uvs[ring][side][point]);
            mesh.face_uv(&[at(i, j), at(i, k), at(i + 1, k), at(i + 1, j)]);
        }
    }
    let last = rings.len() - 1;
    for j in 0..half {
        let corners = [j, j + 1, (count - j - 1) % count, (count - j) % count];
        let at = |ring: usize, point: usize| (rings[ring][point], uvs[ring][0][point]);
        mesh.face_uv(&corners.map(|point| at(last, point)));
        let mut reversed = corners;
        reversed.reverse();
        mesh.face_uv(&reversed.map(|point| at(0, point)));
    }
}

/// `count` + 1 places from -1 to 1, crowded towards both ends.
#[must_use]
pub(super) fn crowded(count: usize) -> Vec<f64> {
    (0..=count)
        .map(|i| {
            let x = 2.0 * i as f64 / count as f64 - 1.0;
            // Even in the middle, quadratic near the tips.
            let bent = libm::sin(x * std::f64::consts::FRAC_PI_2);
            0.35 * x + 0.65 * bent
        })
        .collect()
}
