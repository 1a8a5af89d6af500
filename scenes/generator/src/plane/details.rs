//! Small things: exhausts, half-hidden wheels, aerials, pitot tubes, lamps.

use super::shape::{FUSELAGE, NOSE_Z, SEMI_SPAN, wing_height};
use crate::loft::{End, revolve, tube};
use crate::mesh::Mesh;
use crate::vec3::{Vec3, vec3};

/// Exhaust pipes and the wheel that the retracted leg leaves half outside.
pub(super) fn add_underside(mesh: &mut Mesh, origin: Vec3, side: &str) {
    mesh.begin(&format!("exhausts-{side}"), "exhaust");
    for x in [-0.40, 0.40] {
        let path = [
            origin + vec3(x * 0.9, -0.36, 0.80),
            origin + vec3(x * 1.05, -0.46, 1.05),
            origin + vec3(x * 1.08, -0.52, 1.35),
            origin + vec3(x * 1.08, -0.56, 1.62),
        ];
        tube(mesh, &path, 0.062, 14, End::Fan);
    }
    mesh.begin(&format!("wheel-{side}"), "tyre");
    let middle = origin + vec3(-0.13, -0.60, 2.05);
    let wheel = [
        (0.02, 0.0),
        (0.02, 0.16),
        (0.0, 0.19),
        (0.0, 0.30),
        (0.03, 0.345),
        (0.08, 0.37),
        (0.13, 0.38),
        (0.18, 0.37),
        (0.23, 0.345),
        (0.26, 0.30),
        (0.26, 0.19),
        (0.24, 0.16),
        (0.24, 0.0),
    ];
    revolve(mesh, middle, vec3(1.0, 0.0, 0.0), &wheel, 36);
}

/// Everything that is not on a nacelle.
pub(super) fn add(mesh: &mut Mesh) {
    let skin =
        |t: f64, degrees: f64| FUSELAGE.point(t, degrees.to_radians()) + vec3(0.0, 0.0, NOSE_Z);
    mesh.begin("aerials", "metal");
    // Mast behind the cockpit and the wires from it to the fin.
    let mast = skin(3.05, 90.0);
    let head = mast + vec3(0.0, 0.52, 0.14);
    tube(
        mesh,
        &[mast - vec3(0.0, 0.05, 0.0), head],
        0.022,
        10,
        End::Fan,
    );
    tube(mesh, &[head, vec3(0.0, 2.50, 6.75)], 0.006, 5, End::Open);
    // Pitot tubes below the nose.
    for angle in [-62.0, -118.0] {
        let foot = skin(0.95, angle);
        let low = foot + vec3(0.0, -0.16, -0.02);
        tube(
            mesh,
            &[foot + vec3(0.0, 0.04, 0.0), low],
            0.014,
            8,
            End::Open,
        );
        tube(
            mesh,
            &[low + vec3(0.0, 0.0, 0.03), low + vec3(0.0, 0.0, -0.24)],
            0.012,
            8,
            End::Fan,
        );
    }
    // Tail wheel fork.
    let fork = skin(10.9, -90.0);
    tube(
        mesh,
        &[fork + vec3(0.0, 0.1, -0.1), fork + vec3(0.0, -0.16, 0.06)],
        0.03,
        8,
        End::Fan,
    );
    mesh.begin("tail-wheel", "tyre");
    let hub = fork + vec3(-0.05, -0.17, 0.08);
    let wheel = [
        (0.0, 0.0),
        (0.0, 0.10),
        (0.02, 0.125),
        (0.08, 0.125),
        (0.10, 0.10),
        (0.10, 0.0),
    ];
    revolve(mesh, hub, vec3(1.0, 0.0, 0.0), &wheel, 20);
    // Teardrop of the direction finder, under the nose.
    mesh.begin("loop", "frame");
    let drop: Vec<(f64, f64)> = (0..=16)
        .map(|i| {
            let x = f64::from(i) / 16.0;
            (0.62 * x, 0.30 * x.sqrt() * (1.0 - x))
        })
        .collect();
    let drop: Vec<(f64, f64)> = drop
        .iter()
        .enumerate()
        .map(|(i, &(a, r))| (a, if i == 0 || i == 16 { 0.0 } else { r }))
        .collect();
    let belly = skin(2.3, -90.0) + vec3(0.0, -0.10, 0.0);
    revolve(mesh, belly, vec3(0.0, 0.0, 1.0), &drop, 20);
    tube(
        mesh,
        &[belly + vec3(0.0, 0.2, 0.24), belly + vec3(0.0, 0.0, 0.24)],
        0.03,
        8,
        End::Open,
    );
    lamps(mesh);
}

/// Position lamps: red left, green right, white at the tail.
fn lamps(mesh: &mut Mesh) {
    let x = SEMI_SPAN - 0.42;
    let y = wing_height(x) + 0.005;
    let places = [
        ("lamp-left", "lamp-red", vec3(-x, y, -0.235)),
        ("lamp-right", "lamp-green", vec3(x, y, -0.235)),
        ("lamp-tail", "lamp-white", vec3(0.0, 0.31, NOSE_Z + 12.17)),
    ];
    for (name, material, middle) in places {
        mesh.begin(name, material);
        let ball: Vec<(f64, f64)> = (0..=10)
            .map(|i| {
                let angle = std::f64::consts::PI * f64::from(i) / 10.0;
                let pole = i == 0 || i == 10;
                (
                    -0.085 * libm::cos(angle),
                    if pole { 0.0 } else { 0.045 * libm::sin(angle) },
                )
            })
            .collect();
        revolve(mesh, middle, vec3(0.0, 0.0, 1.0), &ball, 16);
    }
}
