//! Clouds.

use super::VolumeCloud;
use super::tagged::tagged_enum;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A cloud, by one of several methods.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Cloud {
    /// Semi-opaque ellipsoids.
    Particles(ParticleCloud),
    /// Soft discs that face the camera.
    Sprites(SpriteCloud),
    /// A density that scatters light.
    Volume(VolumeCloud),
}

tagged_enum!(Cloud { "particles" => Particles, "sprites" => Sprites, "volume" => Volume });

impl Cloud {
    /// Where the parts of the cloud are, if it has parts.
    #[must_use]
    pub fn formation(&self) -> Option<&Formation> {
        match self {
            Self::Particles(cloud) => Some(&cloud.formation),
            Self::Sprites(cloud) => Some(&cloud.formation),
            Self::Volume(_) => None,
        }
    }
}

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

/// A formation of soft discs, each turned to the camera's position when the
/// shutter opens. With q = 1 - (r / R)^2, opacity at the distance r from the
/// middle of a disc of radius R is `opacity * min(q / softness, 1)^2`: it falls
/// to 0 at the rim without a step, and its mean over the disc is
/// `opacity * (1 - 2/3 softness)`. A ray crosses a disc once.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpriteCloud {
    /// Where the sprites are.
    pub formation: Formation,
    /// Number of sprites.
    #[schemars(range(min = 1, max = 5_000_000))]
    pub count: u32,
    /// Smallest and largest radius of a sprite in metres.
    #[schemars(inner(range(min = 1e-4, max = 1e9)))]
    pub sprite_radius_m: [f64; 2],
    /// Smallest and largest opacity in the middle of a sprite, 0 to 1.
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub opacity: [f32; 2],
    /// Share of a sprite's area over which its opacity falls, 0.01 (a disc with an
    /// edge) to 1 (soft from the middle on).
    #[serde(default = "soft")]
    #[schemars(range(min = 0.01, max = 1.0))]
    pub softness: f64,
    /// Share of the light that a sprite stops and scatters again, linear RGB.
    #[serde(default = "white")]
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub albedo: [f32; 3],
    /// Mean cosine of the scattering (Henyey-Greenstein), -0.99 to 0.99: 0 is even,
    /// above 0 goes on, below 0 comes back.
    #[serde(default)]
    #[schemars(range(min = -0.99, max = 0.99))]
    pub g: f64,
    /// Seed of the formation.
    #[serde(default)]
    pub seed: u64,
}

/// Where the particles or sprites of a cloud are.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Formation {
    /// Around a core and spread out from it.
    Radial(RadialFormation),
    /// As bright as a picture.
    Image(ImageFormation),
}

tagged_enum!(Formation { "radial" => Radial, "image" => Image });

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

/// A picture as the density of particles, seen from +z before it is turned: its
/// columns grow towards +x, its top row lies at +y. The chance of a pixel is in
/// proportion to its luminance (linear) times its alpha; within the pixel
/// particles are uniform. With b that product over the largest of the picture,
/// the cloud is `depth_m * sqrt(b)` thick there, opacity grows with b from the
/// smaller to the larger bound, and radii with `0.7 b + 0.3 u`, u at random.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ImageFormation {
    /// The picture: PNG, JPEG (sRGB) or EXR (linear; its colours hold its alpha
    /// already), at most 2^24 pixels.
    pub file: String,
    /// Where the middle of the picture is, in metres.
    #[schemars(inner(range(min = -1e9, max = 1e9)))]
    pub centre_m: [f64; 3],
    /// Width of the picture in metres.
    #[schemars(range(min = 1e-10, max = 1e9))]
    pub width_m: f64,
    /// Height of the picture in metres; by default pixels are square.
    #[serde(default)]
    #[schemars(range(min = 1e-10, max = 1e9))]
    pub height_m: Option<f64>,
    /// Thickness of the cloud where the picture is brightest, in metres.
    #[schemars(range(min = 0.0, max = 1e9))]
    pub depth_m: f64,
    /// Angles about x, y and z in degrees, as of an instance.
    #[serde(default)]
    #[schemars(inner(range(min = -1e6, max = 1e6)))]
    pub rotate_deg: [f64; 3],
}

const fn ones() -> [f64; 2] {
    [1.0; 2]
}

const fn white() -> [f32; 3] {
    [0.95; 3]
}

const fn soft() -> f64 {
    1.0
}
