//! A clear sky from the physics of the atmosphere, as a map, and the sun in it.
//!
//! Air (Rayleigh), haze (Cornette and Shanks) and ozone over a spherical earth, in
//! eleven bands of the visible: light scattered once is integrated along each
//! ray, light scattered more often follows Hillaire 2020. The observer stands at
//! sea level; there is no refraction, and no light but the sun's.

mod march;
mod medium;
mod scatter;
mod spectrum;

use medium::{GROUND_M, Medium, columns_to_top};
use rayon::prelude::*;
use scatter::{Model, air_phase, haze_phase, towards_sun};
use shearwater_shared::scene::{AtmosphereSky, Sun};
use spectrum::{SOLAR, into_gamut, matching_rgb, to_rgb};
use std::f64::consts::PI;

/// One unit of radiance, in candelas per square metre: the clear sky at noon is
/// then around 1, and so is a grey wall in the sun.
pub const CANDELA_PER_UNIT: f64 = 10_000.0;

/// Columns and rows of the map: 0.35 degrees each.
pub const WIDTH: usize = 1024;
/// Rows of the map.
pub const HEIGHT: usize = 512;

/// Steps of a ray of the picture.
const VIEW_STEPS: usize = 48;
/// Bearings from the sun (half a turn) at which rays are followed; between them
/// all but the phase functions is interpolated.
const BEARINGS: usize = 33;
/// Light gathered at one bearing: by air, by haze, the rest; each in RGB.
type Node = [[f64; 3]; 3];

/// The sky without the sun's disc as an equirectangular map of linear radiance,
/// [`WIDTH`] by [`HEIGHT`], rows from the zenith down. The same for any number of
/// threads.
#[must_use]
pub fn sky_map(sky: &AtmosphereSky, sun: &Sun) -> Vec<[f32; 3]> {
    let elevation = sun.elevation_deg.to_radians();
    let model = Model::new(Medium::new(sky.turbidity), sky.ground_albedo, elevation);
    let matching = matching_rgb();
    let turns = sun.azimuth_deg / 360.0;
    let sun_turn = turns - libm::floor(turns);
    let rows: Vec<Vec<[f32; 3]>> = (0..HEIGHT)
        .into_par_iter()
        .map(|row| {
            let mu = libm::cos(PI * row_angle(row));
            let nodes = nodes(&model, mu, &matching);
            let texel = |column| texel(&nodes, mu, model.sun_cos(), bearing(column, sun_turn));
            (0..WIDTH)
                .map(texel)
                .map(|rgb| rgb.map(|v| (v * f64::from(sky.intensity)) as f32))
                .collect()
        })
        .collect();
    rows.concat()
}

// Angle of a row from the zenith, as a share of half a turn. The row just under
// the horizon repeats the one above it, so that the interpolated sky does not
// darken before it meets a sea that goes on to the horizon.
fn row_angle(row: usize) -> f64 {
    let row = if row == HEIGHT / 2 { row - 1 } else { row };
    (row as f64 + 0.5) / HEIGHT as f64
}

// Bearing of a column from the sun, 0 to pi.
fn bearing(column: usize, sun_turn: f64) -> f64 {
    let turn = (column as f64 + 0.5) / WIDTH as f64 - 0.5 - sun_turn;
    let turn = turn - libm::floor(turn);
    2.0 * PI * turn.min(1.0 - turn)
}

fn nodes(model: &Model, mu: f64, matching: &[[f64; 3]; spectrum::BANDS]) -> [Node; BEARINGS] {
    let ray = model.march(GROUND_M + OBSERVER_M, mu, VIEW_STEPS);
    std::array::from_fn(|i| {
        let cos_bearing = libm::cos(PI * i as f64 / (BEARINGS - 1) as f64);
        let light = model.gather(&ray, GROUND_M + OBSERVER_M, mu, cos_bearing);
        [light.air, light.haze, light.rest].map(|part| to_rgb(&part, matching))
    })
}

/// Height of the observer in metres.
const OBSERVER_M: f64 = 2.0;

// Catmull-Rom between the bearings (mirrored at both ends, where the sky is
// smooth), then the phase functions.
fn texel(nodes: &[Node; BEARINGS], mu: f64, sun_cos: f64, bearing: f64) -> [f64; 3] {
    let x = bearing / PI * (BEARINGS - 1) as f64;
    let i = (x as usize).min(BEARINGS - 2);
    let t = x - i as f64;
    let before = if i == 0 { 1 } else { i - 1 };
    let after = if i + 2 < BEARINGS {
        i + 2
    } else {
        BEARINGS - 2
    };
    let weights = [
        (before, 0.5 * t * ((2.0 - t) * t - 1.0)),
        (i, 0.5 * (t * t * (3.0 * t - 5.0) + 2.0)),
        (i + 1, 0.5 * t * ((4.0 - 3.0 * t) * t + 1.0)),
        (after, 0.5 * t * t * (t - 1.0)),
    ];
    let cos = towards_sun(mu, sun_cos, libm::cos(bearing));
    let phases = [air_phase(cos), haze_phase(cos), 1.0];
    let mut rgb = [0.0; 3];
    for (node, weight) in weights {
        for (part, phase) in nodes[node].iter().zip(phases) {
            for (sum, value) in rgb.iter_mut().zip(part) {
                *sum += weight * phase * value;
            }
        }
    }
    into_gamut(rgb).map(|v| v.max(0.0))
}

/// Radiance of the sun's disc as seen through this sky: solar irradiance times the
/// transmittance along the slant path, over the solid angle of the disc. Black
/// when all of the disc is below the horizon.
#[must_use]
pub fn sun_radiance(sky: &AtmosphereSky, sun: &Sun) -> [f32; 3] {
    let radius = sun.angular_radius_deg;
    let (low, high) = (sun.elevation_deg - radius, sun.elevation_deg + radius);
    if high <= 0.0 {
        return [0.0; 3];
    }
    // Middle of the part above the horizon.
    let seen = 0.5 * (low.max(0.0) + high.min(90.0));
    let mu = libm::sin(seen.to_radians());
    let medium = Medium::new(sky.turbidity);
    let columns = columns_to_top(GROUND_M + OBSERVER_M, mu);
    let through = std::array::from_fn(|i| SOLAR[i] * libm::exp(-medium.depth(columns, i)));
    let half_sin = libm::sin(radius.to_radians() * 0.5);
    let solid_angle = 4.0 * PI * half_sin * half_sin;
    into_gamut(to_rgb(&through, &matching_rgb()))
        .map(|v| (v * f64::from(sky.intensity) / solid_angle) as f32)
}

#[cfg(test)]
mod tests;
