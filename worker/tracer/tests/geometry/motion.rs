//! Instances that move while the shutter is open.

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};
use shearwater_tracer::geometry::{
    Geometry, HitKind, Instance, Joint, Keyed, PIECES, Placement, Ray, TriMesh, Turn,
};
use shearwater_tracer::uses::{MOTION, NOTHING};

use super::shapes::{Mesh, Random, ball, skew, soup};

const SHUTTER_S: f32 = 0.25;

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

fn build(mesh: &Mesh) -> TriMesh {
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
                    still.intersect::<NOTHING>(&ray, 0),
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

/// Sectors of `angle` turns between two radii, in the plane across z.
fn blades(count: usize, angle: f64, inner: f64, outer: f64) -> Mesh {
    let steps = 64;
    let mut mesh: Mesh = (vec![], vec![]);
    for blade in 0..count {
        for step in 0..=steps {
            let turns = blade as f64 / count as f64 + angle * f64::from(step) / f64::from(steps);
            let (sin, cos) = (
                libm::sin(turns * std::f64::consts::TAU),
                libm::cos(turns * std::f64::consts::TAU),
            );
            // Outside of the chord, so that the rim is no less than the radius.
            let rim = Vec3::new(cos as f32, sin as f32, 0.0);
            mesh.0.extend([rim * inner as f32, rim * outer as f32]);
        }
        let first = (blade * 2 * (steps as usize + 1)) as u32;
        for step in 0..steps as u32 {
            let a = first + 2 * step;
            mesh.1.extend([[a, a + 1, a + 3], [a, a + 3, a + 2]]);
        }
    }
    mesh
}

/// Share of the shutter for which a ray along z at (x, y) is blocked.
fn coverage(scene: &Geometry, x: f64, y: f64, count: u32) -> f64 {
    let blocked = (0..count).filter(|i| {
        let time_s = SHUTTER_S * ((*i as f32 + 0.5) / count as f32);
        let ray = Ray::at_time(Vec3::new(x as f32, y as f32, 5.0), Vec3::NEG_Z, time_s);
        scene.transmittance_depth::<MOTION>(&ray).is_blocked()
    });
    blocked.count() as f64 / f64::from(count)
}

fn spinning(mesh: &Mesh, turns: f64) -> Geometry {
    let turn = Joint::Turn(Turn {
        axis: DVec3::Z,
        start: 0.3,
        rate: turns / f64::from(SHUTTER_S),
    });
    let instance = Instance::moving(0, vec![turn], SHUTTER_S).unwrap();
    Geometry::build(vec![build(mesh)], vec![instance], None, None).unwrap()
}

#[test]
fn whole_turns_of_a_propeller_cover_the_same_share_at_every_radius() {
    let samples = 4096;
    for (count, degrees, expected) in [(3, 12.0, 0.1), (2, 10.0, 0.055_56), (4, 15.0, 0.166_67)] {
        let scene = spinning(
            &blades(count, degrees / 360.0, 0.1, 1.0),
            1.0 / count as f64,
        );
        for radius in [0.11, 0.3, 0.7, 0.999] {
            let found = coverage(&scene, radius * 0.6, radius * 0.8, samples);
            assert!(
                (found - expected).abs() <= 2.0 / f64::from(samples) + 1e-5,
                "{count} {radius}: {found}"
            );
        }
        assert_eq!(coverage(&scene, 1.001, 0.0, samples), 0.0);
    }
}

#[test]
fn blades_of_constant_chord_cover_less_further_out() {
    // Three rectangles of chord 0.2.
    let chord = 0.2;
    let mut mesh: Mesh = (vec![], vec![]);
    for blade in 0..3 {
        let turns = f64::from(blade) / 3.0 * std::f64::consts::TAU;
        let (u, v) = (
            Vec3::new(libm::cos(turns) as f32, libm::sin(turns) as f32, 0.0),
            Vec3::new(-libm::sin(turns) as f32, libm::cos(turns) as f32, 0.0) * (0.5 * chord),
        );
        let first = mesh.0.len() as u32;
        mesh.0.extend([v * -1.0, u * 2.0 - v, u * 2.0 + v, v]);
        mesh.1
            .extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    let scene = spinning(&mesh, 1.0);
    for radius in [0.25_f64, 0.5, 1.0, 1.9] {
        let expected = 3.0 / std::f64::consts::PI * libm::asin(f64::from(chord) / (2.0 * radius));
        let found = coverage(&scene, radius, 0.0, 16_384);
        assert!(
            (found - expected).abs() < 6.0 / 16_384.0,
            "{radius}: {found}, {expected}"
        );
    }
}

#[test]
fn part_of_a_turn_gives_a_trapezoid() {
    // One blade of 10 degrees turns by 30: it covers angle a for the share of the
    // shutter in which a lies within it.
    let (blade, turn) = (10.0_f64 / 360.0, 30.0_f64 / 360.0);
    let scene = spinning(&blades(1, blade, 0.1, 1.0), turn);
    let samples = 4096;
    for at in [-2.0, 1.0, 4.0, 9.0, 11.0, 25.0, 31.0, 36.0, 39.5, 41.0] {
        let angle: f64 = at / 360.0;
        // Covered while start + rate t < angle < start + rate t + blade.
        let expected = ((angle.min(turn) - (angle - blade).max(0.0)) / turn).max(0.0);
        let turns = (0.3 + angle) * std::f64::consts::TAU;
        let found = coverage(
            &scene,
            0.5 * libm::cos(turns),
            0.5 * libm::sin(turns),
            samples,
        );
        assert!(
            (found - expected).abs() <= 2.0 / f64::from(samples),
            "{at}: {found}, {expected}"
        );
    }
}

/// Vertices that moved straight would cut a quarter turn at 0.707 of the radius.
#[test]
fn a_quarter_turn_keeps_its_radius() {
    let scene = spinning(&blades(1, 2.0 / 360.0, 0.9, 1.0), 0.25);
    for radius in [0.905, 0.95, 0.999] {
        for degrees in [5.0, 30.0, 45.0, 60.0, 85.0] {
            let turns = (0.3 + degrees / 360.0) * std::f64::consts::TAU;
            let found = coverage(
                &scene,
                radius * libm::cos(turns),
                radius * libm::sin(turns),
                4096,
            );
            assert!(
                (found - 2.0 / 90.0).abs() < 2.0 / 4096.0,
                "{radius} {degrees}: {found}"
            );
        }
    }
}

#[test]
fn a_moving_edge_is_a_ramp() {
    let square = (
        vec![
            Vec3::new(-10.0, -1.0, 0.0),
            Vec3::new(0.0, -1.0, 0.0),
            Vec3::new(0.0, 1.0, 0.0),
            Vec3::new(-10.0, 1.0, 0.0),
        ],
        vec![[0, 1, 2], [0, 2, 3]],
    );
    let reach = 3.0;
    let slide = Joint::Slide(DVec3::X * reach / f64::from(SHUTTER_S));
    let instance = Instance::moving(0, vec![slide], SHUTTER_S).unwrap();
    let scene = Geometry::build(vec![build(&square)], vec![instance], None, None).unwrap();
    for x in [-0.5, 0.1, 0.75, 1.5, 2.9, 3.2] {
        let expected = (1.0 - x / reach).clamp(0.0, 1.0);
        let found = coverage(&scene, x, 0.0, 1000);
        assert!((found - expected).abs() <= 1.0 / 1000.0, "{x}: {found}");
    }
}

#[test]
fn swept_boxes_are_close() {
    let ring = |joints: Vec<Joint>, mesh: &Mesh| {
        let instance = Instance::moving(0, joints, SHUTTER_S).unwrap();
        let placement = Placement::build(&[build(mesh)], vec![instance]).unwrap();
        placement.world_box(0).unwrap()
    };
    let spin = |turns: f64| {
        Joint::Turn(Turn {
            axis: DVec3::Z,
            start: 0.0,
            rate: turns / f64::from(SHUTTER_S),
        })
    };
    let mesh = blades(3, 12.0 / 360.0, 0.1, 1.0);
    let far = Joint::Fixed(DAffine3::from_translation(DVec3::X * 50.0));
    let (lo, hi) = ring(vec![far, spin(7.0)], &mesh);
    assert!(
        lo.x > 48.97 && lo.x <= 49.0 && hi.x < 51.03 && hi.x >= 51.0,
        "{lo} {hi}"
    );
    assert!(hi.z - lo.z < 1e-3, "a propeller's disc is flat: {lo} {hi}");
    // A twentieth of a turn of one blade stays near the blade.
    let (lo, hi) = ring(vec![spin(0.05)], &blades(1, 12.0 / 360.0, 0.1, 1.0));
    assert!(
        lo.x > 0.0 && lo.y > -0.02 && hi.x < 1.02 && hi.y < 0.56,
        "{lo} {hi}"
    );
    let (lo, hi) = ring(vec![Joint::Slide(DVec3::X * 4.0)], &mesh);
    assert!(hi.x - lo.x < 3.0 + 1e-3, "{lo} {hi}");
}
