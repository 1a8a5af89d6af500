//! The road: stiffening trusses, floor beams, laterals, slab and kerbs.

use super::layout::{
    APPROACH_END_X, CABLE_Z, END_X, PANEL, ROAD_HALF_WIDTH, TRUSS_DEPTH, road_height,
};
use super::members::{beam, i_beam};
use crate::mesh::Mesh;
use crate::vec3::{Vec3, vec3};

/// Panel points from one approach's end to the other's.
#[must_use]
pub(super) fn panel_points() -> Vec<f64> {
    let count = (2.0 * APPROACH_END_X / PANEL) as i32;
    (0..=count)
        .map(|i| (f64::from(i) - 0.5 * f64::from(count)) * PANEL)
        .collect()
}

fn top(x: f64, z: f64) -> Vec3 {
    vec3(x, road_height(x) - 0.9, z)
}

fn low(x: f64, z: f64) -> Vec3 {
    top(x, z) - vec3(0.0, TRUSS_DEPTH, 0.0)
}

/// Adds the whole road between the approaches' ends.
pub(super) fn add(mesh: &mut Mesh) {
    let points = panel_points();
    mesh.begin("trusses", "paint");
    for z in [-CABLE_Z, CABLE_Z] {
        for (i, pair) in points.windows(2).enumerate() {
            truss_panel(mesh, pair[0], pair[1], z, i % 2 == 0);
        }
    }
    mesh.begin("floor", "paint");
    for (i, pair) in points.windows(2).enumerate() {
        floor_panel(mesh, pair[0], pair[1], i % 2 == 0);
    }
    mesh.begin("slab", "asphalt");
    for pair in points.chunks(2).zip(points[2..].chunks(2)) {
        let (a, b) = (pair.0[0], pair.1[0]);
        slab(mesh, a, b, -ROAD_HALF_WIDTH, ROAD_HALF_WIDTH, 0.0, 0.45);
    }
    mesh.begin("kerbs", "concrete");
    for pair in points.chunks(2).zip(points[2..].chunks(2)) {
        let (a, b) = (pair.0[0], pair.1[0]);
        for side in [-1.0, 1.0] {
            let (near, far) = (side * 9.6, side * (ROAD_HALF_WIDTH + 0.25));
            slab(mesh, a, b, near.min(far), near.max(far), 0.28, 0.30);
        }
    }
}

/// A slab from x = a to b whose top lies `lift` above the road.
fn slab(mesh: &mut Mesh, a: f64, b: f64, z0: f64, z1: f64, lift: f64, thick: f64) {
    let middle = 0.5 * (z0 + z1);
    let at = |x: f64| vec3(x, road_height(x) + lift - 0.5 * thick, middle);
    beam(mesh, at(a), at(b), z1 - z0, thick);
}

/// Chords, post and diagonal of one panel; the diagonals alternate (Warren).
fn truss_panel(mesh: &mut Mesh, a: f64, b: f64, z: f64, falling: bool) {
    beam(mesh, top(a, z), top(b, z), 0.85, 0.95);
    beam(mesh, low(a, z), low(b, z), 0.85, 0.95);
    beam(mesh, low(a, z), top(a, z), 0.55, 0.5);
    let (from, to) = if falling {
        (top(a, z), low(b, z))
    } else {
        (low(a, z), top(b, z))
    };
    i_beam(mesh, from, to, 0.70, 0.62, 0.13);
    // Gusset plates where the diagonals meet the chords.
    for joint in [from, to] {
        beam(
            mesh,
            joint - vec3(0.75, 0.0, 0.0),
            joint + vec3(0.75, 0.0, 0.0),
            0.95,
            1.5,
        );
    }
}

/// Floor beam, stringers, and the lateral bracing of the bottom chords.
fn floor_panel(mesh: &mut Mesh, a: f64, b: f64, falling: bool) {
    let drop = vec3(0.0, 0.65, 0.0);
    i_beam(
        mesh,
        top(a, -CABLE_Z) - drop,
        top(a, CABLE_Z) - drop,
        0.5,
        1.7,
        0.10,
    );
    beam(mesh, low(a, -CABLE_Z), low(a, CABLE_Z), 0.45, 0.5);
    for i in -2..=2 {
        let z = f64::from(i) * 5.2;
        beam(mesh, top(a, z), top(b, z), 0.3, 0.75);
    }
    let (from, to) = if falling {
        (-CABLE_Z, CABLE_Z)
    } else {
        (CABLE_Z, -CABLE_Z)
    };
    beam(mesh, low(a, from), low(b, 0.0), 0.42, 0.42);
    beam(mesh, low(a, to), low(b, 0.0), 0.42, 0.42);
    if a.abs() <= END_X {
        // Sway frame: from the bottom chords up to the floor beam's middle.
        for side in [-1.0, 1.0] {
            beam(
                mesh,
                low(a, side * CABLE_Z),
                top(a, side * 4.0) - drop * 2.0,
                0.3,
                0.3,
            );
        }
    }
}
