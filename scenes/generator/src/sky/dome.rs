//! The clear sky of the sunset, as radiance by direction.

use crate::curve::{mix, smoothstep};
use crate::vec3::Vec3;

/// Linear Rec. 709 radiance.
pub(super) type Radiance = [f64; 3];

/// Sum of `base` and `amount` times `colour`.
#[must_use]
pub(super) fn add(base: Radiance, colour: Radiance, amount: f64) -> Radiance {
    std::array::from_fn(|i| base[i] + colour[i] * amount)
}

/// `a` and `b` mixed.
#[must_use]
pub(super) fn blend(a: Radiance, b: Radiance, amount: f64) -> Radiance {
    std::array::from_fn(|i| mix(a[i], b[i], amount))
}

/// Radiance of the cloudless sky above the horizon.
///
/// Three bands whose heights differ (horizon glow, orange, violet) over a blue
/// zenith, the first two fading with the distance from the sun's bearing, and
/// two lobes around the sun itself. The numbers are a painter's, kept in the
/// proportions of a clear sky with the sun five degrees up: zenith 0.2, far
/// horizon 0.5, horizon below the sun 3.
#[must_use]
pub(super) fn clear(direction: Vec3, to_sun: Vec3) -> Radiance {
    let up = direction.y.max(0.0);
    let flat = |v: Vec3| {
        let length = (v.x * v.x + v.z * v.z).sqrt().max(1e-6);
        (v.x / length, v.z / length)
    };
    let ((dx, dz), (sx, sz)) = (flat(direction), flat(to_sun));
    // 1 below the sun, 0 opposite; the bearing means less near the zenith.
    let facing = 0.5 + 0.5 * (dx * sx + dz * sz) * (1.0 - smoothstep(0.5, 1.0, up));
    let warm = facing * facing * facing;
    let cos_sun = direction.dot(to_sun).clamp(-1.0, 1.0);
    let away = libm::acos(cos_sun);

    let zenith = blend([0.070, 0.090, 0.280], [0.080, 0.085, 0.270], facing);
    // The blue drowns in the dust above the sun's horizon.
    let dust = 0.85 * warm * libm::exp(-up / 0.16);
    let mut sky = zenith.map(|v| v * (1.0 - dust));
    let violet = blend([0.30, 0.17, 0.40], [0.46, 0.085, 0.24], warm);
    let lift = (up - 0.19) / 0.165;
    sky = add(sky, violet, libm::exp(-lift * lift));
    let orange = blend([0.40, 0.19, 0.21], [2.25, 0.47, 0.015], warm);
    sky = add(sky, orange, libm::exp(-up / 0.105));
    let glow = blend([0.02, 0.02, 0.05], [1.20, 0.42, 0.03], warm * facing);
    sky = add(sky, glow, libm::exp(-up / 0.035));
    // Aureole: a wide and a narrow lobe.
    sky = add(sky, [1.30, 0.36, 0.01], libm::exp(-away / 0.27));
    sky = add(sky, [2.60, 1.30, 0.30], libm::exp(-away / 0.065));
    // Opposite the sun the earth's shadow lies blue under a rosy belt.
    let opposite = (1.0 - facing) * (1.0 - facing);
    let belt = (up - 0.16) / 0.085;
    sky = add(
        sky,
        [0.16, 0.055, 0.075],
        opposite * libm::exp(-belt * belt),
    );
    let shadow = opposite * (1.0 - smoothstep(0.02, 0.13, up));
    let cool = [0.72, 0.82, 1.0];
    std::array::from_fn(|i| sky[i] * mix(1.0, cool[i] * 0.85, shadow))
}

/// Radiance below the horizon: the haze, darker with depth.
#[must_use]
pub(super) fn below(direction: Vec3, to_sun: Vec3) -> Radiance {
    let level = Vec3 {
        y: 0.0,
        ..direction
    }
    .normalized();
    let haze = clear(level, to_sun);
    let depth = (-direction.y).clamp(0.0, 1.0);
    let fade = mix(0.10, 1.0, libm::exp(-depth / 0.06));
    let deep = [0.030, 0.042, 0.060];
    std::array::from_fn(|i| mix(deep[i], haze[i], fade) * mix(0.7, 1.0, fade))
}
