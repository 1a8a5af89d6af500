//! Sunlight scattered once, and light scattered more often.

use super::march::{March, march};
use super::medium::{Columns, GROUND_M, Medium, TOP_M, horizon};
use super::spectrum::{BANDS, SOLAR, Spectrum};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Steps of a ray that gathers light for later scatterings.
const GATHER_STEPS: usize = 20;
/// Directions of these, in cosine and in bearing (half a turn; the other half is
/// its mirror).
const GATHER_COSINES: usize = 8;
const GATHER_BEARINGS: usize = 4;

/// Nodes of the multiple scattering, by height and by the sun's zenith angle.
const HEIGHTS: usize = 16;
const ANGLES: usize = 25;
/// How far the sun's zenith angle can differ along one ray from that at its start:
/// the angle at the earth's centre under the longest ray, and a little more.
const ANGLE_SPAN: f64 = 11.0 * PI / 180.0;

/// Sunlight in the atmosphere, for one place of the sun.
pub(super) struct Model {
    medium: Medium,
    columns: Columns,
    ground_albedo: f64,
    /// Zenith angle of the sun at the observer.
    sun_zenith: f64,
    /// Light scattered at least twice, by angle and height; in W / (m^2 sr nm) per
    /// unit of scattering.
    multiple: Vec<Spectrum>,
    /// Irradiance of the ground at the observer, without the sun's disc.
    ground_sky: Spectrum,
}

/// Integrals along a ray, before the phase functions: in-scattered light that came
/// straight from the sun, by air and by haze, and all the rest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gathered {
    pub(super) air: Spectrum,
    pub(super) haze: Spectrum,
    pub(super) rest: Spectrum,
}

impl Model {
    /// The sun at `elevation` radians over a ground of `ground_albedo`.
    pub(super) fn new(medium: Medium, ground_albedo: f64, elevation: f64) -> Self {
        let mut model = Self {
            medium,
            columns: Columns::new(),
            ground_albedo,
            sun_zenith: 0.5 * PI - elevation,
            multiple: Vec::new(),
            ground_sky: [0.0; BANDS],
        };
        let rows: Vec<Vec<Spectrum>> = (0..HEIGHTS)
            .into_par_iter()
            .map(|height| model.multiple_row(height))
            .collect();
        model.multiple = rows.concat();
        model.ground_sky = model.sky_irradiance();
        model
    }

    /// Cosine of the sun's zenith angle at the observer.
    pub(super) fn sun_cos(&self) -> f64 {
        libm::cos(self.sun_zenith)
    }

    /// The ray from `r` with vertical cosine `mu`, cut into steps.
    pub(super) fn march(&self, r: f64, mu: f64, count: usize) -> March {
        march(&self.medium, r, mu, count)
    }

    /// Light gathered along `ray`, which starts at `r` with vertical cosine `mu`
    /// and turns away from the sun's bearing by the angle of cosine `cos_bearing`.
    pub(super) fn gather(&self, ray: &March, r: f64, mu: f64, cos_bearing: f64) -> Gathered {
        let mut gathered = Gathered {
            air: [0.0; BANDS],
            haze: [0.0; BANDS],
            rest: [0.0; BANDS],
        };
        let sun_cos = self.sun_cos();
        let towards_sun = towards_sun(mu, sun_cos, cos_bearing);
        let cos_at = |s: f64, r_s: f64| ((r * sun_cos + s * towards_sun) / r_s).clamp(-1.0, 1.0);
        let mut clear_before = sun_cos - horizon(r);
        for step in &ray.steps {
            let clear = cos_at(step.end, step.r_end) - horizon(step.r_end);
            let cos = cos_at(step.middle, step.r_middle);
            let lit = share_above_zero(clear_before, clear);
            clear_before = clear;
            if lit > 0.0 {
                let sun = self.sunlight(step.r_middle, cos);
                for (band, sun) in sun.into_iter().enumerate() {
                    gathered.air[band] += step.air[band] * sun * lit;
                    gathered.haze[band] += step.haze[band] * sun * lit;
                }
            }
            let multiple = self.multiple_at(step.r_middle, cos);
            for (band, multiple) in multiple.into_iter().enumerate() {
                gathered.rest[band] += (step.air[band] + step.haze[band]) * multiple;
            }
        }
        if let Some(through) = &ray.ground {
            let cos = cos_at(ray.length, GROUND_M);
            let sun = self.sunlight(GROUND_M, cos);
            for band in 0..BANDS {
                let irradiance = sun[band] * cos.max(0.0) + self.ground_sky[band];
                gathered.rest[band] += through[band] * self.ground_albedo / PI * irradiance;
            }
        }
        gathered
    }

    /// Irradiance of a plane that faces the sun, above its horizon.
    pub(super) fn sunlight(&self, r: f64, cos: f64) -> Spectrum {
        let columns = self.columns.at(r, cos);
        std::array::from_fn(|band| SOLAR[band] * libm::exp(-self.medium.depth(columns, band)))
    }

    // Hillaire 2020, "A Scalable and Production Ready Sky and Atmosphere Rendering
    // Technique", section 5.5: light scattered twice is gathered over all
    // directions with an isotropic phase; every further scattering multiplies it
    // by the same share, so that their sum is a geometric series.
    fn multiple_row(&self, height: usize) -> Vec<Spectrum> {
        let r = node_radius(height);
        let marches: Vec<(f64, March)> = (0..GATHER_COSINES)
            .map(|i| 1.0 - 2.0 * (i as f64 + 0.5) / GATHER_COSINES as f64)
            .map(|mu| (mu, self.march(r, mu, GATHER_STEPS)))
            .collect();
        let mut share = [0.0; BANDS];
        for step in marches.iter().flat_map(|(_, march)| &march.steps) {
            for (band, share) in share.iter_mut().enumerate() {
                *share += (step.air[band] + step.haze[band]) / GATHER_COSINES as f64;
            }
        }
        (0..ANGLES)
            .map(|angle| {
                let zenith = self.node_zenith(angle);
                let twice = self.second_order(r, &marches, libm::cos(zenith));
                // Less than 1 by far: a share leaves for space or the ground.
                std::array::from_fn(|band| twice[band] / (1.0 - share[band].min(0.99)))
            })
            .collect()
    }

    // Sunlight scattered once on its way to `r`, or reflected by the ground: its
    // mean over all directions.
    fn second_order(&self, r: f64, marches: &[(f64, March)], sun_cos: f64) -> Spectrum {
        let mut mean = [0.0; BANDS];
        let weight = 1.0 / (GATHER_COSINES * GATHER_BEARINGS) as f64;
        for (mu, ray) in marches {
            for bearing in 0..GATHER_BEARINGS {
                let cos_bearing = libm::cos(PI * (bearing as f64 + 0.5) / GATHER_BEARINGS as f64);
                let towards_sun = towards_sun(*mu, sun_cos, cos_bearing);
                let cos_at = |s: f64, r_s: f64| (r * sun_cos + s * towards_sun) / r_s;
                let mut clear_before = sun_cos - horizon(r);
                for step in &ray.steps {
                    let clear = cos_at(step.end, step.r_end) - horizon(step.r_end);
                    let lit = share_above_zero(clear_before, clear);
                    clear_before = clear;
                    if lit > 0.0 {
                        let sun = self.sunlight(step.r_middle, cos_at(step.middle, step.r_middle));
                        for band in 0..BANDS {
                            let scattered = step.air[band] + step.haze[band];
                            mean[band] += scattered * sun[band] * (lit * weight / (4.0 * PI));
                        }
                    }
                }
                if let Some(through) = &ray.ground {
                    let cos = cos_at(ray.length, GROUND_M).max(0.0);
                    let sun = self.sunlight(GROUND_M, cos);
                    for band in 0..BANDS {
                        let reflected = self.ground_albedo / PI * cos * sun[band];
                        mean[band] += through[band] * reflected * weight;
                    }
                }
            }
        }
        mean
    }

    fn node_zenith(&self, angle: usize) -> f64 {
        self.sun_zenith + ANGLE_SPAN * (2.0 * angle as f64 / (ANGLES - 1) as f64 - 1.0)
    }

    fn multiple_at(&self, r: f64, sun_cos: f64) -> Spectrum {
        if self.multiple.is_empty() {
            return [0.0; BANDS];
        }
        let zenith = libm::acos(sun_cos.clamp(-1.0, 1.0));
        // The nodes go on past zenith and nadir, where the angle turns back.
        let from_first = (zenith - self.sun_zenith) / (2.0 * ANGLE_SPAN) + 0.5;
        let x = from_first.clamp(0.0, 1.0) * (ANGLES - 1) as f64;
        let height = ((r - GROUND_M) / (TOP_M - GROUND_M)).clamp(0.0, 1.0);
        let y = height.sqrt() * (HEIGHTS - 1) as f64;
        let (i, j) = ((x as usize).min(ANGLES - 2), (y as usize).min(HEIGHTS - 2));
        let (fx, fy) = (x - i as f64, y - j as f64);
        let node = |i: usize, j: usize| &self.multiple[j * ANGLES + i];
        let (a, b) = (node(i, j), node(i + 1, j));
        let (c, d) = (node(i, j + 1), node(i + 1, j + 1));
        std::array::from_fn(|band| {
            let low = a[band] + (b[band] - a[band]) * fx;
            low + (c[band] + (d[band] - c[band]) * fx - low) * fy
        })
    }

    // Irradiance of level ground by the sky, by a coarse sum over the hemisphere.
    fn sky_irradiance(&self) -> Spectrum {
        const COSINES: usize = 8;
        const BEARINGS: usize = 8;
        let mut sum = [0.0; BANDS];
        for i in 0..COSINES {
            let mu = (i as f64 + 0.5) / COSINES as f64;
            let ray = self.march(GROUND_M, mu, GATHER_STEPS);
            for j in 0..BEARINGS {
                let cos_bearing = libm::cos(PI * (j as f64 + 0.5) / BEARINGS as f64);
                let light = self.gather(&ray, GROUND_M, mu, cos_bearing);
                let towards_sun = towards_sun(mu, self.sun_cos(), cos_bearing);
                let radiance = light.radiance(towards_sun);
                let weight = 2.0 * PI * mu / (COSINES * BEARINGS) as f64;
                for (sum, radiance) in sum.iter_mut().zip(radiance) {
                    *sum += weight * radiance;
                }
            }
        }
        sum
    }
}

impl Gathered {
    /// Radiance at the angle to the sun whose cosine is `towards_sun`.
    pub(super) fn radiance(&self, towards_sun: f64) -> Spectrum {
        let (air, haze) = (air_phase(towards_sun), haze_phase(towards_sun));
        std::array::from_fn(|band| self.air[band] * air + self.haze[band] * haze + self.rest[band])
    }
}

/// Rayleigh's phase function, per steradian.
pub(super) fn air_phase(cos: f64) -> f64 {
    3.0 / (16.0 * PI) * (1.0 + cos * cos)
}

/// Haze scatters forward: the phase function of Cornette and Shanks 1992 with
/// asymmetry 0.8, per steradian.
pub(super) fn haze_phase(cos: f64) -> f64 {
    const G: f64 = 0.8;
    let spread = 1.0 + G * G - 2.0 * G * cos;
    3.0 / (8.0 * PI) * (1.0 - G * G) * (1.0 + cos * cos) / ((2.0 + G * G) * spread * spread.sqrt())
}

/// Cosine of the angle between a ray and the sun.
pub(super) fn towards_sun(mu: f64, sun_cos: f64, cos_bearing: f64) -> f64 {
    let sines = ((1.0 - mu * mu) * (1.0 - sun_cos * sun_cos))
        .max(0.0)
        .sqrt();
    (mu * sun_cos + sines * cos_bearing).clamp(-1.0, 1.0)
}

// Share of a step in which a quantity is positive that is `a` at its start and `b`
// at its end: the earth's shadow ends within a step, not at the next.
fn share_above_zero(a: f64, b: f64) -> f64 {
    let (low, high) = (a.min(b), a.max(b));
    if low >= 0.0 {
        1.0
    } else if high <= 0.0 {
        0.0
    } else {
        high / (high - low)
    }
}

fn node_radius(height: usize) -> f64 {
    let share = height as f64 / (HEIGHTS - 1) as f64;
    // Not the ground itself: half of the directions would end in it at once.
    (GROUND_M + (TOP_M - GROUND_M) * share * share).max(GROUND_M + 1.0)
}

#[cfg(test)]
#[path = "scatter_tests.rs"]
mod tests;
