//! From radiance to a picture.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What is done to the merged linear picture, once.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Post {
    /// Exposure in stops, -32 to 32.
    #[serde(default)]
    #[schemars(range(min = -32.0, max = 32.0))]
    pub exposure_ev: f32,
    /// Light that bleeds from bright places; none when absent.
    #[serde(default)]
    pub bloom: Option<Bloom>,
    /// Tone curve.
    #[serde(default)]
    pub view: View,
}

/// `B = I + strength * K * max(I - threshold, 0)` with a box filter K.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bloom {
    /// Radiance above which a channel blooms.
    #[serde(default = "one")]
    #[schemars(range(min = 0.0, max = 67_108_864.0))]
    pub threshold: f32,
    /// Share of the excess that is spread.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub strength: f32,
    /// Half-width of the box filter as a share of the picture's height.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub radius: f32,
    /// How often the box is applied: 1 is the report's box, 3 is nearly a Gaussian.
    #[serde(default = "one_pass")]
    #[schemars(range(min = 1, max = 3))]
    pub passes: u32,
}

/// Tone curve from linear light to the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum View {
    /// sRGB curve, clipped.
    Standard,
    /// AgX (Troy Sobotka): wide range, colours fade to white.
    #[default]
    Agx,
}

const fn one() -> f32 {
    1.0
}

const fn one_pass() -> u32 {
    1
}
