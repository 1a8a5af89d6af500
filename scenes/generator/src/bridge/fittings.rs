//! Railings and street lamps.

use super::layout::{APPROACH_END_X, PANEL, ROAD_HALF_WIDTH, road_height};
use super::members::{beam, block_around};
use crate::loft::{End, tube};
use crate::mesh::Mesh;
use crate::vec3::{Vec3, vec3};

/// Posts of the railing per panel.
const POSTS: i32 = 2;

fn kerb(x: f64, z: f64) -> Vec3 {
    vec3(x, road_height(x) + 0.25, z)
}

/// Adds railings on both sides and lamps every six panels.
pub(super) fn add(mesh: &mut Mesh) {
    let points = super::deck::panel_points();
    let up = |height: f64| vec3(0.0, height, 0.0);
    mesh.begin("railings", "paint");
    for side in [-1.0, 1.0] {
        let z = side * (ROAD_HALF_WIDTH + 0.1);
        for pair in points.windows(2) {
            let (a, b) = (kerb(pair[0], z), kerb(pair[1], z));
            for (height, width) in [(1.30, 0.14), (0.62, 0.10)] {
                beam(mesh, a + up(height), b + up(height), width, 0.10);
            }
            for post in 0..POSTS {
                let foot = a.lerp(b, f64::from(post) / f64::from(POSTS));
                beam(mesh, foot, foot + up(1.35), 0.13, 0.13);
            }
        }
    }
    mesh.begin("lamp-posts", "paint");
    for_each_lamp(|x, side| post(mesh, x, side));
    mesh.begin("lanterns", "lamp");
    for_each_lamp(|x, side| {
        let middle = kerb(x, side * 9.9) + vec3(0.0, 8.62, -side * 2.3);
        block_around(mesh, middle, vec3(0.5, 0.14, 0.20));
    });
}

/// Places of the lamps: x and the side of the road.
fn for_each_lamp(mut visit: impl FnMut(f64, f64)) {
    let count = (APPROACH_END_X / (6.0 * PANEL)) as i32;
    for side in [-1.0, 1.0] {
        for i in -count..=count {
            visit(f64::from(i) * 6.0 * PANEL, side);
        }
    }
}

/// A lamp post whose arm bends over the road.
fn post(mesh: &mut Mesh, x: f64, side: f64) {
    let foot = kerb(x, side * 9.9);
    let arc: Vec<Vec3> = (0..=5)
        .map(|i| {
            let angle = 0.5 * std::f64::consts::PI * f64::from(i) / 5.0;
            foot + vec3(
                0.0,
                7.4 + 1.3 * libm::sin(angle),
                -side * 1.9 * (1.0 - libm::cos(angle)),
            )
        })
        .collect();
    let mut path = vec![foot, foot + vec3(0.0, 3.7, 0.0)];
    path.extend(arc);
    tube(mesh, &path, 0.11, 7, End::Fan);
    block_around(mesh, foot + vec3(0.0, 0.4, 0.0), vec3(0.28, 0.4, 0.28));
}
