//! No ray leaves a closed body, also when aimed at its very edges and corners.

use glam::Vec3;
use shearwater_tracer::geometry::{Geometry, Ray};
use shearwater_tracer::uses::NOTHING;

use super::shapes::{Random, alone, ball};

fn leaks(scene: &Geometry, rays: impl Iterator<Item = Ray>) -> usize {
    rays.filter(|ray| scene.intersect::<NOTHING>(ray, 0).is_none())
        .count()
}

fn aimed_leaks(offset: f32, vertex_rays: usize, edge_rays: usize) -> (usize, usize) {
    let centre = Vec3::new(offset, -offset, offset);
    let body = ball(64, centre, 1.0);
    let scene = alone(&body);
    let mut r = Random(7);
    let to = |from: Vec3, p: Vec3| Ray::new(from, (p - from).normalize());
    let vertices = (0..vertex_rays).map(|_| {
        let from = centre + r.cube() * 0.4;
        to(from, body.0[r.below(body.0.len())])
    });
    let at_vertices = leaks(&scene, vertices);
    let mut r = Random(8);
    let edges = (0..edge_rays).map(|_| {
        let from = centre + r.cube() * 0.4;
        let t = body.1[r.below(body.1.len())];
        let side = r.below(3);
        let (a, b) = (body.0[t[side] as usize], body.0[t[(side + 1) % 3] as usize]);
        to(from, a + (b - a) * r.unit())
    });
    (at_vertices, leaks(&scene, edges))
}

#[test]
fn a_million_rays_at_corners_and_edges() {
    assert_eq!(aimed_leaks(0.0, 500_000, 500_000), (0, 0));
}

#[test]
fn far_from_the_origin() {
    assert_eq!(aimed_leaks(1e3, 200_000, 200_000), (0, 0));
    assert_eq!(aimed_leaks(1e5, 200_000, 200_000), (0, 0));
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
