//! The wing, from tip to tip in one closed skin.

use super::atlas;
use super::shape::{SEMI_SPAN, wing_chord, wing_height};
use super::surface::{Rib, crowded, skin};
use crate::airfoil::Airfoil;
use crate::curve::mix;
use crate::mesh::Mesh;
use crate::vec3::vec3;

/// Adds the wing: NACA 2417 at the root to 2412 at the tip, two degrees of
/// incidence washed out to none.
pub(super) fn add(mesh: &mut Mesh) {
    mesh.begin("wing", "livery");
    let ribs: Vec<Rib> = crowded(100)
        .iter()
        .map(|&place| {
            // The last rib stands a hair before the tip, where the chord is 0.
            let x = -place * (SEMI_SPAN - 0.004);
            let chord = wing_chord(x);
            let out = x.abs() / SEMI_SPAN;
            let near = (x.abs() - 0.72) / 0.34;
            let fillet = libm::exp(-near * near);
            Rib {
                front: vec3(x, wing_height(x), chord.front),
                chord: chord.length,
                twist: mix(0.035, 0.0, out),
                airfoil: Airfoil {
                    camber: 0.02,
                    camber_at: 0.4,
                    thickness: mix(0.17, 0.12, out) * (1.0 + 0.30 * fillet),
                },
            }
        })
        .collect();
    skin(mesh, &ribs, vec3(0.0, 1.0, 0.0), 24, &|p, upper| {
        let island = if upper {
            atlas::WING_UPPER
        } else {
            atlas::WING_LOWER
        };
        island.uv(p.x, p.z)
    });
}
