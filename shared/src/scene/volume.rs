//! Clouds as volumes: a density that scatters light everywhere inside a shape.

use super::tagged::tagged_enum;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A cloud as a participating medium. Light that meets it is absorbed or scattered,
/// any number of times; things inside and behind stay visible as far as it is thin.
/// Volumes may overlap: their densities act together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VolumeCloud {
    /// Where it is and how dense.
    pub shape: VolumeShape,
    /// Extinction where the density is 1, per metre: light goes 1 / `sigma_t_per_m`
    /// on average before it meets something.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub sigma_t_per_m: f64,
    /// Share of what it meets that is scattered rather than absorbed, linear RGB.
    #[serde(default = "white")]
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub albedo: [f32; 3],
    /// Mean cosine of scattering (Henyey-Greenstein): 0 evenly, towards 1 forwards,
    /// towards -1 backwards.
    #[serde(default)]
    #[schemars(range(min = -0.99, max = 0.99))]
    pub g: f32,
    /// How light finds its way through.
    #[serde(default)]
    pub method: VolumeMethod,
}

/// Where a volume is and how dense.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum VolumeShape {
    /// An ellipsoid, even or of noise.
    Ellipsoid(EllipsoidVolume),
    /// A box whose density comes from a file.
    Grid(GridVolume),
}

tagged_enum!(VolumeShape { "ellipsoid" => Ellipsoid, "grid" => Grid });

/// An ellipsoid. Without `edge` and `noise` its density is exactly 1 inside; else
/// the density is computed once on a grid of `resolution` and interpolated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EllipsoidVolume {
    /// Centre in metres.
    #[schemars(inner(range(min = -1e9, max = 1e9)))]
    pub centre_m: [f64; 3],
    /// Semi-axes in metres.
    #[schemars(inner(range(min = 1e-10, max = 1e9)))]
    pub radii_m: [f64; 3],
    /// Share of the radius over which the density falls from 1 to 0 at the rim, 0
    /// to 1.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub edge: f64,
    /// What eats into it; none: even.
    #[serde(default)]
    pub noise: Option<VolumeNoise>,
    /// Voxels along the longest axis.
    #[serde(default = "default_resolution")]
    #[schemars(range(min = 4, max = 256))]
    pub resolution: u32,
}

/// Fractal noise (fBm: octaves of gradient noise) that eats into a shape.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VolumeNoise {
    /// Size of the largest lumps in metres.
    #[schemars(range(min = 1e-10, max = 1e9))]
    pub scale_m: f64,
    /// How deep it eats: 0 not at all, 1 to the core.
    #[serde(default = "default_amplitude")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub amplitude: f64,
    /// How much is left: 0 little, 0.5 as the noise falls, 1 nearly all.
    #[serde(default = "default_coverage")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub coverage: f64,
    /// Layers of ever finer noise.
    #[serde(default = "default_octaves")]
    #[schemars(range(min = 1, max = 10))]
    pub octaves: u32,
    /// Factor on fineness from one octave to the next.
    #[serde(default = "default_lacunarity")]
    #[schemars(range(min = 1.0, max = 4.0))]
    pub lacunarity: f64,
    /// Factor on strength from one octave to the next.
    #[serde(default = "default_gain")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub gain: f64,
    /// Seed of the noise.
    #[serde(default)]
    pub seed: u64,
}

/// A box filled from a file of voxels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GridVolume {
    /// `.vol` file (version 3, float32, one channel), relative to scene.json. Its own
    /// bounding box is not used.
    pub file: String,
    /// Centre of the box in metres.
    #[schemars(inner(range(min = -1e9, max = 1e9)))]
    pub centre_m: [f64; 3],
    /// Edges of the box in metres.
    #[schemars(inner(range(min = 1e-10, max = 1e9)))]
    pub size_m: [f64; 3],
    /// Turn about the vertical through its centre, in degrees; 90 takes +z to +x.
    #[serde(default)]
    #[schemars(range(min = -1e6, max = 1e6))]
    pub rotate_y_deg: f64,
}

/// How light finds its way through a volume.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum VolumeMethod {
    /// Delta and ratio tracking: unbiased.
    Tracking(Tracking),
    /// Fixed steps: biased, for comparison.
    March(March),
}

tagged_enum!(VolumeMethod { "tracking" => Tracking, "march" => March });

impl Default for VolumeMethod {
    fn default() -> Self {
        Self::Tracking(Tracking {})
    }
}

/// Delta tracking for scattering, ratio tracking for shadows; nothing to set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tracking {}

/// Jittered steps of one length.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct March {
    /// Length of a step in metres; at most 100000 steps may fit into the volume.
    #[schemars(range(min = 1e-10, max = 1e9))]
    pub step_m: f64,
}

const fn white() -> [f32; 3] {
    [1.0; 3]
}

const fn default_resolution() -> u32 {
    128
}

const fn default_amplitude() -> f64 {
    0.8
}

const fn default_coverage() -> f64 {
    0.5
}

const fn default_octaves() -> u32 {
    5
}

const fn default_lacunarity() -> f64 {
    2.0
}

const fn default_gain() -> f64 {
    0.5
}

impl VolumeShape {
    /// The longest straight line inside, in metres.
    #[must_use]
    pub fn longest_m(&self) -> f64 {
        match self {
            Self::Ellipsoid(shape) => 2.0 * shape.radii_m.into_iter().fold(0.0, f64::max),
            Self::Grid(shape) => shape.size_m.map(|s| s * s).iter().sum::<f64>().sqrt(),
        }
    }
}
