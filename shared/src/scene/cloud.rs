//! Clouds.

use super::tagged::tagged_enum;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A cloud, by one of several methods.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Cloud {
    /// Semi-opaque ellipsoids.
    Particles(ParticleCloud),
}

tagged_enum!(Cloud { "particles" => Particles });

/// A formation of semi-opaque ellipsoids.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParticleCloud {
    /// Where the particles are.
    pub formation: Formation,
    /// Number of particles.
    #[schemars(range(min = 1, max = 5_000_000))]
    pub count: u32,
    /// Smallest and largest particle radius in metres.
    #[schemars(inner(range(min = 1e-10, max = 1e9)))]
    pub particle_radius_m: [f64; 2],
    /// Smallest and largest factor on a particle's x radius.
    #[serde(default = "ones")]
    #[schemars(inner(range(min = 0.001, max = 1000.0)))]
    pub stretch_x: [f64; 2],
    /// Smallest and largest opacity of one crossing of a particle's boundary, 0 to 1.
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub opacity: [f32; 2],
    /// Share of light a particle reflects, linear RGB.
    #[serde(default = "white")]
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub albedo: [f32; 3],
    /// Seed of the formation.
    #[serde(default)]
    pub seed: u64,
}

/// Where the particles of a cloud are.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Formation {
    /// Around a core and spread out from it.
    Radial(RadialFormation),
}

tagged_enum!(Formation { "radial" => Radial });

/// The student report's radial formation, corrected: particles fill the
/// ellipsoid `radii_m` about `centre_m` uniformly, and each is pushed by
/// `length_m * u^0.7` along the formation's direction with its two other
/// components jittered by +-0.4, so that density falls with distance. Opacity
/// falls with that distance too, from the larger to the smaller bound.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RadialFormation {
    /// Origin of the formation in metres.
    #[schemars(inner(range(min = -1e9, max = 1e9)))]
    pub centre_m: [f64; 3],
    /// Semi-axes of the core ellipsoid in metres.
    #[schemars(inner(range(min = 1e-10, max = 1e9)))]
    pub radii_m: [f64; 3],
    /// Where the formation spreads to; any length but 0.
    pub direction: [f64; 3],
    /// How far it spreads, in metres.
    #[schemars(range(min = 0.0, max = 1e9))]
    pub length_m: f64,
}

const fn ones() -> [f64; 2] {
    [1.0; 2]
}

const fn white() -> [f32; 3] {
    [0.95; 3]
}
