//! Instances that move while the shutter is open.

use glam::{DAffine3, DVec3, Vec3};
use shearwater_tracer::geometry::{Geometry, HitKind, Instance, Joint, Ray, TriMesh, Turn};
use shearwater_tracer::uses::{MOTION, SURROUNDINGS};

use super::joints::{SHUTTER_S, build, chain, fixed, product};
use super::shapes::{Random, ball, octahedron, skew, soup};

fn crowd() -> Geometry {
    let meshes = vec![build(&soup(600, 5)), build(&ball(8, Vec3::ZERO, 0.5))];
    let instances = (0..36)
        .map(|i| {
            if i % 7 == 6 {
                Instance::new(i % 2, skew(u64::from(i))).unwrap()
            } else {
                Instance::moving(i % 2, chain(u64::from(i)), SHUTTER_S).unwrap()
            }
        })
        .collect();
    Geometry::build(meshes, instances, None, Some(-2.0)).unwrap()
}

fn random_ray(r: &mut Random) -> Ray {
    let (from, to) = (r.cube() * 5.0, r.cube() * 2.0);
    let mut ray = Ray::at_time(from, (to - from).normalize(), SHUTTER_S * r.unit());
    if r.below(3) == 0 {
        ray.t_max = 5.0 * r.unit();
    }
    ray
}

#[test]
fn single_rays_packets_and_both_instruction_sets_give_the_same_bits() {
    let (wide, portable) = (crowd(), crowd().without_avx2());
    let mut r = Random(3);
    let mut triangles = 0;
    for i in 0..12_000 {
        let base = random_ray(&mut r);
        let spread = [1e-3, 0.02, 0.3, 2.0][i % 4];
        let rays: [Ray; 8] = std::array::from_fn(|_| Ray {
            o: base.o + r.cube() * 0.1,
            d: (base.d + r.cube() * spread).normalize(),
            time_s: SHUTTER_S * r.unit(),
            ..base
        });
        let hits = wide.intersect8::<MOTION>(&rays, &[0; 8]);
        let depths = wide.transmittance_depth8::<MOTION>(&rays);
        assert_eq!(hits, portable.intersect8::<MOTION>(&rays, &[0; 8]));
        assert_eq!(depths, portable.transmittance_depth8::<MOTION>(&rays));
        for lane in 0..8 {
            let one = wide.intersect::<MOTION>(&rays[lane], 0);
            assert_eq!(one, hits[lane], "{i} {lane}");
            assert_eq!(one, portable.intersect::<MOTION>(&rays[lane], 0));
            let depth = wide.transmittance_depth::<MOTION>(&rays[lane]);
            assert_eq!(depth, depths[lane]);
            assert_eq!(depth, portable.transmittance_depth::<MOTION>(&rays[lane]));
            triangles += usize::from(matches!(
                one.map(|h| h.kind),
                Some(HitKind::Triangle { .. })
            ));
        }
    }
    assert!(triangles > 10_000, "{triangles}");
}

/// At every time the instance is where the hand-computed product says: the same
/// hits as of a still instance there.
#[test]
fn a_moving_instance_at_a_time_is_a_still_one_there() {
    let mesh = soup(300, 8);
    let mut differing = 0;
    for seed in 0..18 {
        let joints = chain(seed);
        let moving = Instance::moving(0, joints.clone(), SHUTTER_S).unwrap();
        let moving = Geometry::build(vec![build(&mesh)], vec![moving], None, None).unwrap();
        let mut r = Random(seed);
        for _ in 0..40 {
            let time_s = SHUTTER_S * r.unit();
            let there = product(&joints, f64::from(time_s));
            let still = Instance::new(
                0,
                glam::Affine3A {
                    matrix3: there.matrix3.as_mat3().into(),
                    translation: there.translation.as_vec3().into(),
                },
            )
            .unwrap();
            let normal_from_local = still.normal_from_local(0.0);
            let still = Geometry::build(vec![build(&mesh)], vec![still], None, None).unwrap();
            for _ in 0..150 {
                let to = there.transform_point3(r.cube().as_dvec3()).as_vec3();
                let o = to + r.direction() * 3.0;
                let ray = Ray::at_time(o, (to - o).normalize(), time_s);
                let (a, b) = (
                    moving.intersect::<MOTION>(&ray, 0),
                    still.intersect::<SURROUNDINGS>(&ray, 0),
                );
                match (a, b) {
                    (None, None) => {}
                    (Some(a), Some(b)) if (a.t - b.t).abs() < 2e-4 => {
                        let (p, q) = (
                            moving.surface_point(&ray, &a),
                            still.surface_point(&ray, &b),
                        );
                        assert!(p.p.distance(q.p) < 3e-4);
                        let own = moving.instances()[0].normal_from_local(time_s);
                        assert!((own - normal_from_local).abs_diff_eq(glam::Mat3::ZERO, 2e-4));
                    }
                    _ => differing += 1,
                }
            }
        }
    }
    // Rims may round either way.
    assert!(differing <= 60, "{differing} of 108000");
}

#[test]
fn what_does_not_move_is_placed_as_ever() {
    let Joint::Fixed(affine) = fixed(4) else {
        unreachable!()
    };
    let placed = Instance::moving(0, vec![Joint::Fixed(affine)], SHUTTER_S).unwrap();
    let still = Instance::new(0, skew(4)).unwrap();
    assert!(!placed.is_moving());
    assert_eq!(placed.world_from_local(), still.world_from_local());
    assert_eq!(placed.local_from_world(), still.local_from_world());
    let flat = Joint::Fixed(DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0)));
    let slide = Joint::Slide(DVec3::X);
    assert!(Instance::moving(0, vec![slide, flat], SHUTTER_S).is_err());
    let nan = Joint::Slide(DVec3::NAN);
    assert!(Instance::moving(0, vec![nan], SHUTTER_S).is_err());
}

/// Turning bodies far from the origin, hit and left again: none is met twice.
#[test]
fn rays_leave_turning_bodies() {
    let (positions, triangles) = octahedron(Vec3::ZERO, 1.0);
    let (mut tried, mut bad) = (0, 0);
    for (seed, far) in [
        (0, 0.0),
        (1, 10.0),
        (2, 100.0),
        (3, 1e4),
        (5, 100.0),
        (11, 1e5),
    ] {
        let mut joints = vec![Joint::Fixed(DAffine3::from_translation(
            DVec3::new(1.0, -0.7, 0.4) * far,
        ))];
        joints.extend(chain(seed));
        joints.push(Joint::Turn(Turn {
            axis: DVec3::new(0.6, 0.0, 0.8),
            start: 0.1,
            rate: 77.0,
        }));
        let turning = Instance::moving(0, joints.clone(), SHUTTER_S).unwrap();
        let mesh = TriMesh::build(&positions, &triangles).unwrap();
        let scene = Geometry::build(vec![mesh], vec![turning], None, None).unwrap();
        let mut r = Random(seed);
        for _ in 0..60_000 {
            let time_s = SHUTTER_S * r.unit();
            let centre = product(&joints, f64::from(time_s)).translation.as_vec3();
            let from = centre + r.direction() * 8.0;
            let to = centre + r.cube() * 0.3;
            let ray = Ray::at_time(from, (to - from).normalize(), time_s);
            let Some(hit) = scene.intersect::<MOTION>(&ray, 0) else {
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
            if r.below(3) == 0 {
                w = (w - n * w.dot(n) * 0.999).normalize();
            }
            if w.dot(n) <= 0.0 {
                continue;
            }
            tried += 1;
            let leaving = Ray::at_time(point.origin_towards(w), w, time_s);
            bad += usize::from(scene.intersect::<MOTION>(&leaving, 0).is_some());
        }
    }
    assert_eq!(bad, 0, "of {tried}");
    assert!(tried > 200_000, "{tried}");
}
