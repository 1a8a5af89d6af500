//! Water.

use super::tagged::tagged_enum;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the surface moves.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Water {
    /// Waves by Tessendorf's spectral method (2001).
    Tessendorf(TessendorfWater),
}

tagged_enum!(Water { "tessendorf" => Tessendorf });

/// A plane to the horizon whose normals come from a periodic height field:
/// Phillips spectrum with upwind damping and a small-wave cut-off.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TessendorfWater {
    /// Height of the mean surface in metres.
    #[serde(default)]
    #[schemars(range(min = -1e9, max = 1e9))]
    pub height_m: f64,
    /// Grid points along each side of the height field: 16 to 2048, a power of two.
    #[serde(default = "default_grid")]
    #[schemars(extend("enum" = [16, 32, 64, 128, 256, 512, 1024, 2048]))]
    pub grid: u32,
    /// Side of the periodic tile in metres.
    #[schemars(range(min = 0.01, max = 1e6))]
    pub tile_m: f64,
    /// Wind speed in metres per second.
    #[schemars(range(min = 0.1, max = 200.0))]
    pub wind_speed_mps: f64,
    /// Where the wind blows to, degrees clockwise from -z.
    #[serde(default)]
    #[schemars(range(min = -1e6, max = 1e6))]
    pub wind_direction_deg: f64,
    /// Phillips constant A (dimensionless); the open sea has about 0.0081 / 2.
    #[serde(default = "default_amplitude")]
    #[schemars(range(min = 0.0, max = 10.0))]
    pub amplitude: f64,
    /// Waves shorter than this many metres fade out; 0 keeps all that the grid holds.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1e9))]
    pub cutoff_m: f64,
    /// Seed of the random phases.
    #[serde(default)]
    pub seed: u64,
    /// Reflectance of the water body under the surface, linear RGB.
    #[serde(default = "default_body")]
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub body_color: [f32; 3],
    /// Index of refraction.
    #[serde(default = "default_ior")]
    #[schemars(range(min = 1.0, max = 4.0))]
    pub ior: f32,
    /// Perceptual roughness of ripples below the grid's resolution.
    #[serde(default = "default_roughness")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub roughness: f32,
    /// Drift of the water against the scene in metres per second, along x and z:
    /// what blurs it while camera and planes stand still.
    #[serde(default)]
    #[schemars(inner(range(min = -1e5, max = 1e5)))]
    pub velocity_mps: [f64; 2],
    /// Time at which the height field is evaluated, in seconds.
    #[serde(default)]
    #[schemars(range(min = -1e6, max = 1e6))]
    pub time_s: f64,
}

const fn default_grid() -> u32 {
    256
}
const fn default_amplitude() -> f64 {
    0.004
}
const fn default_body() -> [f32; 3] {
    [0.01, 0.03, 0.04]
}
const fn default_ior() -> f32 {
    1.333
}
const fn default_roughness() -> f32 {
    0.15
}
