//! Skies as equirectangular maps of linear radiance.
//!
//! u = 0.5 + atan2(x, -z) / 2 pi grows to the right from a middle column that
//! looks towards -z; v = acos(y) / pi grows down from the zenith.

mod clouds;
mod dome;
pub mod night;
pub mod noon;
pub mod overcast;

use crate::vec3::{Vec3, vec3};
use std::f64::consts::{PI, TAU};

/// Width of the map in pixels.
pub const WIDTH: usize = 2048;
/// Height of the map in pixels.
pub const HEIGHT: usize = 1024;

/// Direction of a bearing (degrees clockwise from -z) and elevation (degrees).
#[must_use]
pub fn direction(azimuth_deg: f64, elevation_deg: f64) -> Vec3 {
    let (a, e) = (azimuth_deg.to_radians(), elevation_deg.to_radians());
    let flat = libm::cos(e);
    vec3(flat * libm::sin(a), libm::sin(e), -flat * libm::cos(a))
}

/// The pixels of the sunset, row by row from the zenith.
#[must_use]
pub fn pixels(to_sun: Vec3) -> Vec<[f32; 3]> {
    map(WIDTH, HEIGHT, |towards| radiance(towards, to_sun))
}

/// The pixels of any sky, row by row from the zenith.
#[must_use]
pub fn map(width: usize, height: usize, radiance: impl Fn(Vec3) -> [f64; 3]) -> Vec<[f32; 3]> {
    let mut out = Vec::with_capacity(width * height);
    for row in 0..height {
        let polar = PI * (row as f64 + 0.5) / height as f64;
        for column in 0..width {
            let bearing = TAU * ((column as f64 + 0.5) / width as f64 - 0.5);
            let flat = libm::sin(polar);
            let towards = vec3(
                flat * libm::sin(bearing),
                libm::cos(polar),
                -flat * libm::cos(bearing),
            );
            out.push(radiance(towards).map(|v| v as f32));
        }
    }
    out
}

/// Radiance from a direction, clouds included.
#[must_use]
pub fn radiance(towards: Vec3, to_sun: Vec3) -> [f64; 3] {
    if towards.y < 0.0 {
        return dome::below(towards, to_sun);
    }
    let clear = dome::clear(towards, to_sun);
    let near_sun = 0.5 + 0.5 * towards.dot(to_sun);
    let near_sun = near_sun * near_sun * near_sun;

    let veil = clouds::cirrus(towards);
    // Ice scatters forward: bright rose to gold near the sun, violet far off.
    let ice = dome::blend([0.36, 0.22, 0.40], [1.65, 0.50, 0.22], near_sun);
    let ice: [f64; 3] =
        std::array::from_fn(|i| 0.45 * clear[i] + ice[i] * (0.35 + 0.65 * veil.lit));
    let sky = dome::blend(clear, ice, veil.opacity);

    let cells = clouds::altocumulus(towards, to_sun);
    let shade = dome::blend([0.17, 0.14, 0.23], [0.42, 0.13, 0.15], near_sun);
    let edge = dome::blend([0.55, 0.32, 0.36], [3.20, 1.10, 0.18], near_sun);
    let cell = dome::add(shade, edge, cells.lit);
    let haze = libm::exp(-towards.y / 0.05);
    let cell = dome::blend(cell, clear, 0.75 * haze);
    dome::blend(sky, cell, cells.opacity)
}
