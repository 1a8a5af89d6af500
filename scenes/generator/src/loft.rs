//! Skins over rings of points: lofts, bodies of revolution, tubes.

use crate::mesh::Mesh;
use crate::vec3::{Vec3, vec3};
use std::f64::consts::TAU;

/// What closes an end of a loft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Nothing: the edge lies inside another part.
    Open,
    /// A fan to the middle of the ring.
    Fan,
}

/// Skins the rings (equal sizes, each closed on itself) without texture.
///
/// Outward when each ring runs anticlockwise seen from the last ring's side
/// looking back at the first.
pub fn loft(mesh: &mut Mesh, rings: &[Vec<Vec3>], start: End, end: End) {
    let indices: Vec<Vec<u32>> = rings
        .iter()
        .map(|ring| ring.iter().map(|&p| mesh.vertex(p)).collect())
        .collect();
    for pair in indices.windows(2) {
        let (a, b) = (&pair[0], &pair[1]);
        for j in 0..a.len() {
            let k = (j + 1) % a.len();
            mesh.face(&[a[j], a[k], b[k], b[j]]);
        }
    }
    if let (Some(first), Some(last)) = (indices.first(), indices.last()) {
        if start == End::Fan {
            let tip = mesh.vertex(centre(&rings[0]));
            for j in 0..first.len() {
                mesh.face(&[first[(j + 1) % first.len()], first[j], tip]);
            }
        }
        if end == End::Fan {
            let tip = mesh.vertex(centre(&rings[rings.len() - 1]));
            for j in 0..last.len() {
                mesh.face(&[last[j], last[(j + 1) % last.len()], tip]);
            }
        }
    }
}

/// Skins the rings with texture: `uv(i, j)` for ring i and point j, where j
/// runs to the ring's size inclusive (the seam has two sets). A ring whose
/// points all coincide is one vertex, so the skin is closed there.
pub fn loft_uv(mesh: &mut Mesh, rings: &[Vec<Vec3>], uv: &dyn Fn(usize, usize) -> [f64; 2]) {
    let mut before: Option<(Vec<u32>, Vec<u32>)> = None;
    for (i, ring) in rings.iter().enumerate() {
        let positions: Vec<u32> = if ring.iter().all(|&p| p == ring[0]) {
            vec![mesh.vertex(ring[0]); ring.len()]
        } else {
            ring.iter().map(|&p| mesh.vertex(p)).collect()
        };
        let uvs: Vec<u32> = (0..=ring.len()).map(|j| mesh.uv(uv(i, j))).collect();
        if let Some((a, ta)) = before {
            let (b, tb) = (&positions, &uvs);
            for j in 0..ring.len() {
                let k = (j + 1) % ring.len();
                mesh.face_uv(&[
                    (a[j], ta[j]),
                    (a[k], ta[j + 1]),
                    (b[k], tb[j + 1]),
                    (b[j], tb[j]),
                ]);
            }
        }
        before = Some((positions, uvs));
    }
}

/// Mean of the ring's points.
#[must_use]
pub fn centre(ring: &[Vec3]) -> Vec3 {
    let sum = ring.iter().fold(Vec3::default(), |sum, &p| sum + p);
    sum * (1.0 / ring.len().max(1) as f64)
}

/// Body of revolution: `profile` holds (distance along `axis`, radius) in the
/// order from start to end; a radius of 0 makes a pole.
///
/// Outward when the profile runs along +axis with the body inside.
pub fn revolve(mesh: &mut Mesh, origin: Vec3, axis: Vec3, profile: &[(f64, f64)], sides: usize) {
    let axis = axis.normalized();
    let (right, up) = frame(axis);
    let ring_of = |mesh: &mut Mesh, along: f64, radius: f64| -> Vec<u32> {
        let middle = origin + axis * along;
        if radius <= 0.0 {
            return vec![mesh.vertex(middle)];
        }
        (0..sides)
            .map(|j| {
                let angle = TAU * j as f64 / sides as f64;
                let (s, c) = (libm::sin(angle), libm::cos(angle));
                mesh.vertex(middle + right * (radius * c) + up * (radius * s))
            })
            .collect()
    };
    let rings: Vec<Vec<u32>> = profile.iter().map(|&(a, r)| ring_of(mesh, a, r)).collect();
    for pair in rings.windows(2) {
        let (a, b) = (&pair[0], &pair[1]);
        for j in 0..sides {
            let k = (j + 1) % sides;
            let at = |ring: &Vec<u32>, i: usize| ring[i % ring.len()];
            mesh.face(&[at(a, j), at(a, k), at(b, k), at(b, j)]);
        }
    }
}

/// Tube of the given radius along the path, closed with flat ends.
pub fn tube(mesh: &mut Mesh, path: &[Vec3], radius: f64, sides: usize, ends: End) {
    let rings: Vec<Vec<Vec3>> = (0..path.len())
        .map(|i| {
            let before = path[i.saturating_sub(1)];
            let after = path[(i + 1).min(path.len() - 1)];
            let (right, up) = frame((after - before).normalized());
            (0..sides)
                .map(|j| {
                    let angle = TAU * j as f64 / sides as f64;
                    path[i] + right * (radius * libm::cos(angle)) + up * (radius * libm::sin(angle))
                })
                .collect()
        })
        .collect();
    loft(mesh, &rings, ends, ends);
}

/// Two unit vectors that make a right-handed frame (right, up, axis).
#[must_use]
pub fn frame(axis: Vec3) -> (Vec3, Vec3) {
    let helper = if axis.y.abs() > 0.9 {
        vec3(0.0, 0.0, 1.0)
    } else {
        vec3(0.0, 1.0, 0.0)
    };
    let right = helper.cross(axis).normalized();
    (right, axis.cross(right))
}
