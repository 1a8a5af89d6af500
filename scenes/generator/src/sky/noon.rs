//! Noon: a blue sky with fair-weather clouds.

use super::dome::{Radiance, add, blend};
use super::{clouds, direction};
use crate::curve::smoothstep;
use crate::noise::fbm;
use crate::vec3::Vec3;

/// Where the sun stands: bearing and height in degrees. The picture has its
/// aureole, not its disc.
const SUN_DEG: (f64, f64) = (35.0, 48.0);

/// Radiance from a direction, in the proportions of a clear day: zenith 0.5, pale
/// horizon 1.1, a cloud in the sun 2.4, its base 0.8.
#[must_use]
pub fn radiance(towards: Vec3) -> Radiance {
    let to_sun = direction(SUN_DEG.0, SUN_DEG.1);
    let up = towards.y.max(0.0);
    let cos_sun = towards.dot(to_sun).clamp(-1.0, 1.0);
    let away = libm::acos(cos_sun);
    let mut sky = blend(
        [0.15, 0.35, 0.95],
        [0.80, 1.00, 1.25],
        libm::exp(-up / 0.22),
    );
    sky = add(sky, [1.0, 0.98, 0.92], 0.55 * libm::exp(-away / 0.30));
    sky = add(sky, [1.0, 0.97, 0.90], 2.2 * libm::exp(-away / 0.07));
    if towards.y < 0.0 {
        let fade = libm::exp(towards.y / 0.08);
        return blend([0.10, 0.15, 0.20], sky, fade);
    }
    let veil = clouds::cirrus(towards);
    let sky = blend(sky, [1.35, 1.40, 1.50], 0.45 * veil.opacity);

    let reach = 1.0 / (up + 0.06);
    let (x, z) = (towards.x * reach, towards.z * reach);
    let here = heap(x, z);
    // Less cloud towards the sun means a lit side here.
    let there = heap(x + 0.16 * to_sun.x, z + 0.16 * to_sun.z);
    let lit = smoothstep(-0.25, 0.35, here - there + 0.12);
    let edge = 1.0 - smoothstep(0.0, 0.6, here);
    let cloud = blend(
        [0.72, 0.80, 0.95],
        [2.35, 2.30, 2.20],
        0.75 * lit + 0.25 * edge,
    );
    let silver = add(cloud, [1.6, 1.55, 1.4], edge * libm::exp(-away / 0.35));
    let haze = libm::exp(-up / 0.07);
    let cover = smoothstep(0.02, 0.30, here) * smoothstep(0.012, 0.09, up);
    blend(sky, blend(silver, sky, 0.6 * haze), 0.96 * cover)
}

// Thickness of the heaped clouds over a flat layer.
fn heap(x: f64, z: f64) -> f64 {
    let field = fbm(x * 0.23, z * 0.23, 3.0, 3, 0.5, 501);
    let warp = fbm(x * 0.8, z * 0.8, 9.0, 3, 0.5, 502);
    let cells = fbm(
        x * 0.62 + 0.5 * warp,
        z * 0.62 - 0.5 * warp,
        1.0,
        6,
        0.55,
        503,
    );
    smoothstep(0.08, 0.62, cells + 0.9 * field)
}
