//! The fuselage's closed skin and its glazing.

use super::atlas;
use super::shape::{
    Body, CABIN_WINDOWS, COCKPIT_PANES, FUSELAGE, LENGTH, NOSE_Z, Pane, angle_of_turn, cabin_pane,
};
use crate::loft::loft_uv;
use crate::mesh::Mesh;
use crate::vec3::{Vec3, vec3};
use std::f64::consts::PI;

/// Points around the skin.
const AROUND: usize = 72;

/// Adds skin, windows and window frames.
pub(super) fn add(mesh: &mut Mesh) {
    mesh.begin("fuselage", "livery");
    let stations = stations();
    let rings: Vec<Vec<Vec3>> = stations
        .iter()
        .map(|&t| {
            (0..AROUND)
                .map(|j| {
                    let p = FUSELAGE.point(t, angle_of_turn(j as f64 / AROUND as f64));
                    // The poles are exact points whatever the rounding says.
                    let pole = t <= 0.0 || t >= LENGTH;
                    place(if pole {
                        vec3(0.0, FUSELAGE.point(t, 0.0).y, t)
                    } else {
                        p
                    })
                })
                .collect()
        })
        .collect();
    loft_uv(mesh, &rings, &|i, j| {
        atlas::FUSELAGE.uv(stations[i], j as f64 / AROUND as f64)
    });
    mesh.begin("glass", "glass");
    for_each_pane(|pane, scale| pane_skin(mesh, &pane, scale));
    mesh.begin("window-frames", "frame");
    for_each_pane(|pane, scale| pane_frame(mesh, &pane, scale));
}

fn place(p: Vec3) -> Vec3 {
    p + vec3(0.0, 0.0, NOSE_Z)
}

/// Dense at the nose, at the windscreen and at the very end.
fn stations() -> Vec<f64> {
    let mut list: Vec<f64> = (0..44)
        .map(|i| 1.7 * libm::pow(f64::from(i) / 44.0, 2.0))
        .collect();
    list.extend((0..22).map(|i| 1.7 + 0.05 * f64::from(i)));
    list.extend((0..66).map(|i| 2.8 + 9.05 * f64::from(i) / 66.0));
    list.extend((0..=10).map(|i| 11.85 + 0.35 * libm::sin(0.5 * PI * f64::from(i) / 10.0)));
    if let Some(last) = list.last_mut() {
        *last = LENGTH;
    }
    list
}

/// Calls back with every pane of both sides and how round its corners are
/// (exponent of the superellipse).
fn for_each_pane(mut visit: impl FnMut(Pane, f64)) {
    let mirrored = |pane: Pane| {
        // Mirroring swaps forward and aft in the winding as well.
        let flip = |(t, angle): (f64, f64)| (t, 180.0 - angle);
        [flip(pane[1]), flip(pane[0]), flip(pane[3]), flip(pane[2])]
    };
    for pane in COCKPIT_PANES {
        visit(pane, 9.0);
        visit(mirrored(pane), 9.0);
    }
    for i in 0..CABIN_WINDOWS {
        visit(cabin_pane(i), 4.5);
        visit(mirrored(cabin_pane(i)), 4.5);
    }
}

/// Point of a pane: (a, b) in [-1, 1] squared, `height` over the skin.
fn on_pane(body: &Body, pane: &Pane, a: f64, b: f64, height: f64) -> Vec3 {
    let (fa, fb) = (0.5 * (a + 1.0), 0.5 * (b + 1.0));
    let weights = [
        (1.0 - fa) * (1.0 - fb),
        fa * (1.0 - fb),
        fa * fb,
        (1.0 - fa) * fb,
    ];
    let (mut t, mut angle) = (0.0, 0.0);
    for (weight, corner) in weights.iter().zip(pane) {
        t += weight * corner.0;
        angle += weight * corner.1;
    }
    place(body.offset_point(t, angle.to_radians(), height))
}

/// Points around a pane's outline.
const OUTLINE: usize = 36;

/// Outline point `j` of the superellipse, anticlockwise in (a, b).
fn outline(j: usize, exponent: f64) -> (f64, f64) {
    let angle = 2.0 * PI * (j % OUTLINE) as f64 / OUTLINE as f64;
    let (s, c) = (libm::sin(angle), libm::cos(angle));
    // Radial scaling keeps the points evenly spread over the corners.
    let norm = libm::pow(
        libm::pow(c.abs(), exponent) + libm::pow(s.abs(), exponent),
        1.0 / exponent,
    );
    (c / norm, s / norm)
}

/// A slightly domed pane over the skin.
fn pane_skin(mesh: &mut Mesh, pane: &Pane, exponent: f64) {
    const RINGS: usize = 4;
    let dome = |r: f64| 0.006 + 0.012 * (1.0 - r * r);
    let middle = mesh.vertex(on_pane(&FUSELAGE, pane, 0.0, 0.0, dome(0.0)));
    let mut before: Vec<u32> = vec![middle; OUTLINE];
    for ring in 1..=RINGS {
        let r = ring as f64 / RINGS as f64;
        let now: Vec<u32> = (0..OUTLINE)
            .map(|j| {
                let (a, b) = outline(j, exponent);
                mesh.vertex(on_pane(&FUSELAGE, pane, a * r, b * r, dome(r)))
            })
            .collect();
        for j in 0..OUTLINE {
            let k = (j + 1) % OUTLINE;
            pane_face(mesh, [before[j], now[j], now[k], before[k]]);
        }
        before = now;
    }
}

/// A raised frame around the pane.
fn pane_frame(mesh: &mut Mesh, pane: &Pane, exponent: f64) {
    let profile = [(0.97, 0.0), (0.985, 0.014), (1.08, 0.014), (1.11, -0.004)];
    let mut before: Vec<u32> = Vec::new();
    for (r, height) in profile {
        let now: Vec<u32> = (0..OUTLINE)
            .map(|j| {
                let (a, b) = outline(j, exponent);
                mesh.vertex(on_pane(&FUSELAGE, pane, a * r, b * r, height))
            })
            .collect();
        for j in 0..before.len() {
            let k = (j + 1) % OUTLINE;
            pane_face(mesh, [before[j], now[j], now[k], before[k]]);
        }
        before = now;
    }
}

/// (a, b) is (aft, up) on the right side and (forward, up) on the left, which
/// turns clockwise seen from outside on both; so the face is reversed.
fn pane_face(mesh: &mut Mesh, corners: [u32; 4]) {
    let [a, b, c, d] = corners;
    mesh.face(&[a, d, c, b]);
}
