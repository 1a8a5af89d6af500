//! Tailplane and fin.

use super::atlas;
use super::shape::{FIN_SPAN, TAIL_SEMI_SPAN, fin_chord, tailplane_chord};
use super::surface::{Rib, crowded, skin};
use crate::airfoil::Airfoil;
use crate::curve::mix;
use crate::mesh::Mesh;
use crate::vec3::vec3;

/// Height of the tailplane.
const TAILPLANE_Y: f64 = 0.42;

/// Adds the tailplane and the fin, both symmetric sections.
pub(super) fn add(mesh: &mut Mesh) {
    mesh.begin("tailplane", "livery");
    let section = |thickness: f64| Airfoil {
        camber: 0.0,
        camber_at: 0.4,
        thickness,
    };
    let ribs: Vec<Rib> = crowded(48)
        .iter()
        .map(|&place| {
            let x = -place * (TAIL_SEMI_SPAN - 0.002);
            let chord = tailplane_chord(x);
            Rib {
                front: vec3(x, TAILPLANE_Y, chord.front),
                chord: chord.length,
                twist: 0.0,
                airfoil: section(0.10),
            }
        })
        .collect();
    skin(mesh, &ribs, vec3(0.0, 1.0, 0.0), 16, &|p, upper| {
        let island = if upper {
            atlas::TAIL_UPPER
        } else {
            atlas::TAIL_LOWER
        };
        island.uv(p.x, p.z)
    });

    mesh.begin("fin", "livery");
    let ribs: Vec<Rib> = crowded(44)
        .iter()
        .map(|&place| {
            let y = mix(FIN_SPAN.0, FIN_SPAN.1 - 0.002, 0.5 * (place + 1.0));
            let chord = fin_chord(y);
            // The long dorsal foot must not grow fat with its chord.
            let thickness = 0.22 / chord.length.max(2.2);
            Rib {
                front: vec3(0.0, y, chord.front),
                chord: chord.length,
                twist: 0.0,
                airfoil: section(thickness),
            }
        })
        .collect();
    skin(mesh, &ribs, vec3(1.0, 0.0, 0.0), 18, &|p, right| {
        let island = if right {
            atlas::FIN_RIGHT
        } else {
            atlas::FIN_LEFT
        };
        island.uv(p.z, p.y)
    });
}
