//! How light is sampled: choices that change the noise, never the mean.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How paths are sampled. Every choice has the same expected picture; they differ
/// in noise and time. What is not given is what measured best (docs/sampling.md).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sampling {
    /// Where random numbers come from.
    #[serde(default)]
    pub sampler: Sampler,
    /// Scatterings of a path that draw from Sobol points, 0 to 8; later ones are
    /// independent. Without meaning for `sampler: independent`.
    #[serde(default = "sobol_scatterings")]
    #[schemars(range(min = 0, max = 8))]
    pub sobol_scatterings: u32,
    /// How light samples and chance hits of the same light share it.
    #[serde(default)]
    pub mis: Mis,
    /// Sample a sky map in proportion to what lies above its mean only, and leave
    /// the rest to the surfaces' own directions (Karlik et al. 2019, "MIS
    /// Compensation").
    #[serde(default = "map_compensation")]
    pub map_compensation: bool,
    /// When the sky is sampled beside the surfaces' own directions.
    #[serde(default)]
    pub sky_sampling: SkySampling,
    /// A light sample that would add less than this share of the sky's mean
    /// radiance is traced at random and counts for more in return; 0 to 1.
    #[serde(default = "faint_share")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub faint_share: f32,
    /// Where paths end.
    #[serde(default)]
    pub roulette: Roulette,
}

/// Where random numbers come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Sampler {
    /// Owen-scrambled Sobol points in groups of four dimensions (Burley 2020).
    #[default]
    Sobol,
    /// Independent numbers for every sample.
    Independent,
}

/// Weights of two techniques that can find the same light (Veach and Guibas 1995).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Mis {
    /// In proportion to the square of the density.
    #[default]
    Power,
    /// In proportion to the density.
    Balance,
    /// Light samples alone, wherever they can find the light; for measurements.
    LightsOnly,
    /// Chance hits alone, for measurements: a small sun is then hardly ever found.
    ScatteringOnly,
}

/// When the sky is sampled beside the surfaces' own directions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SkySampling {
    /// An uneven sky, from everything but perfect mirrors.
    #[default]
    Auto,
    /// An uneven sky, from what is diffuse or rough.
    Rough,
    /// Any sky, from what is diffuse or rough.
    AnySky,
    /// Any sky, from everything but perfect mirrors.
    Always,
    /// Not at all.
    Never,
}

/// Russian roulette: a path goes on by chance and then counts for more.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Roulette {
    /// What the chance to go on follows.
    #[serde(default)]
    pub rule: RouletteRule,
    /// Scatterings before it begins, 0 to 64.
    #[serde(default = "roulette_from")]
    #[schemars(range(min = 0, max = 64))]
    pub from: u32,
    /// Least chance to go on, 0.001 to 0.99.
    #[serde(default = "survival_min")]
    #[schemars(range(min = 0.001, max = 0.99))]
    pub survival_min: f32,
}

/// What the chance of a path to go on follows. From the 256th scattering on it is
/// the throughput under any rule, and below 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RouletteRule {
    /// The strongest channel of the light that the path still carries.
    #[default]
    Throughput,
    /// Its square root: paths live longer.
    ThroughputRoot,
    /// The strongest channel of what the last scattering left of it.
    Albedo,
    /// Nothing: it always goes on, until it is black.
    None,
}

impl Default for Sampling {
    fn default() -> Self {
        Self {
            sampler: Sampler::default(),
            sobol_scatterings: sobol_scatterings(),
            mis: Mis::default(),
            map_compensation: map_compensation(),
            sky_sampling: SkySampling::default(),
            faint_share: faint_share(),
            roulette: Roulette::default(),
        }
    }
}

impl Default for Roulette {
    fn default() -> Self {
        Self {
            rule: RouletteRule::default(),
            from: roulette_from(),
            survival_min: survival_min(),
        }
    }
}

// Deep scatterings spread over so many dimensions that a net gains nothing there.
const fn sobol_scatterings() -> u32 {
    3
}

const fn map_compensation() -> bool {
    true
}

// Most faint samples are the far tail of a shiny lobe.
const fn faint_share() -> f32 {
    0.05
}

const fn roulette_from() -> u32 {
    3
}

// So that no survivor's weight explodes.
const fn survival_min() -> f32 {
    0.05
}
