//! Ellipsoids: where their walls are, and what passes them.

use glam::Vec3;
use shearwater_tracer::geometry::{
    Ellipsoid, Geometry, HitKind, OPTICAL_DEPTH_SCALE, Particles, Ray,
};
use shearwater_tracer::uses::{NOTHING, PARTICLES};

use super::shapes::Random;

fn scene(ellipsoids: &[Ellipsoid]) -> Geometry {
    Geometry::build(
        vec![],
        vec![],
        Some(Particles::build(ellipsoids).unwrap().into()),
        None,
    )
    .unwrap()
}

fn sphere(centre: Vec3, radius: f32, opacity: f32) -> Ellipsoid {
    Ellipsoid {
        centre,
        radii: Vec3::splat(radius),
        opacity,
    }
}

#[test]
fn opaque_ellipsoids_are_hit_where_double_precision_says() {
    let mut r = Random(1);
    let all: Vec<_> = (0..300)
        .map(|_| Ellipsoid {
            centre: r.cube() * 5.0,
            radii: (r.cube() + 1.1) * 0.4,
            opacity: 1.0,
        })
        .collect();
    let scene = scene(&all);
    let mut hits = 0;
    for _ in 0..5000 {
        let ray = Ray::new(r.cube() * 6.0, r.direction());
        let mut best = (f64::INFINITY, 0, false);
        for (i, e) in all.iter().enumerate() {
            let radii = e.radii.as_dvec3();
            let o = (ray.o.as_dvec3() - e.centre.as_dvec3()) / radii;
            let d = ray.d.as_dvec3() / radii;
            let (a, b, c) = (d.dot(d), o.dot(d), o.dot(o) - 1.0);
            let h = b * b - a * c;
            for (t, inside) in [((-b - h.sqrt()) / a, false), ((-b + h.sqrt()) / a, true)] {
                if t > 0.0 && t < best.0 {
                    best = (t, i as u32, inside);
                }
            }
        }
        match scene.intersect::<PARTICLES>(&ray, 0) {
            None => assert_eq!(best.0, f64::INFINITY),
            Some(hit) => {
                hits += 1;
                assert!((f64::from(hit.t) - best.0).abs() < 2e-4, "{hit:?} {best:?}");
                assert!(best.0 > 1e-3 || hit.t < 2e-3);
                let p = scene.surface_point(&ray, &hit);
                assert!(p.p.distance(ray.at(hit.t)) < 1e-3);
                if let HitKind::Particle { prim, inside } = hit.kind
                    && prim == best.1
                {
                    assert_eq!(inside, best.2);
                    let cos = p.n_geometric.dot(ray.d);
                    assert!(if inside { cos > -1e-2 } else { cos < 1e-2 }, "{cos}");
                }
            }
        }
        assert!(scene.intersect::<NOTHING>(&ray, 0).is_none());
    }
    assert!(hits > 1000, "{hits}");
}

#[test]
fn keys_that_count_up_still_give_independent_decisions() {
    let scene = scene(&[
        sphere(Vec3::ZERO, 1.0, 0.5),
        sphere(Vec3::Z * 3.0, 1.0, 0.5),
    ]);
    let ray = Ray::new(Vec3::Z * -4.0, Vec3::Z);
    let mut seen = [0_i32; 5];
    for key in 0..64_000_u64 {
        let which = match scene.intersect::<PARTICLES>(&ray, key).map(|h| h.kind) {
            None => 4,
            Some(HitKind::Particle { prim, inside }) => prim as usize * 2 + usize::from(inside),
            Some(_) => unreachable!(),
        };
        seen[which] += 1;
    }
    for (count, share) in seen.iter().zip([32_000, 16_000, 8000, 4000, 4000]) {
        assert!((count - share).abs() < 600, "{seen:?}");
    }
}

#[test]
fn opacity_one_blocks_and_zero_does_not() {
    let ray = Ray::new(Vec3::Z * -4.0, Vec3::Z);
    let opaque = scene(&[sphere(Vec3::ZERO, 1.0, 1.0)]);
    assert!(opaque.transmittance_depth::<PARTICLES>(&ray).is_blocked());
    let clear = scene(&[sphere(Vec3::ZERO, 1.0, 0.0)]);
    assert_eq!(clear.transmittance_depth::<PARTICLES>(&ray).depth(), 0);
    for key in 0..1000 {
        assert_eq!(
            opaque.intersect::<PARTICLES>(&ray, key).map(|h| h.t),
            Some(3.0)
        );
        assert!(clear.intersect::<PARTICLES>(&ray, key).is_none());
    }
    // Enough thin layers block too.
    let thick: Vec<_> = (0..30)
        .map(|i| sphere(Vec3::ZERO, 1.0 + 0.01 * i as f32, 0.3))
        .collect();
    assert!(
        scene(&thick)
            .transmittance_depth::<PARTICLES>(&ray)
            .is_blocked()
    );
}

#[test]
fn what_lies_behind_the_end_does_not_count() {
    let scene = scene(&[sphere(Vec3::ZERO, 1.0, 0.5)]);
    let depth = |t_max| {
        scene
            .transmittance_depth::<PARTICLES>(&Ray {
                o: Vec3::Z * -4.0,
                d: Vec3::Z,
                t_max,
                time_s: 0.0,
            })
            .depth()
    };
    let one = depth(4.0);
    assert!(
        (f64::from(one) / f64::from(OPTICAL_DEPTH_SCALE) - std::f64::consts::LN_2).abs() < 1e-5
    );
    assert_eq!((depth(2.9), depth(5.1)), (0, 2 * one));
}

#[test]
fn bad_ellipsoids_are_refused() {
    let good = sphere(Vec3::ZERO, 1.0, 0.5);
    for bad in [
        Ellipsoid {
            centre: Vec3::NAN,
            ..good
        },
        Ellipsoid {
            radii: Vec3::new(1.0, 0.0, 1.0),
            ..good
        },
        Ellipsoid {
            radii: Vec3::new(1.0, -1.0, 1.0),
            ..good
        },
        Ellipsoid {
            radii: Vec3::INFINITY,
            ..good
        },
        Ellipsoid {
            opacity: 1.5,
            ..good
        },
        Ellipsoid {
            opacity: f32::NAN,
            ..good
        },
    ] {
        assert!(Particles::build(&[good, bad]).is_err(), "{bad:?}");
    }
    assert!(Particles::build(&[]).is_ok());
}
