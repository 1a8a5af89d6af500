//! How a scene wants its paths sampled, ready for the hot loop. No choice here
//! changes what a picture converges to.

use crate::sampler::Pattern;
use shearwater_shared::scene::{
    Mis, Roulette as RouletteDescription, RouletteRule, Sampler, Sampling, SkySampling,
};

/// Scatterings from which no path survives roulette for certain: light inside a
/// thick white cloud loses nothing and would go on for thousands.
const WEARY_FROM: u32 = 256;
/// Largest chance to survive from there on.
const WEARY_SURVIVAL: f32 = 0.999;

/// All choices of a scene.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strategy {
    /// Where random numbers come from.
    pub(crate) pattern: Pattern,
    /// Weights of light samples and chance hits.
    pub(crate) mis: Mis,
    /// The sky is sampled also where a surface's own directions find it well.
    pub(crate) sky_from_everywhere: bool,
    /// Where paths end.
    pub(crate) roulette: Roulette,
}

/// Russian roulette.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Roulette {
    rule: RouletteRule,
    from: u32,
    survival_min: f32,
}

impl Strategy {
    /// From the scene's own words.
    pub(crate) fn new(sampling: &Sampling) -> Self {
        Self {
            pattern: match sampling.sampler {
                Sampler::Sobol => Pattern::sobol(sampling.sobol_scatterings),
                Sampler::Independent => Pattern::independent(),
            },
            mis: sampling.mis,
            sky_from_everywhere: matches!(
                sampling.sky_sampling,
                SkySampling::Auto | SkySampling::Always
            ),
            roulette: Roulette::new(&sampling.roulette),
        }
    }
}

impl Roulette {
    fn new(described: &RouletteDescription) -> Self {
        Self {
            rule: described.rule,
            from: described.from,
            survival_min: described.survival_min,
        }
    }

    /// The chance to go on after scattering number `depth` (from 0), which left
    /// `kept` of the light and of the path's whole throughput `carried` (strongest
    /// channels); `None` where no dice are thrown.
    #[inline]
    pub(crate) fn survival(&self, depth: u32, kept: f32, carried: f32) -> Option<f32> {
        if depth < self.from && depth < WEARY_FROM {
            return None;
        }
        if depth >= WEARY_FROM {
            return Some(carried.clamp(self.survival_min, WEARY_SURVIVAL));
        }
        let chance = match self.rule {
            RouletteRule::Throughput => carried,
            RouletteRule::ThroughputRoot => carried.sqrt(),
            RouletteRule::Albedo => kept,
            RouletteRule::None => return None,
        };
        Some(chance.clamp(self.survival_min, 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn roulette(rule: RouletteRule) -> Roulette {
        Roulette {
            rule,
            from: 2,
            survival_min: 0.05,
        }
    }

    #[test]
    fn the_chance_follows_the_rule() {
        for (rule, expected) in [
            (RouletteRule::Throughput, Some(0.25)),
            (RouletteRule::ThroughputRoot, Some(0.5)),
            (RouletteRule::Albedo, Some(0.75)),
            (RouletteRule::None, None),
        ] {
            assert_eq!(roulette(rule).survival(1, 0.75, 0.25), None);
            assert_eq!(roulette(rule).survival(2, 0.75, 0.25), expected);
        }
    }

    // Whatever the rule, a path in a white cloud ends, and no weight explodes.
    #[test]
    fn every_rule_wearies_and_none_kills_for_certain() {
        for rule in [
            RouletteRule::Throughput,
            RouletteRule::ThroughputRoot,
            RouletteRule::Albedo,
            RouletteRule::None,
        ] {
            let rule = roulette(rule);
            assert_eq!(rule.survival(256, 1.0, 1.0), Some(0.999));
            assert_eq!(rule.survival(300, 1.0, 40.0), Some(0.999));
            assert!(rule.survival(9, 1e-9, 1e-9).is_none_or(|p| p == 0.05));
            assert!(rule.survival(9, 40.0, 40.0).is_none_or(|p| p == 1.0));
        }
    }
}
