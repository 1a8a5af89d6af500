//! A ray through the atmosphere, cut into steps: what each step lets through to
//! the ray's start. The same for every bearing, so it is made once per elevation.

use super::medium::{Medium, densities, to_ground, to_top};
use super::spectrum::{BANDS, Spectrum};

/// One step of a ray.
pub(super) struct Step {
    /// Distance of its middle along the ray, and of its far end, in metres.
    pub(super) middle: f64,
    pub(super) end: f64,
    /// Distance of both from the earth's centre.
    pub(super) r_middle: f64,
    pub(super) r_end: f64,
    /// What air and haze in it scatter to the start, for light of unit irradiance
    /// from everywhere along the step: scattering times length times
    /// transmittance.
    pub(super) air: Spectrum,
    pub(super) haze: Spectrum,
}

/// A ray from inside the atmosphere to where it leaves it or meets the ground.
pub(super) struct March {
    pub(super) steps: Vec<Step>,
    /// Transmittance to the ground, for a ray that meets it.
    pub(super) ground: Option<Spectrum>,
    /// Its length in metres.
    pub(super) length: f64,
}

/// Cut the ray from `r` of vertical cosine `mu` into `count` steps, which grow with
/// the square of the distance: most is scattered near the ground.
pub(super) fn march(medium: &Medium, r: f64, mu: f64, count: usize) -> March {
    let ground = to_ground(r, mu);
    let length = ground.unwrap_or_else(|| to_top(r, mu));
    let radius = |s: f64| (r * r + s * s + 2.0 * r * mu * s).max(0.0).sqrt();
    let mut steps = Vec::with_capacity(count);
    let mut through = [1.0; BANDS];
    let mut start = 0.0;
    for i in 0..count {
        let share = (i + 1) as f64 / count as f64;
        let end = length * share * share;
        let middle = 0.5 * (start + end);
        let r_middle = radius(middle);
        let density = densities(r_middle);
        let columns = density.map(|v| v * (end - start));
        let (mut air, mut haze) = ([0.0; BANDS], [0.0; BANDS]);
        for band in 0..BANDS {
            let depth = medium.depth(columns, band);
            let passed = libm::exp(-depth);
            // The mean transmittance over the step, exact for constant density.
            let mean = if depth > 1e-6 {
                (1.0 - passed) / depth
            } else {
                1.0 - 0.5 * depth
            };
            air[band] = through[band] * mean * medium.air[band] * columns[0];
            haze[band] = through[band] * mean * medium.haze[band] * columns[1];
            through[band] *= passed;
        }
        steps.push(Step {
            middle,
            end,
            r_middle,
            r_end: radius(end),
            air,
            haze,
        });
        start = end;
    }
    March {
        steps,
        ground: ground.map(|_| through),
        length,
    }
}
