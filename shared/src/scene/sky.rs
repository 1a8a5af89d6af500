//! Sky and sun.

use super::tagged::tagged_enum;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Light from all around.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Sky {
    /// The same radiance everywhere.
    Constant(ConstantSky),
    /// An equirectangular picture. Its middle column looks along -z and columns
    /// grow towards +x; its top row looks along +y.
    Map(MapSky),
    /// Such a picture on the inside of a sphere that stands in the scene.
    Dome(DomeSky),
    /// A clear sky computed from the place of the scene's sun.
    Atmosphere(AtmosphereSky),
}

tagged_enum!(Sky {
    "constant" => Constant,
    "map" => Map,
    "dome" => Dome,
    "atmosphere" => Atmosphere,
});

/// The same radiance everywhere.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConstantSky {
    /// Radiance, linear RGB.
    #[schemars(inner(range(min = 0.0, max = 67_108_864.0)))]
    pub radiance: [f32; 3],
}

/// An equirectangular picture around the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapSky {
    /// EXR (radiance), PNG or JPEG (sRGB) file.
    pub file: String,
    /// Turn about the vertical in degrees, clockwise seen from above.
    #[serde(default)]
    #[schemars(range(min = -1e6, max = 1e6))]
    pub rotation_deg: f64,
    /// Factor on its radiance.
    #[serde(default = "one")]
    #[schemars(range(min = 0.0, max = 67_108_864.0))]
    pub intensity: f32,
}

/// A sphere that shines inwards, with an equirectangular picture on its inside as
/// seen from its centre. It ends every ray: what lies beyond it is hidden. From
/// outside its near wall is clear, its far wall shines, and past it all is black.
/// The sun shines through it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DomeSky {
    /// EXR (radiance), PNG or JPEG (sRGB) file.
    pub file: String,
    /// Centre in metres.
    #[schemars(inner(range(min = -1e9, max = 1e9)))]
    pub centre_m: [f64; 3],
    /// Radius in metres.
    #[schemars(range(min = 1e-3, max = 1e9))]
    pub radius_m: f64,
    /// Turn about the vertical in degrees, clockwise seen from above.
    #[serde(default)]
    #[schemars(range(min = -1e6, max = 1e6))]
    pub rotation_deg: f64,
    /// Factor on its radiance.
    #[serde(default = "one")]
    #[schemars(range(min = 0.0, max = 67_108_864.0))]
    pub intensity: f32,
}

/// The clear sky of the earth at sea level, from the scattering of sunlight by
/// air, haze and ozone. The scene's `sun` says where the sun stands, also below the
/// horizon; its `radiance` may then be left out. One unit of radiance is 10,000
/// candelas per square metre.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AtmosphereSky {
    /// How much haze: optical depth of haze and air over that of air alone, at
    /// 550 nm straight up. 1 is air alone, 2 very clear, 6 hazy; 1 to 10.
    #[serde(default = "turbidity")]
    #[schemars(range(min = 1.0, max = 10.0))]
    pub turbidity: f64,
    /// Share of light that the ground reflects, 0 to 1.
    #[serde(default = "ground_albedo")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub ground_albedo: f64,
    /// Factor on its radiance, and on the sun's where the sky gives it.
    #[serde(default = "one")]
    #[schemars(range(min = 0.0, max = 67_108_864.0))]
    pub intensity: f32,
}

/// A distant sphere of light. Azimuth is in degrees clockwise seen from above:
/// 0 looks along -z, 90 along +x.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sun {
    /// Azimuth of its centre in degrees.
    #[schemars(range(min = -1e6, max = 1e6))]
    pub azimuth_deg: f64,
    /// Elevation of its centre above the horizon in degrees, -90 to 90.
    #[schemars(range(min = -90.0, max = 90.0))]
    pub elevation_deg: f64,
    /// Angular radius in degrees, above 0, at most 45; the real sun has 0.27.
    #[serde(default = "sun_radius")]
    #[schemars(extend("exclusiveMinimum" = 0), range(max = 45.0))]
    pub angular_radius_deg: f64,
    /// Radiance of the disc, linear RGB. Only under a sky of type `atmosphere` it
    /// may be left out: it is then that of the real sun through this sky.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(inner(inner(range(min = 0.0, max = 67_108_864.0))))]
    pub radiance: Option<[f32; 3]>,
}

impl Sky {
    /// The name of the file that it needs, if any.
    #[must_use]
    pub fn file(&self) -> Option<&str> {
        match self {
            Self::Constant(_) | Self::Atmosphere(_) => None,
            Self::Map(sky) => Some(&sky.file),
            Self::Dome(sky) => Some(&sky.file),
        }
    }
}

const fn one() -> f32 {
    1.0
}

const fn turbidity() -> f64 {
    2.0
}

const fn ground_albedo() -> f64 {
    0.1
}

const fn sun_radius() -> f64 {
    0.27
}
