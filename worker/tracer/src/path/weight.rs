//! Weights of two techniques that can find the same light. For every direction
//! that a light sample can have, the two weights add up to 1; a direction that none
//! can have (density 0) belongs to chance alone.

use shearwater_shared::scene::Mis;

/// Weight of a light sample of density `pdf`, which scattering finds with density
/// `scatter`.
#[inline]
pub(super) fn light_weight(mis: Mis, pdf: f32, scatter: f32) -> f32 {
    match mis {
        Mis::Power => power(pdf, scatter),
        Mis::Balance => balance(pdf, scatter),
        Mis::LightsOnly | Mis::ScatteringOnly => 1.0,
    }
}

/// Weight of a chance hit of density `pdf`, which light sampling also finds, with
/// density `light`. (Under [`Mis::ScatteringOnly`] nothing is also sampled.)
#[inline]
pub(super) fn chance_weight(mis: Mis, pdf: f32, light: f32) -> f32 {
    match mis {
        Mis::Power => power(pdf, light),
        Mis::Balance => balance(pdf, light),
        Mis::LightsOnly => {
            if light > 0.0 {
                0.0
            } else {
                1.0
            }
        }
        Mis::ScatteringOnly => 1.0,
    }
}

// Veach and Guibas 1995: power heuristic, exponent 2.
#[inline]
fn power(pdf: f32, other: f32) -> f32 {
    let ratio = other / pdf;
    // A ratio of infinity gives weight 0.
    1.0 / (1.0 + ratio * ratio)
}

// The same with exponent 1.
#[inline]
fn balance(pdf: f32, other: f32) -> f32 {
    1.0 / (1.0 + other / pdf)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_two_techniques_add_up() {
        for mis in [Mis::Power, Mis::Balance, Mis::LightsOnly] {
            for (a, b) in [(1.0, 1.0), (0.2, 14_000.0), (1e10, 1e-3), (3.0, 0.0)] {
                let by_light = if b > 0.0 {
                    light_weight(mis, b, a)
                } else {
                    0.0
                };
                let sum = chance_weight(mis, a, b) + by_light;
                assert!((sum - 1.0).abs() < 1e-6, "{mis:?} {a} {b}: {sum}");
            }
        }
        assert_eq!(power(0.0, 1.0), 0.0);
        assert_eq!(balance(0.0, 1.0), 0.0);
        assert_eq!(power(1.0, 0.0), 1.0);
    }
}
