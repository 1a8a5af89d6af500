//! Overcast: one grey layer, no sun.

use super::dome::{Radiance, blend};
use crate::curve::smoothstep;
use crate::noise::fbm;
use crate::vec3::Vec3;

/// Radiance from a direction: the CIE standard overcast sky, a third as bright at
/// the horizon as at the zenith (Moon and Spencer 1942), mottled by the layer's
/// lower side.
#[must_use]
pub fn radiance(towards: Vec3) -> Radiance {
    let up = towards.y.max(0.0);
    let standard = (1.0 + 2.0 * up) / 3.0;
    let reach = 1.0 / (up + 0.10);
    let (x, z) = (towards.x * reach, towards.z * reach);
    let warp = fbm(x * 0.5, z * 0.5, 5.0, 3, 0.5, 601);
    let rolls = fbm(
        x * 0.45 + 0.7 * warp,
        z * 0.8 - 0.4 * warp,
        2.0,
        5,
        0.55,
        602,
    );
    let wisps = fbm(x * 1.7 + warp, z * 1.9, 8.0, 4, 0.5, 603);
    // Far off the mottling runs together.
    let near = smoothstep(0.01, 0.25, up);
    let thin = 0.5 + 0.5 * (rolls * 1.3 + 0.35 * wisps).clamp(-1.0, 1.0);
    let level = standard * (1.0 + (0.45 + 0.35 * near) * (thin - 0.5));
    let tint = blend([0.84, 0.92, 1.06], [1.03, 1.0, 0.97], thin);
    let sky = tint.map(|v| 1.05 * v * level);
    if towards.y < 0.0 {
        return blend([0.10, 0.11, 0.12], sky, libm::exp(towards.y / 0.05));
    }
    sky
}
