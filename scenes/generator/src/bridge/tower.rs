//! A tower: two stepped, fluted legs on a pier, portals between them above the
//! road, crosses below.

use super::layout::{CABLE_Z, TOWER_TOP, road_height};
use super::members::{Level, beam, block, block_around, boat_outline, prism, stepped_outline};
use crate::loft::revolve;
use crate::mesh::Mesh;
use crate::vec3::{Vec3, vec3};

/// A storey of a leg: from, to, half depth along the bridge, half width across.
const STOREYS: [(f64, f64, f64, f64); 7] = [
    (13.0, 41.0, 7.9, 5.0),
    (41.0, 68.0, 7.5, 4.75),
    (68.0, 113.0, 7.0, 4.45),
    (113.0, 150.0, 6.3, 4.1),
    (150.0, 184.0, 5.6, 3.75),
    (184.0, 214.0, 5.0, 3.4),
    (214.0, 222.5, 4.5, 3.1),
];

/// Portals above the road: middle height and half height.
const PORTALS: [(f64, f64); 4] = [(110.0, 5.2), (147.5, 4.6), (182.0, 4.2), (214.5, 4.6)];

/// Adds the tower that stands at `x`, its group named after `name`.
pub(super) fn add(mesh: &mut Mesh, x: f64, name: &str) {
    mesh.begin(&format!("pier-{name}"), "concrete");
    pier(mesh, x);
    mesh.begin(&format!("tower-{name}"), "paint");
    for z in [-CABLE_Z, CABLE_Z] {
        leg(mesh, x, z);
    }
    for (y, half) in PORTALS {
        portal(mesh, x, y, half);
    }
    below_road(mesh, x);
    mesh.begin(&format!("beacons-{name}"), "lamp");
    for z in [-CABLE_Z, CABLE_Z] {
        let ball: Vec<(f64, f64)> = (0..=8)
            .map(|i| {
                let angle = std::f64::consts::PI * f64::from(i) / 8.0;
                let pole = i == 0 || i == 8;
                (
                    -0.9 * libm::cos(angle),
                    if pole { 0.0 } else { 0.9 * libm::sin(angle) },
                )
            })
            .collect();
        revolve(
            mesh,
            vec3(x, TOWER_TOP + 5.2, z),
            vec3(0.0, 1.0, 0.0),
            &ball,
            14,
        );
    }
}

/// Pier with a fender ring around it.
fn pier(mesh: &mut Mesh, x: f64) {
    let plan = boat_outline(40);
    let middle = vec3(x, 0.0, 0.0);
    let level = |y: f64, sx: f64, sz: f64| Level { y, scale: (sx, sz) };
    prism(
        mesh,
        middle,
        &plan,
        &[level(-12.0, 17.0, 31.0), level(4.5, 16.2, 30.2)],
    );
    prism(
        mesh,
        middle,
        &plan,
        &[level(4.4, 14.6, 27.4), level(9.0, 14.0, 26.8)],
    );
    for z in [-CABLE_Z, CABLE_Z] {
        let steps = stepped_outline(&[(1.0, 0.72), (0.82, 1.0)]);
        let at = vec3(x, 0.0, z);
        prism(
            mesh,
            at,
            &steps,
            &[level(8.9, 10.6, 7.6), level(13.2, 9.6, 6.7)],
        );
    }
}

fn leg(mesh: &mut Mesh, x: f64, z: f64) {
    let plan = stepped_outline(&[(1.0, 0.40), (0.90, 0.62), (0.74, 0.82), (0.52, 1.0)]);
    let middle = vec3(x, 0.0, z);
    for (i, &(from, to, half_x, half_z)) in STOREYS.iter().enumerate() {
        let shrink = 0.965;
        prism(
            mesh,
            middle,
            &plan,
            &[
                Level {
                    y: from,
                    scale: (half_x, half_z),
                },
                Level {
                    y: to,
                    scale: (half_x * shrink, half_z * shrink),
                },
            ],
        );
        // A collar under each setback, and fins that run a little past it.
        let collar = |y: f64, h: f64, grow: f64| {
            [
                Level {
                    y,
                    scale: (half_x * grow, half_z * grow),
                },
                Level {
                    y: y + h,
                    scale: (half_x * grow, half_z * grow),
                },
            ]
        };
        prism(mesh, middle, &plan, &collar(to - 1.6, 0.9, 0.995));
        prism(mesh, middle, &plan, &collar(from, 1.0, 1.03));
        if i > 0 {
            for side in [-1.0, 1.0] {
                let face = side * half_x * 0.985;
                for groove in [-0.24, 0.0, 0.24] {
                    block_around(
                        mesh,
                        vec3(x + face, 0.5 * (from + to), z + groove * half_z),
                        vec3(0.14, 0.5 * (to - from) - 2.4, 0.07 * half_z),
                    );
                }
            }
        }
    }
    saddle(mesh, x, z);
}

/// Stepped housing of the cable's saddle on a leg.
fn saddle(mesh: &mut Mesh, x: f64, z: f64) {
    for (y, height, half_x, half_z) in [
        (222.4, 2.0, 4.0, 2.7),
        (224.3, 1.8, 3.3, 2.2),
        (226.0, 1.8, 2.6, 1.7),
        (227.7, 1.2, 1.2, 0.9),
    ] {
        block(
            mesh,
            vec3(x - half_x, y, z - half_z),
            vec3(x + half_x, y + height, z + half_z),
        );
    }
    block_around(mesh, vec3(x, 230.0, z), vec3(0.18, 2.2, 0.18));
}

/// Half depth of the legs at a height.
fn half_depth(y: f64) -> f64 {
    STOREYS
        .iter()
        .find(|storey| y < storey.1)
        .map_or(4.4, |storey| storey.2)
}

/// Half width of the legs at a height.
fn half_width(y: f64) -> f64 {
    STOREYS
        .iter()
        .find(|storey| y < storey.1)
        .map_or(3.0, |storey| storey.3)
}

/// A portal: a box between the legs, vertical ribs on both faces, cornices,
/// and stepped brackets in its lower corners.
fn portal(mesh: &mut Mesh, x: f64, y: f64, half: f64) {
    let depth = half_depth(y - half) * 0.62;
    let clear = CABLE_Z - half_width(y - half) * 0.96;
    block_around(mesh, vec3(x, y, 0.0), vec3(depth, half, clear + 0.6));
    for side in [-1.0, 1.0] {
        let face = x + side * depth;
        for (level, tall) in [(half - 0.55, 0.55), (-half + 0.45, 0.45)] {
            block_around(
                mesh,
                vec3(face, y + level, 0.0),
                vec3(0.55, tall, clear + 0.4),
            );
        }
        let ribs = 15;
        for i in 0..ribs {
            let z = (f64::from(i) / f64::from(ribs - 1) * 2.0 - 1.0) * (clear - 0.5);
            // Ribs are longest in the middle: a chevron of the period.
            let tall = (half - 1.1) * (1.0 - 0.22 * (z / clear).abs());
            block_around(
                mesh,
                vec3(face, y + half - 1.1 - tall, z),
                vec3(0.42, tall, 0.34),
            );
        }
    }
    let steps = [(3.4, 1.3), (2.2, 2.9), (1.15, 4.8)];
    for (reach, drop) in steps {
        for side in [-1.0, 1.0] {
            let outer = side * (clear + 0.5);
            let inner = side * (clear - reach);
            block(
                mesh,
                vec3(x - depth * 0.92, y - half - drop, outer.min(inner)),
                vec3(x + depth * 0.92, y - half + 0.2, outer.max(inner)),
            );
        }
    }
}

/// Struts and crosses between pier and road.
fn below_road(mesh: &mut Mesh, x: f64) {
    let strut = |mesh: &mut Mesh, y: f64, half: f64| {
        let depth = half_depth(y) * 0.6;
        block_around(
            mesh,
            vec3(x, y, 0.0),
            vec3(depth, half, CABLE_Z - half_width(y) + 0.6),
        );
    };
    let deck = road_height(x) - 9.6;
    strut(mesh, deck, 1.9);
    strut(mesh, 39.5, 2.0);
    strut(mesh, 15.6, 1.9);
    for (low, high) in [(17.0, 38.0), (41.0, deck - 1.4)] {
        let reach = CABLE_Z - half_width(low) + 0.5;
        for face in [-1.0, 1.0] {
            let at = x + face * half_depth(low) * 0.42;
            for side in [-1.0, 1.0] {
                cross(
                    mesh,
                    vec3(at, low, -side * reach),
                    vec3(at, high, side * reach),
                );
            }
        }
        block_around(
            mesh,
            vec3(x, 0.5 * (low + high), 0.0),
            vec3(half_depth(low) * 0.42 + 0.8, 1.9, 1.9),
        );
    }
}

/// One bar of a cross, with the lighter plates on both sides.
fn cross(mesh: &mut Mesh, a: Vec3, b: Vec3) {
    beam(mesh, a, b, 1.0, 2.1);
    beam(mesh, a, b, 1.5, 1.3);
}
