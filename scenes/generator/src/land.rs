//! The headlands behind the bridge: two ridges that rise out of the sea, in
//! the scene's own coordinates.

use crate::curve::{mix, pchip, smoothstep};
use crate::mesh::Mesh;
use crate::noise::fbm;
use crate::obj::Material;
use crate::vec3::vec3;

/// A ridge seen from the camera's place on the water.
struct Ridge {
    name: &'static str,
    /// Distance of its near foot and of its far foot, metres.
    depth_m: (f64, f64),
    /// Crest height in metres against bearing in degrees (clockwise from -z).
    crest: &'static [(f64, f64)],
    /// Size of the hills, metres.
    hills_m: f64,
    seed: u32,
}

const RIDGES: [Ridge; 2] = [
    Ridge {
        name: "near",
        depth_m: (2300.0, 4600.0),
        crest: &[
            (11.0, -30.0),
            (15.0, 25.0),
            (19.0, 70.0),
            (24.0, 150.0),
            (29.0, 215.0),
            (35.0, 270.0),
            (46.0, 300.0),
            (58.0, 220.0),
        ],
        hills_m: 620.0,
        seed: 611,
    },
    Ridge {
        name: "far",
        depth_m: (6200.0, 9500.0),
        crest: &[
            (-60.0, 420.0),
            (-44.0, 360.0),
            (-33.0, 400.0),
            (-26.0, 300.0),
            (-20.0, 200.0),
            (-15.0, 90.0),
            (-11.5, -40.0),
        ],
        hills_m: 1500.0,
        seed: 733,
    },
];

/// Steps along the bearing and into the depth.
const GRID: (usize, usize) = (220, 22);

/// Both ridges.
#[must_use]
pub fn mesh() -> Mesh {
    let mut mesh = Mesh::default();
    for ridge in &RIDGES {
        mesh.begin(
            &format!("ridge-{}", ridge.name),
            &format!("land-{}", ridge.name),
        );
        let mut before: Vec<u32> = Vec::new();
        for row in 0..=GRID.1 {
            let depth = row as f64 / GRID.1 as f64;
            let now: Vec<u32> = (0..=GRID.0)
                .map(|column| {
                    let across = column as f64 / GRID.0 as f64;
                    mesh.vertex(point(ridge, across, depth))
                })
                .collect();
            for i in 1..before.len() {
                mesh.face(&[before[i - 1], before[i], now[i], now[i - 1]]);
            }
            before = now;
        }
    }
    mesh
}

fn point(ridge: &Ridge, across: f64, depth: f64) -> crate::vec3::Vec3 {
    let (first, last) = (ridge.crest[0].0, ridge.crest[ridge.crest.len() - 1].0);
    let bearing = mix(first, last, across);
    let distance = mix(ridge.depth_m.0, ridge.depth_m.1, depth);
    let angle = bearing.to_radians();
    let (x, z) = (distance * libm::sin(angle), -distance * libm::cos(angle));
    let crest = pchip(ridge.crest, bearing);
    // The foot lies under water; the crest in the middle of the depth.
    let profile = smoothstep(0.0, 0.55, depth) * (1.0 - 0.8 * smoothstep(0.6, 1.0, depth));
    let (u, v) = (x / ridge.hills_m, z / ridge.hills_m);
    let rough = fbm(u, v, 0.5, 5, 0.5, ridge.seed);
    let folds = 1.0 - fbm(u * 1.7, v * 1.7, 3.5, 4, 0.5, ridge.seed + 9).abs() * 2.0;
    let height = crest * profile * (0.72 + 0.30 * folds + 0.45 * rough);
    vec3(x, height - 14.0 * (1.0 - profile), z)
}

const fn plain(name: &'static str, diffuse: [f64; 3]) -> Material {
    Material {
        name,
        diffuse,
        specular: [0.0; 3],
        exponent: 1.0,
        texture: None,
    }
}

/// Materials of `headland.mtl`; the far one is pale for the air before it.
pub const MATERIALS: [Material; 2] = [
    plain("land-near", [0.115, 0.095, 0.095]),
    plain("land-far", [0.42, 0.31, 0.36]),
];
