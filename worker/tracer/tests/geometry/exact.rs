//! Hits against brute force in double precision, and the same bits on all paths.

use glam::{Affine3A, DVec3, Vec3};
use shearwater_tracer::geometry::{
    Ellipsoid, Geometry, Hit, HitKind, Instance, Particles, Ray, Sprite, Sprites, TriMesh,
};
use shearwater_tracer::uses::{NOTHING, PARTICLES, SURROUNDINGS};

use super::shapes::{Mesh, Random, alone, ball, skew, soup};

/// All distances at which a ray meets triangles, in double precision, with the
/// distance to the nearest edge as a barycentric coordinate.
fn brute(mesh: &Mesh, ray: &Ray) -> Vec<(u32, f64, f64)> {
    let (o, d) = (ray.o.as_dvec3(), ray.d.as_dvec3());
    let mut hits = Vec::new();
    for (prim, t) in mesh.1.iter().enumerate() {
        let [a, b, c] = t.map(|i| mesh.0[i as usize].as_dvec3());
        let (e1, e2) = (b - a, c - a);
        let p = d.cross(e2);
        let det = e1.dot(p);
        let s: DVec3 = (o - a) / det;
        let u = s.dot(p);
        let q = s.cross(e1);
        let v = d.dot(q);
        let t = e2.dot(q);
        let margin = u.min(v).min(1.0 - u - v);
        if t > 0.0 && margin > -1e-3 {
            hits.push((prim as u32, t, margin));
        }
    }
    hits
}

#[test]
fn closest_hit_is_that_of_brute_force() {
    let mesh = soup(2000, 11);
    let scene = alone(&mesh);
    let mut r = Random(1);
    let mut hits = 0;
    for _ in 0..4000 {
        let ray = Ray::new(r.cube(), r.direction());
        let all = brute(&mesh, &ray);
        let best = all
            .iter()
            .filter(|h| h.2 > 1e-4)
            .map(|h| h.1)
            .fold(f64::INFINITY, f64::min);
        match scene.intersect::<NOTHING>(&ray, 0) {
            None => assert_eq!(best, f64::INFINITY, "{ray:?}"),
            Some(Hit {
                t,
                kind: HitKind::Triangle { prim, u, v, .. },
            }) => {
                hits += 1;
                let own = all
                    .iter()
                    .find(|h| h.0 == prim)
                    .expect("hits what brute force hits");
                assert!((f64::from(t) - own.1).abs() < 1e-4, "{t} {own:?}");
                assert!(f64::from(t) < best + 1e-4, "{t} {best}");
                assert!(u >= 0.0 && v >= 0.0 && u + v <= 1.0 + 1e-6);
            }
            Some(other) => panic!("{other:?}"),
        }
        assert_eq!(
            scene.transmittance_depth::<NOTHING>(&ray).is_blocked(),
            scene.intersect::<NOTHING>(&ray, 0).is_some()
        );
    }
    assert!(hits > 700, "{hits}");
}

/// Many instances, particles and water: everything at once.
pub(crate) fn crowd() -> Geometry {
    let meshes = [soup(600, 5), ball(8, Vec3::ZERO, 0.5)];
    let built: Vec<_> = meshes
        .iter()
        .map(|m| TriMesh::build(&m.0, &m.1).unwrap())
        .collect();
    let instances = (0..40)
        .map(|i| Instance::new(i % 2, skew(u64::from(i))).unwrap())
        .collect();
    let mut r = Random(9);
    let ellipsoids: Vec<_> = (0..500)
        .map(|_| Ellipsoid {
            centre: r.cube() * 3.0,
            radii: Vec3::splat(0.02) + (r.cube() + 1.0) * 0.2,
            opacity: 0.3 * r.unit(),
        })
        .collect();
    let sprites = (0..400)
        .map(|_| Sprite {
            centre: r.cube() * 3.0,
            radius: 0.05 + r.unit(),
            opacity: 0.3 * r.unit(),
            softness: 0.1 + 0.9 * r.unit(),
        })
        .collect();
    Geometry::build(
        built,
        instances,
        Some(Particles::build(&ellipsoids).unwrap().into()),
        Some(-2.0),
    )
    .unwrap()
    .with_sprites(Sprites::build(sprites).unwrap().into(), Vec3::Z * 5.0)
}

/// Rays through the crowd, some along the axes.
pub(crate) fn crowd_rays(count: usize, seed: u64) -> Vec<Ray> {
    let mut r = Random(seed);
    (0..count)
        .map(|i| {
            let d = if i % 16 == 0 {
                Vec3::AXES[r.below(3)]
            } else {
                r.direction()
            };
            let t_max = if i % 3 == 0 {
                r.unit() * 4.0
            } else {
                f32::INFINITY
            };
            Ray {
                o: r.cube() * 4.0,
                d,
                t_max,
                time_s: 0.0,
            }
        })
        .collect()
}

#[test]
fn portable_and_avx2_give_the_same_bits() {
    let (wide, portable) = (crowd(), crowd().without_avx2());
    let mut kinds = [0; 5];
    for (key, ray) in crowd_rays(60_000, 2).iter().enumerate() {
        let key = (key as u64).wrapping_mul(0x1234_5678_9abc_def1);
        let hit = wide.intersect::<PARTICLES>(ray, key);
        assert_eq!(
            format!("{hit:?}"),
            format!("{:?}", portable.intersect::<PARTICLES>(ray, key))
        );
        assert_eq!(hit, portable.intersect::<PARTICLES>(ray, key));
        assert_eq!(
            wide.transmittance_depth::<PARTICLES>(ray),
            portable.transmittance_depth::<PARTICLES>(ray)
        );
        kinds[match hit.map(|h| h.kind) {
            None => 0,
            Some(HitKind::Water) => 1,
            Some(HitKind::Triangle { .. }) => 2,
            Some(HitKind::Particle { .. }) => 3,
            Some(HitKind::Sprite { .. }) => 4,
        }] += 1;
    }
    assert!(kinds.iter().all(|&k| k > 2000), "{kinds:?}");
}

/// Eight rays in much the same direction from much the same place.
fn bundle(r: &mut Random, spread: f32) -> [Ray; 8] {
    let (o, d) = (r.cube() * 4.0, r.direction());
    let parallel = r.below(2) == 0;
    std::array::from_fn(|_| {
        let side = if parallel { r.cube() * 0.3 } else { Vec3::ZERO };
        let t_max = if r.below(4) == 0 {
            r.unit() * 5.0
        } else {
            f32::INFINITY
        };
        Ray {
            o: o + side,
            d: (d + r.cube() * spread).normalize(),
            t_max,
            time_s: 0.0,
        }
    })
}

#[test]
fn packets_give_the_bits_of_single_rays() {
    for scene in [crowd(), crowd().without_avx2()] {
        let mut r = Random(77);
        for i in 0..6000 {
            let mut rays = bundle(&mut r, [1e-3, 0.02, 0.3, 2.0][i % 4]);
            if i % 50 == 0 {
                rays[r.below(8)].o.x = f32::NAN;
            }
            let keys = std::array::from_fn(|_| r.next());
            let hits = scene.intersect8::<PARTICLES>(&rays, &keys);
            let depths = scene.transmittance_depth8::<PARTICLES>(&rays);
            for lane in 0..8 {
                assert_eq!(
                    hits[lane],
                    scene.intersect::<PARTICLES>(&rays[lane], keys[lane]),
                    "{i} {lane}"
                );
                assert_eq!(
                    depths[lane],
                    scene.transmittance_depth::<PARTICLES>(&rays[lane]),
                    "{i} {lane}"
                );
            }
        }
    }
}

#[test]
fn instances_stand_where_their_transform_says() {
    let mesh = soup(500, 21);
    for seed in 0..6 {
        let m = skew(seed);
        let baked = (
            mesh.0.iter().map(|&p| m.transform_point3(p)).collect(),
            mesh.1.clone(),
        );
        let baked = alone(&baked);
        let built = TriMesh::build(&mesh.0, &mesh.1).unwrap();
        let placed =
            Geometry::build(vec![built], vec![Instance::new(0, m).unwrap()], None, None).unwrap();
        let mut r = Random(seed);
        let mut differing = 0;
        for _ in 0..2000 {
            let o = m.transform_point3(r.cube() * 2.0);
            let p = m.transform_point3(r.cube());
            let ray = Ray::new(o, (p - o).normalize());
            let (a, b) = (
                baked.intersect::<NOTHING>(&ray, 0),
                placed.intersect::<NOTHING>(&ray, 0),
            );
            match (a, b) {
                (None, None) => {}
                (Some(a), Some(b)) if (a.t - b.t).abs() < 1e-4 * (1.0 + a.t) => {
                    let pa = baked.surface_point(&ray, &a);
                    let pb = placed.surface_point(&ray, &b);
                    assert!(pa.p.distance(pb.p) < 1e-4, "{pa:?} {pb:?}");
                    let mirrored = if m.matrix3.determinant() < 0.0 {
                        -1.0
                    } else {
                        1.0
                    };
                    if a.kind == b.kind {
                        assert!((pa.n_geometric * mirrored).dot(pb.n_geometric) > 0.99);
                    }
                }
                _ => differing += 1,
            }
        }
        // Rims may round either way.
        assert!(differing <= 2, "{differing}");
    }
}

#[test]
fn equal_distances_go_to_the_lower_rank() {
    // The same square five times: as triangles 0 to 9 and as two instances.
    let square = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
    let triangles: Vec<_> = (0..10)
        .map(|i| if i % 2 == 0 { [0, 1, 2] } else { [0, 2, 3] })
        .collect();
    let mesh = || TriMesh::build(&square, &triangles).unwrap();
    let here = || Instance::new(0, Affine3A::IDENTITY).unwrap();
    let scene = Geometry::build(vec![mesh()], vec![here(), here(), here()], None, None).unwrap();
    let mut r = Random(4);
    for _ in 0..1000 {
        let at = Vec3::new(r.unit(), r.unit(), 0.0);
        let ray = Ray::new(at - Vec3::Z, Vec3::Z);
        let lower = u32::from(at.y > at.x);
        let Some(Hit {
            kind: HitKind::Triangle {
                instance: 0, prim, ..
            },
            t,
        }) = scene.intersect::<NOTHING>(&ray, 0)
        else {
            panic!("{at}");
        };
        assert_eq!((prim, t), (if at.x == at.y { 0 } else { lower }, 1.0));
    }
}

#[test]
fn water_lies_at_its_height() {
    let scene = Geometry::build(vec![], vec![], None, Some(3.0)).unwrap();
    let down = Ray::new(Vec3::new(0.0, 10.0, 0.0), Vec3::new(0.6, -0.8, 0.0));
    let hit = scene.intersect::<SURROUNDINGS>(&down, 0).unwrap();
    assert_eq!(hit.kind, HitKind::Water);
    assert!((hit.t - 8.75).abs() < 1e-6);
    let point = scene.surface_point(&down, &hit);
    assert_eq!((point.p.y, point.n_geometric), (3.0, Vec3::Y));
    assert!(
        scene
            .transmittance_depth::<SURROUNDINGS>(&down)
            .is_blocked()
    );
    let short = Ray { t_max: 8.7, ..down };
    assert!(scene.intersect::<SURROUNDINGS>(&short, 0).is_none());
    assert!(
        !scene
            .transmittance_depth::<SURROUNDINGS>(&short)
            .is_blocked()
    );
    let up = Ray::new(down.o, Vec3::Y);
    assert!(scene.intersect::<SURROUNDINGS>(&up, 0).is_none());
    let level = Ray::new(Vec3::new(0.0, 3.0, 0.0), Vec3::X);
    assert!(scene.intersect::<SURROUNDINGS>(&level, 0).is_none());
    // From the surface itself, upwards and downwards.
    for w in [
        Vec3::new(0.99, 0.01, 0.0).normalize(),
        Vec3::new(0.0, -0.01, 0.99).normalize(),
    ] {
        let o = point.origin_towards(w);
        assert!(o.y != 3.0 && (o.y > 3.0) == (w.y > 0.0));
        assert!(
            scene
                .intersect::<SURROUNDINGS>(&Ray::new(o, w), 0)
                .is_none()
        );
    }
}
