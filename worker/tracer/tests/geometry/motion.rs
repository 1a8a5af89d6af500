//! Instances that move while the shutter is open.

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};
use shearwater_tracer::geometry::{
    Geometry, HitKind, Instance, Joint, Keyed, PIECES, Ray, TriMesh, Turn,
};
use shearwater_tracer::uses::{MOTION, SURROUNDINGS};

use super::shapes::{Mesh, Random, ball, skew, soup};

pub(crate) const SHUTTER_S: f32 = 0.25;

fn axis(r: &mut Random) -> DVec3 {
    r.direction().as_dvec3().normalize()
}

fn keyed(r: &mut Random, reach: f64, turn: f64) -> Joint {
    let mut at = || r.cube().as_dvec3();
    Joint::Keyed(Box::new(Keyed {
        piece_s: f64::from(SHUTTER_S) / PIECES as f64,
        offset_m: std::array::from_fn(|_| at() * reach),
        turns: std::array::from_fn(|_| at() * turn),
    }))
}

fn fixed(seed: u64) -> Joint {
    let m = skew(seed);
    Joint::Fixed(DAffine3 {
        matrix3: DMat3::from_cols(
            m.matrix3.x_axis.as_dvec3(),
            m.matrix3.y_axis.as_dvec3(),
            m.matrix3.z_axis.as_dvec3(),
        ),
        translation: m.translation.as_dvec3(),
    })
}

/// Chains of every kind: slow and fast turns, slides, keys, and all of them.
fn chain(seed: u64) -> Vec<Joint> {
    let mut r = Random(seed + 900);
    let turn = |r: &mut Random, most: f64| {
        Joint::Turn(Turn {
            axis: axis(r),
            start: f64::from(r.unit()),
            rate: most * (2.0 * f64::from(r.unit()) - 1.0) / f64::from(SHUTTER_S),
        })
    };
    let slide = |r: &mut Random| Joint::Slide(r.cube().as_dvec3() * 8.0);
    match seed % 6 {
        0 => vec![fixed(seed), turn(&mut r, 0.24), fixed(seed + 1)],
        1 => vec![fixed(seed), turn(&mut r, 3.0), fixed(seed + 1)],
        2 => vec![slide(&mut r), fixed(seed)],
        3 => vec![fixed(seed), keyed(&mut r, 1.0, 0.1), fixed(seed + 1)],
        4 => vec![keyed(&mut r, 0.5, 1.0), fixed(seed)],
        _ => vec![
            slide(&mut r),
            fixed(seed),
            keyed(&mut r, 0.4, 0.05),
            fixed(seed + 1),
            turn(&mut r, 0.2),
            fixed(seed + 2),
            turn(&mut r, 5.0),
            fixed(seed + 3),
        ],
    }
}

/// The product of a chain, by other formulas than the tracer's.
fn product(joints: &[Joint], time_s: f64) -> DAffine3 {
    let turned = |axis: DVec3, turns: f64| {
        let (sin, cos) = (
            libm::sin(turns * std::f64::consts::PI),
            libm::cos(turns * std::f64::consts::PI),
        );
        let half = axis * sin;
        DAffine3::from_quat(DQuat::from_xyzw(half.x, half.y, half.z, cos))
    };
    let one = |joint: &Joint| match joint {
        Joint::Fixed(affine) => *affine,
        Joint::Slide(velocity) => DAffine3::from_translation(*velocity * time_s),
        Joint::Turn(turn) => turned(turn.axis, turn.start + turn.rate * time_s),
        Joint::Keyed(keyed) => {
            let k = ((time_s / keyed.piece_s) as usize).min(PIECES - 1);
            let w = time_s / keyed.piece_s - k as f64;
            let a = keyed.turns[k].lerp(keyed.turns[k + 1], w);
            let offset = keyed.offset_m[k].lerp(keyed.offset_m[k + 1], w);
            DAffine3::from_translation(offset)
                * turned(DVec3::Y, a.y)
                * turned(DVec3::X, a.x)
                * turned(DVec3::Z, a.z)
        }
    };
    joints
        .iter()
        .map(one)
        .fold(DAffine3::IDENTITY, |a, b| a * b)
}

pub(crate) fn build(mesh: &Mesh) -> TriMesh {
    TriMesh::build(&mesh.0, &mesh.1).unwrap()
}

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

/// The tree with its swept boxes finds what a look at every instance by itself, which
/// has no box above it, finds: bit for bit.
#[test]
fn no_swept_box_loses_a_hit() {
    let meshes = || vec![build(&soup(300, 5)), build(&ball(6, Vec3::ZERO, 0.5))];
    let instances: Vec<_> = (0..24)
        .map(|i| Instance::moving(i % 2, chain(u64::from(i)), SHUTTER_S).unwrap())
        .collect();
    let all = Geometry::build(meshes(), instances.clone(), None, None).unwrap();
    let each: Vec<_> = instances
        .into_iter()
        .map(|i| Geometry::build(meshes(), vec![i], None, None).unwrap())
        .collect();
    let mut r = Random(5);
    let mut hits = 0;
    for _ in 0..100_000 {
        let ray = random_ray(&mut r);
        let best = each
            .iter()
            .enumerate()
            .filter_map(|(i, g)| g.intersect::<MOTION>(&ray, 0).map(|h| (h.t, i, h.kind)))
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let found = all.intersect::<MOTION>(&ray, 0);
        assert_eq!(found.map(|h| h.t), best.map(|b| b.0), "{ray:?}");
        if let (Some(hit), Some((_, index, kind))) = (found, best) {
            hits += 1;
            let (HitKind::Triangle { instance, prim, .. }, HitKind::Triangle { prim: alone, .. }) =
                (hit.kind, kind)
            else {
                panic!("{hit:?} {kind:?}");
            };
            assert_eq!((instance as usize, prim), (index, alone));
        }
    }
    assert!(hits > 15_000, "{hits}");
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
    let positions = [
        Vec3::X,
        Vec3::Y,
        Vec3::Z,
        Vec3::NEG_X,
        Vec3::NEG_Y,
        Vec3::NEG_Z,
    ];
    let triangles = [
        [0, 1, 2],
        [1, 3, 2],
        [3, 4, 2],
        [4, 0, 2],
        [1, 0, 5],
        [3, 1, 5],
        [4, 3, 5],
        [0, 4, 5],
    ];
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
