//! A three-bladed propeller about its own axis, spinner towards -z.

use super::shape::PROPELLER_RADIUS;
use crate::airfoil::Airfoil;
use crate::curve::{mix, pchip};
use crate::loft::{End, loft, revolve};
use crate::mesh::Mesh;
use crate::vec3::{Vec3, vec3};
use std::f64::consts::TAU;

/// Blades of the propeller.
const BLADES: usize = 3;
/// Inner end of the painted tip.
const TIP_FROM: f64 = 1.08;

/// The propeller; it turns about z, seen from behind clockwise.
#[must_use]
pub fn mesh() -> Mesh {
    let mut mesh = Mesh::default();
    mesh.begin("spinner", "spinner");
    let spinner: Vec<(f64, f64)> = (0..=14)
        .map(|i| {
            let x = f64::from(i) / 14.0;
            (-0.34 + 0.44 * x * x, 0.165 * libm::pow(x, 0.9))
        })
        .chain([(0.115, 0.15), (0.115, 0.0)])
        .collect();
    revolve(
        &mut mesh,
        Vec3::default(),
        vec3(0.0, 0.0, 1.0),
        &spinner,
        32,
    );
    for (name, material, from, to) in [
        ("blades", "blade", 0.10, TIP_FROM),
        ("blade-tips", "blade-tip", TIP_FROM, PROPELLER_RADIUS),
    ] {
        mesh.begin(name, material);
        for blade in 0..BLADES {
            let turn = TAU * blade as f64 / BLADES as f64;
            blade_between(&mut mesh, turn, from, to);
        }
    }
    mesh
}

/// The stretch of one blade between two radii; helical pitch of 2.3 m.
fn blade_between(mesh: &mut Mesh, turn: f64, from: f64, to: f64) {
    let steps = if to < PROPELLER_RADIUS { 26 } else { 12 };
    let rings: Vec<Vec<Vec3>> = (0..=steps)
        .map(|i| {
            let s = f64::from(i) / f64::from(steps);
            // The tip's radii crowd to the end, where it rounds off.
            let s = if to < PROPELLER_RADIUS {
                s
            } else {
                libm::sin(s * 0.25 * TAU)
            };
            ring(mix(from, to, s), turn)
        })
        .collect();
    loft(mesh, &rings, End::Fan, End::Fan);
}

/// Section of the blade at a radius.
fn ring(radius: f64, turn: f64) -> Vec<Vec3> {
    let chord = pchip(
        &[
            (0.10, 0.075),
            (0.22, 0.085),
            (0.45, 0.165),
            (0.70, 0.185),
            (1.0, 0.16),
            (1.22, 0.105),
        ],
        radius,
    );
    let past = ((radius - 1.10) / (PROPELLER_RADIUS - 1.10)).clamp(0.0, 1.0);
    let chord = chord * (1.0 - past * past).max(0.01).sqrt();
    let thickness = pchip(
        &[
            (0.10, 0.95),
            (0.24, 0.75),
            (0.45, 0.20),
            (0.70, 0.12),
            (1.22, 0.075),
        ],
        radius,
    );
    let section = Airfoil {
        camber: 0.03,
        camber_at: 0.4,
        thickness,
    };
    let pitch = libm::atan2(2.3, TAU * radius.max(0.28));
    let (s, c) = (libm::sin(pitch), libm::cos(pitch));
    section
        .outline(12)
        .iter()
        .rev()
        .map(|&(x, y)| {
            // Leading edge ahead in the sense of rotation (+x at the top,
            // seen from behind clockwise) and towards -z.
            let (along, up) = ((0.40 - x) * chord, y * chord);
            let p = vec3(along * c - up * s, radius, -along * s - up * c);
            p.rotated_z(turn)
        })
        .collect()
}
