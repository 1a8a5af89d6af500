//! The suspension bridge, in the proportions of the Golden Gate.

mod cables;
mod deck;
mod ends;
mod fittings;
pub mod layout;
mod members;
mod tower;

use crate::mesh::Mesh;
use crate::obj::Material;

/// The whole bridge.
#[must_use]
pub fn mesh() -> Mesh {
    let mut mesh = Mesh::default();
    tower::add(&mut mesh, -layout::TOWER_X, "west");
    tower::add(&mut mesh, layout::TOWER_X, "east");
    cables::add(&mut mesh);
    deck::add(&mut mesh);
    fittings::add(&mut mesh);
    ends::add(&mut mesh);
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

/// Materials of `bridge.mtl`; the paint is international orange, linear.
pub const MATERIALS: [Material; 4] = [
    plain("paint", [0.56, 0.062, 0.025], 0.04, 40.0),
    plain("concrete", [0.36, 0.33, 0.29], 0.02, 10.0),
    plain("asphalt", [0.06, 0.06, 0.06], 0.03, 20.0),
    plain("lamp", [0.85, 0.70, 0.45], 0.1, 100.0),
];
