//! Meshes and their placement.

use super::animation::{InstanceKey, Spin};
use super::tagged::unique_map;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A triangle mesh from a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Mesh {
    /// OBJ file, by name relative to scene.json.
    pub file: String,
    /// How shading normals are made where the file has none.
    #[serde(default)]
    pub normals: Normals,
    /// Faces that meet at less than this angle are smoothed together, degrees.
    #[serde(default = "default_crease")]
    #[schemars(range(min = 0.0, max = 180.0))]
    pub crease_angle_deg: f64,
    /// Material name in the OBJ to material of the scene. Names that are not
    /// listed take the scene's material of that name, then the MTL file's.
    #[serde(default, deserialize_with = "unique_map")]
    pub materials: BTreeMap<String, String>,
}

/// Where shading normals come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Normals {
    /// From the file; where it has none, smoothed up to the crease angle.
    #[default]
    Smooth,
    /// Always the triangle's own.
    Flat,
}

const fn default_crease() -> f64 {
    40.0
}

/// A placed mesh: scaled, then turned, then moved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Instance {
    /// Name of the mesh.
    pub mesh: String,
    /// Where its origin goes, in metres.
    #[serde(default)]
    #[schemars(inner(range(min = -1e9, max = 1e9)))]
    pub translate_m: [f64; 3],
    /// Angles about x, y and z in degrees; the rotation is Ry * Rx * Rz (yaw
    /// after pitch after roll).
    #[serde(default)]
    #[schemars(inner(range(min = -1e6, max = 1e6)))]
    pub rotate_deg: [f64; 3],
    /// Factor along each axis; may be negative (mirror), not zero.
    #[serde(default = "ones")]
    #[schemars(inner(range(min = -1e6, max = 1e6)))]
    pub scale: [f64; 3],
    /// A material of the scene for the whole instance instead of the mesh's.
    #[serde(default)]
    pub material: Option<String>,
    /// A name for children to refer to; no two instances share one.
    #[serde(default)]
    #[schemars(length(min = 1, max = 200))]
    pub name: Option<String>,
    /// Name of an instance in whose space (after its own scale, turns, spin and
    /// motion) this one is placed, instead of the world's.
    #[serde(default)]
    pub parent: Option<String>,
    /// Velocity in metres per second, in the space it is placed in: at time t it
    /// stands `velocity_mps * t` from `translate_m`.
    #[serde(default)]
    #[schemars(inner(range(min = -1e5, max = 1e5)))]
    pub velocity_mps: [f64; 3],
    /// A steady turn of the mesh, before scale and placement.
    #[serde(default)]
    pub spin: Option<Spin>,
    /// Keys in the order of their times; smooth between them, still before the
    /// first and after the last.
    #[serde(default)]
    #[schemars(length(max = 10_000))]
    pub path: Vec<InstanceKey>,
}

const fn ones() -> [f64; 3] {
    [1.0; 3]
}
