//! Nacelles: the body under and over the wing, and the cowling ring.

use super::atlas;
use super::shape::{COWL_Z, ENGINE_X, ENGINE_Y, NACELLE, NACELLE_LENGTH, angle_of_turn};
use super::{details, engine};
use crate::loft::loft_uv;
use crate::mesh::Mesh;
use crate::vec3::{Vec3, vec3};

/// Points around body and cowling.
const AROUND: usize = 48;

/// Profile of the cowling: (station, radius) from inside the duct over the
/// lip and back over the outer skin to the open gills.
const COWL: [(f64, f64); 21] = [
    (0.42, 0.485),
    (0.30, 0.485),
    (0.18, 0.487),
    (0.10, 0.493),
    (0.05, 0.503),
    (0.02, 0.515),
    (0.003, 0.531),
    (0.0, 0.545),
    (0.006, 0.561),
    (0.025, 0.579),
    (0.06, 0.598),
    (0.12, 0.617),
    (0.20, 0.632),
    (0.32, 0.644),
    (0.46, 0.650),
    (0.62, 0.648),
    (0.78, 0.640),
    (0.90, 0.640),
    (0.965, 0.652),
    (0.962, 0.642),
    (0.86, 0.600),
];

/// Adds both nacelles with engines, exhausts and wheels.
pub(super) fn add(mesh: &mut Mesh) {
    for (side, x) in [("left", -ENGINE_X), ("right", ENGINE_X)] {
        let origin = vec3(x, ENGINE_Y, COWL_Z);
        mesh.begin(&format!("nacelle-{side}"), "livery");
        body(mesh, origin);
        mesh.begin(&format!("cowl-{side}"), "livery");
        cowl(mesh, origin);
        engine::add(mesh, origin, side);
        details::add_underside(mesh, origin, side);
    }
}

fn body(mesh: &mut Mesh, origin: Vec3) {
    let mut stations: Vec<f64> = (0..44)
        .map(|i| 0.72 + (NACELLE_LENGTH - 0.9) * f64::from(i) / 47.0)
        .collect();
    let from = stations.last().copied().unwrap_or(0.72);
    stations.extend((1..=12).map(|i| {
        from + (NACELLE_LENGTH - from) * libm::sin(0.5 * std::f64::consts::PI * f64::from(i) / 12.0)
    }));
    let rings: Vec<Vec<Vec3>> = stations
        .iter()
        .enumerate()
        .map(|(i, &t)| {
            (0..AROUND)
                .map(|j| {
                    let p = NACELLE.point(t, angle_of_turn(j as f64 / AROUND as f64));
                    let pole = i == 0 || i + 1 == stations.len();
                    let y = if i == 0 { 0.0 } else { NACELLE.point(t, 0.0).y };
                    origin + if pole { vec3(0.0, y, t) } else { p }
                })
                .collect()
        })
        .collect();
    loft_uv(mesh, &rings, &|i, j| {
        atlas::NACELLE.uv(stations[i], j as f64 / AROUND as f64)
    });
}

fn cowl(mesh: &mut Mesh, origin: Vec3) {
    let rings: Vec<Vec<Vec3>> = COWL
        .iter()
        .map(|&(t, radius)| {
            (0..AROUND)
                .map(|j| {
                    let angle = angle_of_turn(j as f64 / AROUND as f64);
                    origin + vec3(radius * libm::cos(angle), radius * libm::sin(angle), t)
                })
                .collect()
        })
        .collect();
    loft_uv(mesh, &rings, &|i, j| {
        atlas::NACELLE.uv(COWL[i].0, j as f64 / AROUND as f64)
    });
}
