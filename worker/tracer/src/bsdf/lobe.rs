//! Parts that several models share: the diffuse lobe and the choice between
//! two lobes.

use core::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::BsdfSample;
use crate::math::warp::{cosine_hemisphere, cosine_hemisphere_pdf};

/// No lobe that exists is chosen less often than this: a lobe whose albedo is
/// small may still be the one that sees the sun.
const LOBE_PROBABILITY_MIN: f32 = 0.1;

/// The probability of choosing the specular lobe, in proportion to the two
/// reflected luminances; exactly 0 or 1 if a lobe is absent.
#[inline]
pub(super) fn specular_probability(specular: f32, diffuse: f32) -> f32 {
    if diffuse <= 0.0 {
        1.0
    } else if specular <= 0.0 {
        0.0
    } else {
        (specular / (specular + diffuse)).clamp(LOBE_PROBABILITY_MIN, 1.0 - LOBE_PROBABILITY_MIN)
    }
}

/// Whether a direction leaves the surface; not if it is NaN.
#[inline]
pub(super) fn above(wi: Vec3) -> bool {
    wi.z > 0.0
}

/// f cos and density of a Lambertian surface, `wi.z > 0`.
#[inline]
pub(super) fn lambert(albedo: Vec3, wi: Vec3) -> (Vec3, f32) {
    let pdf = wi.z * FRAC_1_PI;
    (albedo * pdf, pdf)
}

/// A sample of a Lambertian surface; `None` if it is black.
#[inline]
pub(super) fn sample_lambert(albedo: Vec3, u: [f32; 2]) -> Option<BsdfSample> {
    if albedo == Vec3::ZERO {
        return None;
    }
    let wi = cosine_hemisphere(u);
    Some(BsdfSample {
        wi,
        weight: albedo,
        pdf: cosine_hemisphere_pdf(wi.z),
        delta: false,
    })
}

/// The sample at `wi` of a mixture with the given value and density (the
/// one-sample estimator over all lobes: Veach and Guibas 1995, section 3).
#[inline]
pub(super) fn mixture_sample(wi: Vec3, (value, pdf): (Vec3, f32)) -> Option<BsdfSample> {
    if pdf > 0.0 && value != Vec3::ZERO {
        Some(BsdfSample {
            wi,
            weight: value * (1.0 / pdf),
            pdf,
            delta: false,
        })
    } else {
        None
    }
}

/// The sample at `wi` that counts the chosen lobe alone: its value over its own
/// density and the chance to choose it. `lobes` are diffuse and shiny. The density
/// it reports is that of both, as for light samples, whose weights must add to
/// one with this one's at each direction; any such pair leaves the mean alone.
#[inline]
pub(super) fn lobe_sample(
    wi: Vec3,
    lobes: [(Vec3, f32); 2],
    specular_probability: f32,
    is_shiny: bool,
) -> Option<BsdfSample> {
    let chances = [1.0 - specular_probability, specular_probability];
    let pdf = chances[0] * lobes[0].1 + chances[1] * lobes[1].1;
    let chosen = usize::from(is_shiny);
    let (value, density) = lobes[chosen];
    let own = chances[chosen] * density;
    if own > 0.0 && value != Vec3::ZERO {
        Some(BsdfSample {
            wi,
            weight: value * (1.0 / own),
            pdf,
            delta: false,
        })
    } else {
        None
    }
}
