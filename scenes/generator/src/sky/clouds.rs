//! High clouds: streaks of cirrus and flocks of altocumulus on two layers of
//! a flat sky, lit from below the horizon's edge by the low sun.

use crate::curve::{mix, smoothstep};
use crate::noise::fbm;
use crate::vec3::{Vec3, vec3};

/// What a layer does to the sky behind it.
pub(super) struct Veil {
    /// Opacity in [0, 1].
    pub opacity: f64,
    /// How much of the sun's side shines through, in [0, 1].
    pub lit: f64,
}

/// Place where the direction meets a layer at unit height; the bent
/// denominator keeps the layer's scale finite at the horizon.
fn on_layer(direction: Vec3, bend: f64) -> (f64, f64) {
    let reach = 1.0 / (direction.y.max(0.0) + bend);
    (direction.x * reach, direction.z * reach)
}

/// Cirrus: noise drawn out along the wind, torn by a slower one.
#[must_use]
pub(super) fn cirrus(direction: Vec3) -> Veil {
    let (x, z) = on_layer(direction, 0.10);
    // The wind blows along a bearing of about 60 degrees.
    let (along, across) = (0.87 * x + 0.5 * z, -0.5 * x + 0.87 * z);
    let curl = fbm(along * 0.35, across * 0.35, 7.0, 3, 0.5, 301);
    let tear = fbm(along * 0.9 + curl, across * 0.9, 11.0, 3, 0.5, 302);
    let fibres = fbm(
        along * 0.55 + 0.8 * curl,
        across * 3.4 + 2.2 * curl + 0.5 * tear,
        2.0,
        5,
        0.56,
        303,
    );
    let field = fbm(along * 0.22, across * 0.30, 5.0, 3, 0.5, 304);
    let density = smoothstep(-0.04, 0.42, fibres + 0.55 * field + 0.05);
    let height = smoothstep(0.015, 0.14, direction.y);
    Veil {
        opacity: 0.62 * density * height,
        lit: 1.0 - 0.5 * density,
    }
}

/// Altocumulus: rounded cells in a few fields of the lower sky.
#[must_use]
pub(super) fn altocumulus(direction: Vec3, to_sun: Vec3) -> Veil {
    let (x, z) = on_layer(direction, 0.045);
    let here = density(x, z);
    if here <= 0.0 {
        return Veil {
            opacity: 0.0,
            lit: 0.0,
        };
    }
    // A second look towards the sun: thin there means a lit edge here.
    let flat = vec3(to_sun.x, 0.0, to_sun.z).normalized();
    let there = density(x + 0.10 * flat.x, z + 0.10 * flat.z);
    let lit = libm::exp(-1.5 * there) * mix(1.0, 0.55, here);
    let height =
        smoothstep(0.02, 0.07, direction.y) * (1.0 - 0.65 * smoothstep(0.34, 0.70, direction.y));
    Veil {
        opacity: (0.92 * smoothstep(0.0, 0.45, here) * height).clamp(0.0, 1.0),
        lit,
    }
}

fn density(x: f64, z: f64) -> f64 {
    let field = fbm(x * 0.16, z * 0.22, 21.0, 3, 0.5, 401);
    let warp_x = fbm(x * 0.7, z * 0.7, 31.0, 2, 0.5, 402);
    let warp_z = fbm(x * 0.7, z * 0.7, 41.0, 2, 0.5, 403);
    let cells = fbm(
        x * 1.05 + 0.6 * warp_x,
        z * 1.5 + 0.6 * warp_z,
        51.0,
        5,
        0.52,
        404,
    );
    smoothstep(0.10, 0.55, cells + 1.05 * field + 0.03)
}
