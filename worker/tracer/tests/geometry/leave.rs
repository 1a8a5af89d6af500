//! Rays that leave a surface do not meet it again, and do meet what is close.

use glam::Vec3;
use shearwater_tracer::geometry::{Ellipsoid, Geometry, Instance, Particles, Ray, TriMesh};
use shearwater_tracer::uses::{NOTHING, PARTICLES};

use super::shapes::{Random, alone, octahedron, skew};

/// Rays from outside onto a convex body, then on from the hit into the outer half
/// space: none may hit. Counts those that do.
fn self_hits(scene: &Geometry, centre: Vec3, size: f32, count: usize) -> (usize, usize) {
    let mut r = Random(12);
    let (mut bad, mut tried) = (0, 0);
    for _ in 0..count {
        let from = centre + r.direction() * size * 4.0;
        let to = centre + r.cube() * size * 0.9;
        let ray = Ray::new(from, (to - from).normalize());
        let Some(hit) = scene.intersect::<PARTICLES>(&ray, r.next()) else {
            continue;
        };
        let point = scene.surface_point(&ray, &hit);
        let n = if point.n_geometric.dot(ray.d) < 0.0 {
            point.n_geometric
        } else {
            -point.n_geometric
        };
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
        bad += usize::from(scene.intersect::<PARTICLES>(&leaving, 0).is_some());
    }
    (bad, tried)
}

#[test]
fn rays_leave_instances() {
    let (positions, triangles) = octahedron(Vec3::ZERO, 1.0);
    for seed in 0..8 {
        let mut m = skew(seed);
        m.translation *= 100.0;
        let mesh = TriMesh::build(&positions, &triangles).unwrap();
        let scene =
            Geometry::build(vec![mesh], vec![Instance::new(0, m).unwrap()], None, None).unwrap();
        let (bad, tried) = self_hits(&scene, m.translation.into(), 0.5, 50_000);
        assert_eq!(bad, 0, "{seed}, of {tried}");
        assert!(tried > 10_000, "{tried}");
    }
}

#[test]
fn rays_leave_ellipsoids() {
    for (centre, radii) in [
        (Vec3::ZERO, Vec3::ONE),
        (Vec3::new(1000.0, 30.0, -500.0), Vec3::new(30.0, 10.0, 20.0)),
        (Vec3::splat(1e4), Vec3::new(1.0, 2.0, 0.5)),
    ] {
        let particles = Particles::build(&[Ellipsoid {
            centre,
            radii,
            opacity: 1.0,
        }])
        .unwrap();
        let scene = Geometry::build(vec![], vec![], Some(particles.into()), None).unwrap();
        let (bad, tried) = self_hits(&scene, centre, radii.min_element(), 200_000);
        assert_eq!(bad, 0, "{centre}, of {tried}");
        assert!(tried > 50_000, "{tried}");
    }
}

#[test]
fn a_ray_between_two_points_meets_neither_end() {
    // Shadow rays inside a convex body, from both ends: nothing stands between.
    for size in [1.0, 1e3, 1e6] {
        let scene = alone(&octahedron(Vec3::ZERO, size));
        let mut r = Random(8);
        let mut find = || {
            let ray = Ray::new(Vec3::ZERO, r.direction());
            let hit = scene.intersect::<NOTHING>(&ray, 0).unwrap();
            scene.surface_point(&ray, &hit)
        };
        for _ in 0..100_000 {
            let (a, b) = (find(), find());
            if a.n_geometric.dot(b.n_geometric) > 0.99 {
                continue;
            }
            let w = (b.p - a.p).normalize();
            let (from, to) = (a.origin_towards(w), b.origin_towards(-w));
            let way = to - from;
            let ray = Ray {
                o: from,
                d: way.normalize(),
                t_max: way.length() * (1.0 - 1e-6),
                time_s: 0.0,
            };
            assert!(
                scene.intersect::<NOTHING>(&ray, 0).is_none(),
                "{size} {ray:?}"
            );
        }
    }
}
