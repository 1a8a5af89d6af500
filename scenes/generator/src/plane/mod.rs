//! The twin-engined plane: `plane.obj` without propellers, `propeller.obj`
//! about its own axis.

pub mod atlas;
mod details;
mod engine;
mod fuselage;
mod nacelle;
mod propeller;
pub mod shape;
mod surface;
mod tail;
mod wing;

use crate::mesh::Mesh;
use crate::obj::Material;

pub use propeller::mesh as propeller_mesh;

/// The plane without its propellers.
#[must_use]
pub fn mesh() -> Mesh {
    let mut mesh = Mesh::default();
    fuselage::add(&mut mesh);
    wing::add(&mut mesh);
    tail::add(&mut mesh);
    nacelle::add(&mut mesh);
    details::add(&mut mesh);
    mesh
}

const fn plain(name: &'static str, diffuse: [f64; 3], specular: f64, exponent: f64) -> Material {
    Material {
        name,
        diffuse,
        specular: [specular; 3],
        exponent,
        texture: None,
    }
}

/// Materials of `plane.mtl`.
pub const MATERIALS: [Material; 10] = [
    Material {
        name: "livery",
        diffuse: [1.0; 3],
        specular: [0.25; 3],
        exponent: 200.0,
        texture: Some("livery.png"),
    },
    plain("glass", [0.02, 0.025, 0.03], 0.9, 900.0),
    plain("frame", [0.55, 0.55, 0.54], 0.5, 150.0),
    plain("engine", [0.05, 0.05, 0.05], 0.2, 30.0),
    plain("metal", [0.40, 0.40, 0.41], 0.5, 120.0),
    plain("exhaust", [0.16, 0.10, 0.07], 0.2, 20.0),
    plain("tyre", [0.03, 0.03, 0.03], 0.05, 10.0),
    plain("lamp-red", [0.7, 0.03, 0.02], 0.5, 200.0),
    plain("lamp-green", [0.02, 0.5, 0.12], 0.5, 200.0),
    plain("lamp-white", [0.8, 0.8, 0.75], 0.5, 200.0),
];

/// Materials of `propeller.mtl`.
pub const PROPELLER_MATERIALS: [Material; 3] = [
    plain("spinner", [0.75, 0.75, 0.76], 0.8, 300.0),
    plain("blade", [0.06, 0.06, 0.065], 0.3, 60.0),
    plain("blade-tip", [0.80, 0.45, 0.03], 0.2, 40.0),
];
