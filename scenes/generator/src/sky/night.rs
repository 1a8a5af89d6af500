//! Night: stars over the last blue, airglow, and a town's light on the horizon.

use super::direction;
use super::dome::{Radiance, add, blend};
use crate::curve::smoothstep;
use crate::noise::{fbm, hash3, unit};
use crate::vec3::{Vec3, vec3};

/// Stars are looked for in a grid of so many cells along the unit cube's edges.
const STAR_GRID: f64 = 400.0;
/// Share of the cells with a star.
const STAR_SHARE: f64 = 0.0035;

/// Radiance from a direction, a night as a picture shows it and not as it is: the
/// blue overhead 0.03, the town's glow 0.5, a bright star 8.
#[must_use]
pub fn radiance(towards: Vec3) -> Radiance {
    let up = towards.y.max(0.0);
    let mut sky = blend(
        [0.007, 0.011, 0.034],
        [0.020, 0.034, 0.062],
        libm::exp(-up / 0.30),
    );
    // Airglow: oxygen's green in a layer a hundred kilometres up, thickest along
    // the horizon.
    let ripple = 0.8 + 0.35 * fbm(towards.x * 2.2, up * 6.0, towards.z * 2.2, 3, 0.5, 701);
    let layer = (up - 0.13) / 0.13;
    sky = add(
        sky,
        [0.008, 0.040, 0.026],
        ripple * libm::exp(-layer * layer),
    );
    // A town beyond the horizon, and a fainter one.
    for (bearing, colour, width) in [
        (-14.0, [0.62, 0.27, 0.085], 0.42),
        (70.0, [0.20, 0.10, 0.05], 0.30),
    ] {
        let town = direction(bearing, 0.0);
        let flat = (towards.x * towards.x + towards.z * towards.z)
            .sqrt()
            .max(1e-6);
        let cos = ((towards.x * town.x + towards.z * town.z) / flat).clamp(-1.0, 1.0);
        let aside = libm::acos(cos) / width;
        let glow = libm::exp(-aside * aside) * libm::exp(-up / 0.075);
        sky = add(sky, colour, glow);
        sky = add(
            sky,
            [0.06, 0.03, 0.05],
            0.7 * libm::exp(-aside) * libm::exp(-up / 0.25),
        );
    }
    if towards.y < 0.0 {
        return blend([0.004, 0.005, 0.008], sky, libm::exp(towards.y / 0.04));
    }
    let clear = smoothstep(0.02, 0.25, up);
    let band = milky_way(towards);
    sky = add(sky, [0.060, 0.058, 0.070], band * clear);
    let colour = star(towards, 1.0 + 2.0 * band);
    add(sky, colour, clear)
}

// Brightness of the galaxy's band, with its dark lanes.
fn milky_way(towards: Vec3) -> f64 {
    let pole = vec3(0.62, 0.28, 0.73).normalized();
    let off = towards.dot(pole);
    let cloudy = fbm(
        towards.x * 3.1,
        towards.y * 3.1,
        towards.z * 3.1,
        5,
        0.55,
        711,
    );
    let lane = fbm(
        towards.x * 6.0,
        towards.y * 6.0,
        towards.z * 6.0,
        4,
        0.5,
        712,
    );
    let wide = libm::exp(-off * off / 0.045) * (0.65 + 0.9 * cloudy).max(0.0);
    let dust = smoothstep(0.0, 0.35, lane) * libm::exp(-off * off / 0.006);
    (wide * (1.0 - 0.75 * dust)).max(0.0)
}

// A star in the direction's cell, if the cell has one: one pixel or two wide.
fn star(towards: Vec3, crowd: f64) -> Radiance {
    let cell = |v: f64| libm::floor(v * STAR_GRID) as i32;
    let (i, j, k) = (cell(towards.x), cell(towards.y), cell(towards.z));
    let draw = |seed| unit(hash3(i, j, k, seed));
    if draw(721) >= STAR_SHARE * crowd {
        return [0.0; 3];
    }
    let place = |cell: i32, seed| (f64::from(cell) + 0.3 + 0.4 * draw(seed)) / STAR_GRID;
    let at = vec3(place(i, 722), place(j, 723), place(k, 724)).normalized();
    let off = (towards - at).dot(towards - at) * (STAR_GRID * STAR_GRID);
    // Magnitudes: ten times as many stars of a tenth of the light.
    let light = 0.035 / (draw(725) + 0.006);
    let warmth = draw(726);
    blend([0.75, 0.88, 1.25], [1.25, 0.95, 0.65], warmth)
        .map(|v| v * light * libm::exp(-off / 0.10))
}
