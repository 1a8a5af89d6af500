//! Pylons and anchorages at the ends of the side spans, and the bents that
//! carry the approaches.

use super::layout::{APPROACH_END_X, END_X, TRUSS_DEPTH, road_height};
use super::members::{Level, beam, block, prism, stepped_outline};
use crate::mesh::Mesh;
use crate::vec3::vec3;

/// Adds both ends.
pub(super) fn add(mesh: &mut Mesh) {
    for (name, side) in [("west", -1.0), ("east", 1.0)] {
        mesh.begin(&format!("pylons-{name}"), "concrete");
        for (x, grow) in [(END_X + 6.0, 1.0), (END_X + 62.0, 0.9)] {
            pylon(mesh, side * x, grow);
        }
        anchorage(mesh, side);
        mesh.begin(&format!("bents-{name}"), "paint");
        let mut x = END_X + 112.0;
        while x < APPROACH_END_X {
            bent(mesh, side * x);
            x += 49.0;
        }
    }
}

/// A gate of two stepped concrete towers, joined below the road.
fn pylon(mesh: &mut Mesh, x: f64, grow: f64) {
    let plan = stepped_outline(&[(1.0, 0.55), (0.80, 0.80), (0.58, 1.0)]);
    let road = road_height(x);
    let level = |y: f64, sx: f64, sz: f64| Level {
        y,
        scale: (sx * grow, sz * grow),
    };
    for z in [-18.2, 18.2] {
        let middle = vec3(x, 0.0, z);
        let storeys = [
            (-10.0, 30.0, 8.6, 5.0),
            (30.0, road, 7.8, 4.5),
            (road, road + 15.0, 6.6, 3.9),
            (road + 15.0, road + 20.0, 5.4, 3.1),
            (road + 20.0, road + 23.0, 4.1, 2.3),
        ];
        for (from, to, half_x, half_z) in storeys {
            prism(
                mesh,
                middle,
                &plan,
                &[
                    level(from, half_x, half_z),
                    level(to, half_x * 0.97, half_z * 0.97),
                ],
            );
        }
    }
    let under = road - TRUSS_DEPTH - 2.0;
    block(
        mesh,
        vec3(x - 6.2, -10.0, -16.0),
        vec3(x + 6.2, under, 16.0),
    );
}

/// The block that holds the cables' ends.
fn anchorage(mesh: &mut Mesh, side: f64) {
    let (a, b) = (side * (END_X + 14.0), side * (END_X + 54.0));
    let top = road_height(END_X) - TRUSS_DEPTH - 1.6;
    block(
        mesh,
        vec3(a.min(b), -10.0, -19.5),
        vec3(a.max(b), top, 19.5),
    );
    for z in [-17.2, 17.2] {
        block(
            mesh,
            vec3(a.min(b), top - 1.0, z - 2.3),
            vec3(a.max(b), top + 5.0, z + 2.3),
        );
    }
}

/// A steel bent: four legs, struts and crosses.
fn bent(mesh: &mut Mesh, x: f64) {
    let top = road_height(x) - TRUSS_DEPTH - 1.2;
    let at = |y: f64, along: f64, across: f64| {
        let spread = 1.0 + 0.35 * (1.0 - y / top);
        vec3(x + along * 3.6 * spread, y, across * 12.6 * spread)
    };
    let levels = [-8.0, 12.0, 30.0, 46.0, top];
    for pair in levels.windows(2) {
        let (low, high) = (pair[0], pair[1]);
        for along in [-1.0, 1.0] {
            for across in [-1.0, 1.0] {
                beam(
                    mesh,
                    at(low, along, across),
                    at(high, along, across),
                    1.1,
                    1.1,
                );
                beam(
                    mesh,
                    at(low, along, across),
                    at(high, along, -across),
                    0.55,
                    0.55,
                );
            }
            beam(mesh, at(high, along, -1.0), at(high, along, 1.0), 0.8, 0.9);
        }
        for across in [-1.0, 1.0] {
            beam(mesh, at(low, -1.0, across), at(high, 1.0, across), 0.5, 0.5);
            beam(mesh, at(low, 1.0, across), at(high, -1.0, across), 0.5, 0.5);
            beam(
                mesh,
                at(high, -1.0, across),
                at(high, 1.0, across),
                0.7,
                0.7,
            );
        }
    }
}
