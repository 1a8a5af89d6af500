//! A nine-cylinder radial engine, seen through the cowling's mouth.

use crate::loft::revolve;
use crate::mesh::Mesh;
use crate::vec3::{Vec3, vec3};
use std::f64::consts::TAU;

/// Cylinders of the star.
const CYLINDERS: usize = 9;
/// Cooling fins per cylinder.
const FINS: usize = 6;

/// Adds the engine behind the cowling's lip at `origin`.
pub(super) fn add(mesh: &mut Mesh, origin: Vec3, side: &str) {
    let aft = vec3(0.0, 0.0, 1.0);
    mesh.begin(&format!("baffle-{side}"), "engine");
    revolve(mesh, origin, aft, &[(0.40, 0.0), (0.40, 0.50)], 40);
    mesh.begin(&format!("crankcase-{side}"), "metal");
    let case = [
        (-0.26, 0.0),
        (-0.26, 0.05),
        (-0.10, 0.055),
        (-0.09, 0.09),
        (-0.05, 0.125),
        (0.02, 0.15),
        (0.07, 0.155),
        (0.09, 0.19),
        (0.36, 0.19),
    ];
    revolve(mesh, origin, aft, &case, 28);
    mesh.begin(&format!("cylinders-{side}"), "engine");
    for i in 0..CYLINDERS {
        let angle = TAU * (i as f64 + 0.25) / CYLINDERS as f64;
        let out = vec3(libm::cos(angle), libm::sin(angle), 0.0);
        revolve(mesh, origin + vec3(0.0, 0.0, 0.22), out, &cylinder(), 11);
        // Push rod and ignition lead in front of the barrel.
        let rod = [(0.12, 0.0), (0.12, 0.012), (0.44, 0.012), (0.44, 0.0)];
        let lean = vec3(0.10 * libm::sin(angle), -0.10 * libm::cos(angle), 0.0);
        revolve(
            mesh,
            origin + vec3(0.0, 0.0, 0.11),
            (out + lean).normalized(),
            &rod,
            6,
        );
        revolve(
            mesh,
            origin + vec3(0.0, 0.0, 0.11),
            (out - lean).normalized(),
            &rod,
            6,
        );
    }
}

/// Barrel with fins and a domed head: (distance from the crank, radius).
fn cylinder() -> Vec<(f64, f64)> {
    let mut profile = vec![(0.15, 0.0), (0.15, 0.075)];
    for fin in 0..FINS {
        let at = 0.20 + 0.035 * fin as f64;
        profile.extend([
            (at, 0.075),
            (at + 0.006, 0.098),
            (at + 0.014, 0.098),
            (at + 0.02, 0.075),
        ]);
    }
    profile.extend([(0.42, 0.10), (0.455, 0.095), (0.47, 0.06), (0.475, 0.0)]);
    profile
}
