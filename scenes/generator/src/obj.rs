//! Writes a mesh as OBJ text: few decimals, relative indices (short, because
//! every vertex stands just before its first use), quadrilaterals kept.

use crate::mesh::{Corner, Mesh, NO_UV};
use std::fmt::Write as _;

/// A material of the MTL file beside the OBJ.
pub struct Material {
    /// Name as in the mesh's parts.
    pub name: &'static str,
    /// Diffuse colour, linear, in [0, 1].
    pub diffuse: [f64; 3],
    /// Specular colour, linear, in [0, 1].
    pub specular: [f64; 3],
    /// Phong exponent.
    pub exponent: f64,
    /// Texture beside the MTL file.
    pub texture: Option<&'static str>,
}

/// The MTL text of the materials.
#[must_use]
pub fn mtl_text(title: &str, materials: &[Material]) -> String {
    let mut out = format!("# {title}\n");
    for m in materials {
        let [r, g, b] = m.diffuse.map(|v| number(v, 4));
        let [sr, sg, sb] = m.specular.map(|v| number(v, 4));
        let _ = write!(
            out,
            "\nnewmtl {}\nKd {r} {g} {b}\nKs {sr} {sg} {sb}\nNs {}\n",
            m.name,
            number(m.exponent, 2)
        );
        if let Some(texture) = m.texture {
            let _ = writeln!(out, "map_Kd {texture}");
        }
    }
    out
}

/// The OBJ text of the mesh with positions rounded to `decimals` places.
#[must_use]
pub fn obj_text(title: &str, mtl: &str, mesh: &Mesh, decimals: usize) -> String {
    let mut out = format!("# {title}\n# Metres, y up. Relative indices.\nmtllib {mtl}\n");
    let mut written = Written {
        position: vec![0; mesh.positions.len()],
        uv: vec![0; mesh.uvs.len()],
        positions: 0,
        uvs: 0,
    };
    let mut material = "";
    for part in &mesh.parts {
        let _ = writeln!(out, "o {}", part.name);
        if part.material != material {
            let _ = writeln!(out, "usemtl {}", part.material);
            material = &part.material;
        }
        for face in &part.faces {
            for &corner in face.corners() {
                written.define(&mut out, mesh, corner, decimals);
            }
            out.push('f');
            for &corner in face.corners() {
                let back = written.positions + 1 - written.position[corner.position as usize];
                let _ = write!(out, " -{back}");
                if corner.uv != NO_UV {
                    let _ = write!(
                        out,
                        "/-{}",
                        written.uvs + 1 - written.uv[corner.uv as usize]
                    );
                }
            }
            out.push('\n');
        }
    }
    out
}

/// Which vertices the file holds so far, and as the how-manyth (from 1).
struct Written {
    position: Vec<usize>,
    uv: Vec<usize>,
    positions: usize,
    uvs: usize,
}

impl Written {
    fn define(&mut self, out: &mut String, mesh: &Mesh, corner: Corner, decimals: usize) {
        let place = &mut self.position[corner.position as usize];
        if *place == 0 {
            self.positions += 1;
            *place = self.positions;
            let p = mesh.positions[corner.position as usize];
            let [x, y, z] = [p.x, p.y, p.z].map(|v| number(v, decimals));
            let _ = writeln!(out, "v {x} {y} {z}");
        }
        if corner.uv != NO_UV && self.uv[corner.uv as usize] == 0 {
            self.uvs += 1;
            self.uv[corner.uv as usize] = self.uvs;
            // A texel of a 2048 texture is 0.0005 wide.
            let [u, v] = mesh.uvs[corner.uv as usize].map(|v| number(v, 5));
            let _ = writeln!(out, "vt {u} {v}");
        }
    }
}

/// `value` with at most `decimals` places, no trailing zeros, no minus zero.
#[must_use]
pub fn number(value: f64, decimals: usize) -> String {
    let mut text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.truncate(text.trim_end_matches('0').trim_end_matches('.').len());
    }
    if text == "-0" { "0".to_owned() } else { text }
}
