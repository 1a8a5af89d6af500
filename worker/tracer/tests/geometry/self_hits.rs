//! Rays that leave a convex body and must not meet it again.

use crate::shapes::Random;
use glam::Vec3;
use shearwater_tracer::geometry::{Geometry, Ray};

/// Rays from outside onto a convex body about `centre`, then on from the hit into the
/// outer half space: none may hit. How many do, and how many were tried.
pub(crate) fn self_hits<const USES: u8>(
    scene: &Geometry,
    centre: Vec3,
    size: f32,
    count: usize,
) -> (usize, usize) {
    let mut r = Random(12);
    let (mut bad, mut tried) = (0, 0);
    for _ in 0..count {
        let from = centre + r.direction() * size * 4.0;
        let to = centre + r.cube() * size * 0.9;
        let ray = Ray::new(from, (to - from).normalize());
        let Some(hit) = scene.intersect::<USES>(&ray, r.next()) else {
            continue;
        };
        let point = scene.surface_point(&ray, &hit);
        // Outwards: a mirrored mesh has its normals inside.
        let n = if point.n_geometric.dot(point.p - centre) > 0.0 {
            point.n_geometric
        } else {
            -point.n_geometric
        };
        // Exactly at an edge the face behind it may come first: nothing was left.
        if n.dot(ray.d) >= 0.0 {
            continue;
        }
        let mut w = r.direction();
        if w.dot(n) < 0.0 {
            w = -w;
        }
        // A third of them grazing.
        if r.below(3) == 0 {
            w = (w - n * w.dot(n) * 0.999).normalize();
        }
        if w.dot(n) <= 0.0 {
            continue;
        }
        tried += 1;
        let leaving = Ray::new(point.origin_towards(w), w);
        bad += usize::from(scene.intersect::<USES>(&leaving, 0).is_some());
    }
    (bad, tried)
}
