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
    /// A list of waves by hand, summed.
    Gerstner(GerstnerWater),
    /// Still, with a picture on it.
    Flat(FlatWater),
}

tagged_enum!(Water { "tessendorf" => Tessendorf, "gerstner" => Gerstner, "flat" => Flat });

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
    /// Seconds after which every wave is back where it was; without it none ever is.
    /// Frequencies are rounded to whole turns in this time.
    #[serde(default)]
    #[schemars(range(min = 1e-3, max = 1e6))]
    pub loop_s: Option<f64>,
    /// Times within the shutter at which the height field is evaluated, 1 to 4;
    /// slopes change linearly between them. With 1 the waves stand still while the
    /// shutter is open, but drift.
    #[serde(default = "default_shutter_fields")]
    #[schemars(range(min = 1, max = 4))]
    pub shutter_fields: u32,
    /// Foam where crests fold; without it there is none.
    #[serde(default)]
    pub whitecaps: Option<Whitecaps>,
}

/// Foam where the surface folds: where choppy waves, which move water towards the
/// crests, would squeeze it to less than a share of its area (Tessendorf 2001, section
/// 4.6). The share J is 1 on flat water and below 0 where a crest turns over.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Whitecaps {
    /// How far water moves towards the crests, times what it does in small waves.
    #[serde(default = "one")]
    #[schemars(range(min = 0.0, max = 100.0))]
    pub choppiness: f64,
    /// Where J is less, foam begins.
    #[serde(default = "default_threshold")]
    #[schemars(range(min = -100.0, max = 100.0))]
    pub threshold: f64,
    /// Where J is less than the threshold by this, all is foam.
    #[serde(default = "default_softness")]
    #[schemars(range(min = 1e-3, max = 100.0))]
    pub softness: f64,
    /// Reflectance of foam, linear RGB.
    #[serde(default = "default_foam")]
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub albedo: [f32; 3],
    /// Perceptual roughness of foam.
    #[serde(default = "default_foam_roughness")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub roughness: f32,
}

/// A plane to the horizon whose normals come from a sum of waves in deep water,
/// evaluated exactly at every point and time (Fournier and Reeves 1986).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GerstnerWater {
    /// The waves, 1 to 64.
    #[schemars(length(min = 1, max = 64))]
    pub waves: Vec<GerstnerWave>,
    /// Shape of the waves.
    #[serde(default)]
    pub profile: Profile,
    /// Height of the mean surface in metres.
    #[serde(default)]
    #[schemars(range(min = -1e9, max = 1e9))]
    pub height_m: f64,
    /// Reflectance of the water body under the surface, linear RGB.
    #[serde(default = "default_body")]
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub body_color: [f32; 3],
    /// Index of refraction.
    #[serde(default = "default_ior")]
    #[schemars(range(min = 1.0, max = 4.0))]
    pub ior: f32,
    /// Perceptual roughness of ripples.
    #[serde(default = "default_roughness")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub roughness: f32,
    /// Drift of the water against the scene in metres per second, along x and z.
    #[serde(default)]
    #[schemars(inner(range(min = -1e5, max = 1e5)))]
    pub velocity_mps: [f64; 2],
    /// Time of the waves at time 0 of the scene, in seconds.
    #[serde(default)]
    #[schemars(range(min = -1e6, max = 1e6))]
    pub time_s: f64,
    /// Seconds after which every wave is back where it was; frequencies are rounded
    /// to whole turns in this time.
    #[serde(default)]
    #[schemars(range(min = 1e-3, max = 1e6))]
    pub loop_s: Option<f64>,
}

/// One wave: height A sin(k.x - w t + phase) with w^2 = g k.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GerstnerWave {
    /// Half of the height from trough to crest, in metres.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub amplitude_m: f64,
    /// From crest to crest, in metres.
    #[schemars(range(min = 0.01, max = 1e6))]
    pub wavelength_m: f64,
    /// Where it runs to, degrees clockwise from -z.
    #[serde(default)]
    #[schemars(range(min = -1e6, max = 1e6))]
    pub direction_deg: f64,
    /// Its phase at the scene's origin at time 0, in degrees.
    #[serde(default)]
    #[schemars(range(min = -1e6, max = 1e6))]
    pub phase_deg: f64,
}

/// Shape of the waves of a Gerstner sea.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Profile {
    /// Water moves in circles: sharp crests, wide troughs. The sum of 2 pi A /
    /// wavelength may not exceed 1, or crests would loop.
    #[default]
    Trochoid,
    /// Plain sines: water moves up and down.
    Sine,
}

/// A still plane to the horizon, with a picture on it if there is one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FlatWater {
    /// PNG, JPEG or EXR that multiplies the colour of the body; repeated.
    #[serde(default)]
    pub texture: Option<String>,
    /// Side of one repetition of the texture in metres; its right is +x, its top -z.
    #[serde(default = "default_texture_size")]
    #[schemars(range(min = 0.01, max = 1e6))]
    pub texture_size_m: f64,
    /// Height of the surface in metres.
    #[serde(default)]
    #[schemars(range(min = -1e9, max = 1e9))]
    pub height_m: f64,
    /// Reflectance of the water body under the surface, linear RGB.
    #[serde(default = "default_body")]
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub body_color: [f32; 3],
    /// Index of refraction.
    #[serde(default = "default_ior")]
    #[schemars(range(min = 1.0, max = 4.0))]
    pub ior: f32,
    /// Perceptual roughness; 0 is a mirror.
    #[serde(default = "default_flat_roughness")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub roughness: f32,
    /// Drift of the texture against the scene in metres per second, along x and z.
    #[serde(default)]
    #[schemars(inner(range(min = -1e5, max = 1e5)))]
    pub velocity_mps: [f64; 2],
}

/// What every kind of water has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WaterLook {
    /// Height of the mean surface in metres.
    pub height_m: f64,
    /// Drift along x and z in metres per second.
    pub velocity_mps: [f64; 2],
    /// Reflectance of the water body under the surface, linear RGB.
    pub body_color: [f32; 3],
    /// Index of refraction.
    pub ior: f32,
    /// Perceptual roughness of what no wave shows.
    pub roughness: f32,
}

impl Water {
    /// What every kind of water has.
    #[must_use]
    pub fn look(&self) -> WaterLook {
        macro_rules! look {
            ($water:expr) => {
                WaterLook {
                    height_m: $water.height_m,
                    velocity_mps: $water.velocity_mps,
                    body_color: $water.body_color,
                    ior: $water.ior,
                    roughness: $water.roughness,
                }
            };
        }
        match self {
            Self::Tessendorf(water) => look!(water),
            Self::Gerstner(water) => look!(water),
            Self::Flat(water) => look!(water),
        }
    }

    /// Name of the file of its texture, if it has one.
    #[must_use]
    pub fn texture(&self) -> Option<&str> {
        match self {
            Self::Flat(water) => water.texture.as_deref(),
            Self::Tessendorf(_) | Self::Gerstner(_) => None,
        }
    }
}

const fn default_grid() -> u32 {
    256
}
const fn default_texture_size() -> f64 {
    10.0
}
const fn default_flat_roughness() -> f32 {
    0.02
}
const fn one() -> f64 {
    1.0
}
const fn default_threshold() -> f64 {
    0.5
}
const fn default_softness() -> f64 {
    0.3
}
const fn default_foam() -> [f32; 3] {
    [0.8, 0.8, 0.8]
}
const fn default_foam_roughness() -> f32 {
    0.8
}
const fn default_shutter_fields() -> u32 {
    1
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
