//! Materials.

use super::tagged::tagged_enum;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a surface scatters light.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Material {
    /// Ideal diffuse.
    Lambert(LambertMaterial),
    /// Modified Phong (Lafortune and Willems 1994).
    Phong(PhongMaterial),
    /// GGX Cook-Torrance over an energy-conserving diffuse base.
    Ggx(GgxMaterial),
}

tagged_enum!(Material { "lambert" => Lambert, "phong" => Phong, "ggx" => Ggx });

/// Ideal diffuse reflection.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LambertMaterial {
    /// Share of light reflected, linear RGB, each 0 to 1.
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub albedo: [f32; 3],
    /// Texture that multiplies `albedo`.
    #[serde(default)]
    pub albedo_texture: Option<String>,
}

/// Modified Phong: `kd / pi + ks (n + 2) / (2 pi) cos^n`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PhongMaterial {
    /// Diffuse share, linear RGB; `kd + ks` is at most 1 in each channel.
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub kd: [f32; 3],
    /// Texture that multiplies `kd`.
    #[serde(default)]
    pub kd_texture: Option<String>,
    /// Specular share, linear RGB.
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub ks: [f32; 3],
    /// Exponent n, 0 to 1e7.
    #[schemars(range(min = 0.0, max = 1e7))]
    pub exponent: f32,
}

/// GGX Cook-Torrance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GgxMaterial {
    /// Diffuse colour of a dielectric, mirror colour of a metal; linear RGB, 0 to 1.
    #[serde(default = "white")]
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub base_color: [f32; 3],
    /// Texture that multiplies `base_color`.
    #[serde(default)]
    pub base_color_texture: Option<String>,
    /// Perceptual roughness 0 to 1; GGX alpha is its square.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub roughness: f32,
    /// 0 for a dielectric, 1 for a metal.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub metalness: f32,
    /// Reflectance of the dielectric at normal incidence.
    #[serde(default = "default_f0")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub specular_f0: f32,
    /// Which formulas.
    #[serde(default)]
    pub model: GgxModel,
}

/// Which Cook-Torrance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum GgxModel {
    /// Exact height-correlated Smith, visible normals, Kelemen-Szirmay-Kalos diffuse.
    #[default]
    Corrected,
    /// The student report's: `k = (alpha + 1)^2 / 8`, `(1 - F(h))` diffuse.
    Report,
}

const fn white() -> [f32; 3] {
    [1.0; 3]
}

const fn default_f0() -> f32 {
    0.04
}

impl Material {
    /// Names of the textures it uses.
    pub fn textures(&self) -> impl Iterator<Item = &str> {
        let texture = match self {
            Self::Lambert(m) => &m.albedo_texture,
            Self::Phong(m) => &m.kd_texture,
            Self::Ggx(m) => &m.base_color_texture,
        };
        texture.as_deref().into_iter()
    }
}
