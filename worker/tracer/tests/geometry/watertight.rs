//! No ray leaves a closed body, also when aimed at its very edges and corners.

use glam::Vec3;
use shearwater_tracer::geometry::{Geometry, Ray};
use shearwater_tracer::uses::NOTHING;

use super::shapes::{Random, alone, ball};

fn leaks(scene: &Geometry, rays: impl Iterator<Item = Ray>) -> usize {
    rays.filter(|ray| scene.intersect::<NOTHING>(ray, 0).is_none())
        .count()
}

#[test]
fn along_the_axes_at_grid_corners() {
    // Directions with zero components, exactly at vertices: 0 * inf in the boxes.
    let body = ball(16, Vec3::ZERO, 1.0);
    let scene = alone(&body);
    for p in &body.0 {
        for axis in 0..3 {
            let mut d = Vec3::ZERO;
            d[axis] = if p[axis] < 0.0 { -1.0 } else { 1.0 };
            let mut o = *p;
            o[axis] = 0.0;
            // Only where the ray starts inside.
            if o.length() < 0.8 {
                assert!(
                    scene.intersect::<NOTHING>(&Ray::new(o, d), 0).is_some(),
                    "{p} {axis}"
                );
            }
        }
    }
}

#[test]
fn slivers_a_hundred_metres_long() {
    // A strip of beams one millimetre wide: every ray through the strip hits.
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..=1000_u32 {
        let x = i as f32 * 1e-3;
        positions.extend([Vec3::new(x, 0.0, x), Vec3::new(x + 20.0, 100.0, 30.0 + x)]);
        if i > 0 {
            let v = 2 * i;
            triangles.extend([[v - 2, v, v - 1], [v, v + 1, v - 1]]);
        }
    }
    let scene = alone(&(positions.clone(), triangles));
    let mut r = Random(3);
    let misses = leaks(
        &scene,
        (0..200_000).map(|_| {
            let i = 2 * (1 + r.below(998));
            let p = positions[i].lerp(positions[i + 1], 0.001 + 0.99 * r.unit());
            let from = p + Vec3::new(
                30.0 * r.unit() - 15.0,
                10.0 * r.unit(),
                -20.0 - 80.0 * r.unit(),
            );
            Ray::new(from, (p - from).normalize())
        }),
    );
    assert_eq!(misses, 0);
}
