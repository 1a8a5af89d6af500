//! Sprites: where their discs are, and what passes them.

use glam::{DVec3, Vec3};
use shearwater_tracer::geometry::{Geometry, HitKind, OPTICAL_DEPTH_SCALE, Ray, Sprite, Sprites};
use shearwater_tracer::uses::{NOTHING, PARTICLES};

use super::shapes::Random;

fn scene(sprites: Vec<Sprite>, eye: Vec3) -> Geometry {
    let sprites = Sprites::build(sprites).unwrap();
    Geometry::build(vec![], vec![], None, None)
        .unwrap()
        .with_sprites(sprites.into(), eye)
}

fn sprite(centre: Vec3, opacity: f32) -> Sprite {
    Sprite {
        centre,
        radius: 1.0,
        opacity,
        softness: 1.0,
    }
}

fn transmittance(scene: &Geometry, ray: &Ray) -> f64 {
    let depth = scene.transmittance_depth::<PARTICLES>(ray);
    if depth.is_blocked() {
        return 0.0;
    }
    libm::exp(-f64::from(depth.depth()) / f64::from(OPTICAL_DEPTH_SCALE))
}

/// The profile in double precision, at the square of the distance over the radius.
fn alpha(s: &Sprite, share: f64) -> f64 {
    let level = ((1.0 - share) / f64::from(s.softness)).clamp(0.0, 1.0);
    f64::from(s.opacity) * level * level
}

#[test]
fn rays_meet_the_discs_that_double_precision_says() {
    let mut r = Random(1);
    let all: Vec<_> = (0..200)
        .map(|_| Sprite {
            centre: r.cube() * 5.0,
            radius: 0.1 + r.unit(),
            opacity: 0.5 * r.unit(),
            softness: 0.1 + 0.9 * r.unit(),
        })
        .collect();
    for eye in [Vec3::ZERO, Vec3::new(9.0, -3.0, 4.0)] {
        let scene = scene(all.clone(), eye);
        let mut met = 0;
        for i in 0..4000 {
            let ray = Ray::new(r.cube() * 6.0, r.direction());
            let (o, d) = (ray.o.as_dvec3(), ray.d.as_dvec3());
            let mut expected = 1.0;
            let mut margin = 0.0_f64;
            for s in &all {
                let n = (eye.as_dvec3() - s.centre.as_dvec3()).normalize();
                let w: DVec3 = o - s.centre.as_dvec3();
                let t = -n.dot(w) / n.dot(d);
                let share = (w + t * d).length_squared() / f64::from(s.radius * s.radius);
                // How far a distance rounds along a slanting ray.
                margin += if share < 1.1 {
                    1e-5 / n.dot(d).abs()
                } else {
                    0.0
                };
                if t > 0.0 && share < 1.0 {
                    expected *= 1.0 - alpha(s, share);
                }
            }
            let found = transmittance(&scene, &ray);
            met += u32::from(expected < 1.0);
            assert!(
                (found - expected).abs() < 1e-5 + margin,
                "{i}: {found} {expected}"
            );
            if let Some(hit) = scene.intersect::<PARTICLES>(&ray, i) {
                let HitKind::Sprite { prim } = hit.kind else {
                    panic!("{hit:?}")
                };
                let s = &all[prim as usize];
                let point = scene.surface_point(&ray, &hit);
                let n = (eye - s.centre).normalize();
                assert!(point.n_geometric.dot(n) > 0.999_99);
                assert!(point.p.distance(ray.at(hit.t)) < 1e-4);
                assert!(n.dot(point.p - s.centre).abs() < 1e-5);
                // A ray from there does not meet the same disc again, either way.
                for w in [r.direction(), r.direction(), -ray.d] {
                    let away = Ray::new(point.origin_towards(w), w);
                    let alone = self::scene(vec![Sprite { opacity: 1.0, ..*s }], eye);
                    assert!(alone.intersect::<PARTICLES>(&away, 0).is_none(), "{w}");
                }
            }
            assert!(scene.intersect::<NOTHING>(&ray, i).is_none());
        }
        assert!(met > 1000, "{met}");
    }
}

// k concentric sprites on the axis: (1 - a)^k; 1000 of .005 let .00665397 through.
#[test]
fn concentric_sprites_transmit_their_power() {
    for (count, opacity, expected) in [
        (1000_i32, 0.005_f32, 0.006_653_97),
        (100, 0.1, 2.656e-5),
        (3, 0.5, 0.125),
        (1, 0.0, 1.0),
    ] {
        let all = vec![sprite(Vec3::ZERO, opacity); count as usize];
        let scene = scene(all, Vec3::Z * 5.0);
        let ray = Ray::new(Vec3::Z * 5.0, Vec3::NEG_Z);
        let found = transmittance(&scene, &ray);
        assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
        // The same from the hashes of many rays: binomial, 4 sigma.
        let mut r = Random(6);
        let n = 50_000;
        let passed = (0..n)
            .filter(|_| scene.intersect::<PARTICLES>(&ray, r.next()).is_none())
            .count() as f64;
        let (mean, sigma) = (
            expected * f64::from(n),
            (expected * (1.0 - expected) * f64::from(n)).sqrt(),
        );
        assert!(
            (passed - mean).abs() <= 4.0 * sigma + 1e-9,
            "{passed} {mean}"
        );
    }
}

// Planes 1e-4 apart all count: nothing is skipped behind a crossing.
#[test]
fn layers_close_together_all_count() {
    let all = (0..1000)
        .map(|i| Sprite {
            radius: 100.0,
            ..sprite(Vec3::Z * (i as f32 * -1e-4), 0.005)
        })
        .collect();
    let scene = scene(all, Vec3::Z * 5.0);
    let found = transmittance(&scene, &Ray::new(Vec3::Z * 5.0, Vec3::NEG_Z));
    assert!((found / 0.006_653_97 - 1.0).abs() < 1e-3, "{found}");
    // From among them, half of them.
    let half = transmittance(&scene, &Ray::new(Vec3::Z * -0.04995, Vec3::NEG_Z));
    let expected = libm::pow(0.995, 500.0);
    assert!((half / expected - 1.0).abs() < 1e-3, "{half}");
}

// q = 1 - (r / R)^2 is uniform over the disc, so the mean opacity is
// a (1 - 2/3 softness).
#[test]
fn the_mean_over_the_disc_is_that_of_the_profile() {
    for softness in [0.01_f32, 0.3, 1.0] {
        let s = Sprite {
            radius: 2.0,
            softness,
            ..sprite(Vec3::new(1.0, 2.0, -3.0), 0.6)
        };
        let eye = Vec3::new(1.0, 2.0, 40.0);
        let scene = scene(vec![s], eye);
        let side = 600;
        let (mut sum, mut stopped, mut met) = (0.0, 0_u32, 0_u32);
        for i in 0..side * side {
            let at = |k: i32| ((k as f32 + 0.5) / side as f32 - 0.5) * 4.0;
            let offset = Vec3::new(at(i % side), at(i / side), 1.0);
            // Parallel to the axis.
            let ray = Ray::new(s.centre + offset, Vec3::NEG_Z);
            sum += 1.0 - transmittance(&scene, &ray);
            let key = (i as u64).wrapping_mul(0x1234_5678_9abc_def1);
            stopped += u32::from(scene.intersect::<PARTICLES>(&ray, key).is_some());
            met += u32::from(offset.x * offset.x + offset.y * offset.y < 4.0);
        }
        let expected = 0.6 * (1.0 - 2.0 / 3.0 * f64::from(softness));
        let mean = sum / f64::from(met);
        assert!(
            (mean / expected - 1.0).abs() < 2e-3,
            "{softness}: {mean} {expected}"
        );
        let share = f64::from(stopped) / f64::from(met);
        let sigma = (expected / f64::from(met)).sqrt();
        assert!(
            (share - expected).abs() < 4.0 * sigma + 2e-3 * expected,
            "{share}"
        );
    }
}

#[test]
fn a_ray_along_the_disc_misses_and_the_end_of_a_ray_counts() {
    let eye = Vec3::new(3.0, 4.0, 5.0);
    let scene = scene(vec![sprite(Vec3::ZERO, 1.0)], eye);
    let mut r = Random(3);
    for i in 0..1000 {
        let along = eye.cross(r.direction()).normalize();
        let ray = Ray::new(along * -3.0, along);
        assert!(scene.intersect::<PARTICLES>(&ray, i).is_none());
        assert_eq!(scene.transmittance_depth::<PARTICLES>(&ray).depth(), 0);
    }
    let (from, towards) = (eye.normalize() * 4.0, -eye.normalize());
    for (t_max, is_blocked) in [(3.99, false), (4.01, true)] {
        let ray = Ray {
            t_max,
            ..Ray::new(from, towards)
        };
        assert_eq!(scene.intersect::<PARTICLES>(&ray, 1).is_some(), is_blocked);
        assert_eq!(
            scene.transmittance_depth::<PARTICLES>(&ray).is_blocked(),
            is_blocked
        );
    }
    // An eye in the very centre sees nothing of it.
    let within = self::scene(vec![sprite(Vec3::ZERO, 1.0)], Vec3::ZERO);
    let ray = Ray::new(Vec3::Z * 2.0, Vec3::NEG_Z);
    assert!(within.intersect::<PARTICLES>(&ray, 0).is_none());
}

#[test]
fn bad_sprites_are_refused() {
    let good = sprite(Vec3::ZERO, 0.5);
    for bad in [
        Sprite {
            centre: Vec3::NAN,
            ..good
        },
        Sprite {
            radius: 0.0,
            ..good
        },
        Sprite {
            radius: 1e30,
            ..good
        },
        Sprite {
            radius: 1e-30,
            ..good
        },
        Sprite {
            opacity: 1.1,
            ..good
        },
        Sprite {
            softness: 0.0,
            ..good
        },
        Sprite {
            softness: f32::NAN,
            ..good
        },
    ] {
        assert!(Sprites::build(vec![good, bad]).is_err(), "{bad:?}");
    }
    assert!(Sprites::build(vec![]).is_ok());
}
