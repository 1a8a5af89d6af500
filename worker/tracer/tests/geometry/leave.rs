//! Rays that leave a surface do not meet it again, and do meet what is close.

use glam::Vec3;
use shearwater_tracer::geometry::{Ellipsoid, Geometry, Instance, Particles, Ray, TriMesh};
use shearwater_tracer::uses::{NOTHING, PARTICLES};

use super::self_hits::self_hits;
use super::shapes::{Random, alone, octahedron, skew};

#[test]
fn rays_leave_instances() {
    let (positions, triangles) = octahedron(Vec3::ZERO, 1.0);
    for seed in 0..8 {
        let mut m = skew(seed);
        m.translation *= 100.0;
        let mesh = TriMesh::build(&positions, &triangles).unwrap();
        let scene =
            Geometry::build(vec![mesh], vec![Instance::new(0, m).unwrap()], None, None).unwrap();
        let (bad, tried) = self_hits::<PARTICLES>(&scene, m.translation.into(), 0.5, 50_000);
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
        let (bad, tried) = self_hits::<PARTICLES>(&scene, centre, radii.min_element(), 200_000);
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
