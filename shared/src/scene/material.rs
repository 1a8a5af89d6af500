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
    /// How a direction is drawn.
    #[serde(default)]
    pub sampling: LobeSampling,
}

/// GGX Cook-Torrance: a dielectric with a body, a metal, or a mixture; maybe
/// under a clear coat.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GgxMaterial {
    /// Diffuse colour of a dielectric, mirror colour of a metal; linear RGB, 0 to
    /// 1. With `conductor` it tints the metal.
    #[serde(default = "white")]
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub base_color: [f32; 3],
    /// Texture that multiplies `base_color`.
    #[serde(default)]
    pub base_color_texture: Option<String>,
    /// Perceptual roughness 0 to 1; GGX alpha is its square.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub roughness: f32,
    /// Texture that multiplies `roughness`.
    #[serde(default)]
    pub roughness_texture: Option<ChannelTexture>,
    /// 0 for a dielectric, 1 for a metal; left out it is 1 where `conductor`,
    /// `f82` or `metalness_texture` asks for a metal, else 0.
    #[serde(default)]
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub metalness: Option<f32>,
    /// Texture that multiplies `metalness`.
    #[serde(default)]
    pub metalness_texture: Option<ChannelTexture>,
    /// Reflectance of the dielectric at normal incidence.
    #[serde(default = "default_f0")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub specular_f0: f32,
    /// The metal by its complex index of refraction instead of by `base_color`,
    /// which then only tints it. Not with `f82` or `model: report`.
    #[serde(default)]
    pub conductor: Option<Conductor>,
    /// Edge tint of the metal: its reflectance at 82 degrees as a share of what
    /// Schlick's approximation gives there, per channel. Left out it is 1.
    #[serde(default)]
    #[schemars(inner(inner(range(min = 0.0, max = 1.0))))]
    pub f82: Option<[f32; 3]>,
    /// Clear coat on top. Not with `model: report`.
    #[serde(default)]
    pub coat: Option<Coat>,
    /// Which formulas.
    #[serde(default)]
    pub model: GgxModel,
    /// How a direction is drawn; `lobe` only with `model: report`.
    #[serde(default)]
    pub sampling: LobeSampling,
}

/// One channel of a picture as plain numbers: PNG and JPEG bytes are shares of
/// 255 and are not decoded as sRGB.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChannelTexture {
    /// PNG, JPEG or EXR.
    pub file: String,
    /// Which channel.
    #[serde(default)]
    pub channel: Channel,
}

/// A channel of a picture; a grey picture has the same in all three.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Channel {
    /// Red.
    #[default]
    R,
    /// Green, where glTF keeps roughness.
    G,
    /// Blue, where glTF keeps metalness.
    B,
}

/// Complex index of refraction n + ik of a metal, at the wavelengths of red,
/// green and blue (about 650, 550 and 450 nm).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Conductor {
    /// Index n, each 0 to 20.
    #[schemars(inner(range(min = 0.0, max = 20.0)))]
    pub n: [f32; 3],
    /// Absorption k, each 0 to 20.
    #[schemars(inner(range(min = 0.0, max = 20.0)))]
    pub k: [f32; 3],
}

/// A clear varnish: a second, dielectric surface above the first, which gets what
/// the coat lets through on the way in and on the way out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Coat {
    /// Share of the surface that is coated, 0 to 1.
    #[serde(default = "one")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub weight: f32,
    /// Perceptual roughness 0 to 1; GGX alpha is its square.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub roughness: f32,
    /// Index of refraction, 1 to 3. A scene may have four different ones, its
    /// water's included.
    #[serde(default = "coat_ior")]
    #[schemars(range(min = 1.0, max = 3.0))]
    pub ior: f32,
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

/// How a model of two lobes draws a direction. Both are right in the mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LobeSampling {
    /// Draw from one lobe and weigh by the density of all (less noise).
    #[default]
    Mixture,
    /// The student report's: pick one lobe in proportion to kd and ks and weigh
    /// its value by its own density (more noise).
    Lobe,
}

const fn white() -> [f32; 3] {
    [1.0; 3]
}

const fn default_f0() -> f32 {
    0.04
}

const fn one() -> f32 {
    1.0
}

const fn coat_ior() -> f32 {
    1.5
}

impl GgxMaterial {
    /// The metalness that is meant where none is given.
    #[must_use]
    pub fn metalness(&self) -> f32 {
        let metal =
            self.conductor.is_some() || self.f82.is_some() || self.metalness_texture.is_some();
        self.metalness.unwrap_or(if metal { 1.0 } else { 0.0 })
    }
}

impl Material {
    /// Names of the textures it uses, one after another.
    pub fn textures(&self) -> impl Iterator<Item = &str> {
        let channels = match self {
            Self::Ggx(m) => [&m.roughness_texture, &m.metalness_texture],
            _ => [&None, &None],
        };
        let channels = channels.into_iter().flatten().map(|t| t.file.as_str());
        self.color_texture().into_iter().chain(channels)
    }

    /// Name of the texture that tints it.
    #[must_use]
    pub fn color_texture(&self) -> Option<&str> {
        let texture = match self {
            Self::Lambert(m) => &m.albedo_texture,
            Self::Phong(m) => &m.kd_texture,
            Self::Ggx(m) => &m.base_color_texture,
        };
        texture.as_deref()
    }
}
