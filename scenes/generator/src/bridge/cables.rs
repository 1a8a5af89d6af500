//! Main cables, cable bands and suspenders.

use super::layout::{
    CABLE_RADIUS, CABLE_Z, END_X, PANEL, SUSPENDER_STEP, TOWER_X, cable_height, road_height,
};
use crate::loft::{End, revolve, tube};
use crate::mesh::Mesh;
use crate::vec3::{Vec3, vec3};

/// Adds both cables with everything that hangs on them.
pub(super) fn add(mesh: &mut Mesh) {
    for (name, z) in [("left", -CABLE_Z), ("right", CABLE_Z)] {
        mesh.begin(&format!("cable-{name}"), "paint");
        tube(mesh, &path(z), CABLE_RADIUS, 10, End::Fan);
        hand_ropes(mesh, z);
        mesh.begin(&format!("suspenders-{name}"), "paint");
        for x in suspender_places() {
            suspender(mesh, x, z);
        }
    }
}

/// The cable's line, a point per panel, ending in the anchorages.
fn path(z: f64) -> Vec<Vec3> {
    let mut xs: Vec<f64> = Vec::new();
    for (from, to, steps) in [
        (-END_X, -TOWER_X, 46),
        (-TOWER_X, TOWER_X, 168),
        (TOWER_X, END_X, 46),
    ] {
        let step = (to - from) / f64::from(steps);
        xs.extend((0..steps).map(|i| from + step * f64::from(i)));
    }
    xs.push(END_X);
    let mut path: Vec<Vec3> = xs.iter().map(|&x| vec3(x, cable_height(x), z)).collect();
    // Down into the anchorage, steeper than the road.
    let end = |side: f64| vec3(side * (END_X + 34.0), road_height(END_X) - 9.0, z);
    path.insert(0, end(-1.0));
    path.push(end(1.0));
    path
}

/// The two ropes above a cable that its climbers hold, with their posts.
fn hand_ropes(mesh: &mut Mesh, z: f64) {
    let line = path(z);
    for side in [-0.45, 0.45] {
        let rope: Vec<Vec3> = line[1..line.len() - 1]
            .iter()
            .map(|&p| p + vec3(0.0, 1.45, side))
            .collect();
        tube(mesh, &rope, 0.035, 4, End::Open);
    }
}

/// Every 15.24 m, counted from the middle of each span, clear of the towers.
fn suspender_places() -> Vec<f64> {
    let mut places = Vec::new();
    let main = (TOWER_X / SUSPENDER_STEP) as i32;
    for i in -main..=main {
        let x = f64::from(i) * SUSPENDER_STEP;
        if TOWER_X - x.abs() > 9.0 {
            places.push(x);
        }
    }
    for side in [-1.0, 1.0] {
        for i in 1..=22 {
            let x = TOWER_X + f64::from(i) * SUSPENDER_STEP;
            if x < END_X - 4.0 && cable_height(x) > road_height(x) + 3.0 {
                places.push(side * x);
            }
        }
    }
    places
}

/// A pair of ropes over a band on the cable, down to the truss's top chord.
fn suspender(mesh: &mut Mesh, x: f64, z: f64) {
    let top = vec3(x, cable_height(x), z);
    let along = vec3(
        1.0,
        (cable_height(x + 0.5) - cable_height(x - 0.5)).min(2.0),
        0.0,
    );
    let band = [
        (-0.55, CABLE_RADIUS),
        (-0.55, CABLE_RADIUS + 0.10),
        (0.55, CABLE_RADIUS + 0.10),
        (0.55, CABLE_RADIUS),
    ];
    revolve(mesh, top, along.normalized(), &band, 10);
    let foot = road_height(x) - 0.6;
    for shift in [-0.28, 0.28] {
        let rope = [vec3(x + shift, top.y, z), vec3(x + shift, foot, z)];
        tube(mesh, &rope, 0.075, 6, End::Open);
    }
    let socket = vec3(x, foot + 0.3 * PANEL.min(2.0), z);
    super::members::block_around(mesh, socket, vec3(0.5, 0.25, 0.3));
}
