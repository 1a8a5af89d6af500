//! Exposure and view: from linear light to display code values.
//!
//! No dithering: the step from code values to integers is plain rounding, so a
//! pixel depends on nothing but its own value.

use rayon::prelude::*;

use super::agx::Agx;
use super::octave_table::OctaveTable;
use super::settings::View;

/// Exposed light is cut here, far above every white point and far below any
/// overflow; so +inf shows as white.
const EXPOSED_MAX: f64 = 1e30;

/// Display code values, each in [0, 1], of linear Rec. 709 pixels brightened by
/// `exposure_ev` stops.
///
/// Total: NaN, -inf and negative values count as 0 (no light), +inf as very
/// bright light. An `exposure_ev` of NaN shows black.
#[must_use]
pub fn apply_view(linear: &[[f32; 3]], exposure_ev: f32, view: View) -> Vec<[f32; 3]> {
    let gain = libm::exp2(f64::from(exposure_ev));
    match view {
        View::Standard => {
            let srgb = Srgb::new();
            map_pixels(linear, gain, |rgb| rgb.map(|value| srgb.code(value)))
        }
        View::Agx => {
            let agx = Agx::new();
            map_pixels(linear, gain, |rgb| agx.codes(rgb))
        }
    }
}

fn map_pixels(
    linear: &[[f32; 3]],
    gain: f64,
    codes: impl Fn([f64; 3]) -> [f64; 3] + Sync,
) -> Vec<[f32; 3]> {
    linear
        .par_iter()
        .map(|pixel| codes(pixel.map(|value| expose(value, gain))).map(|code| code as f32))
        .collect()
}

/// `value * gain` in [0, `EXPOSED_MAX`], with +0 for whatever is not above 0.
fn expose(value: f32, gain: f64) -> f64 {
    let exposed = f64::from(value) * gain;
    if exposed > 0.0 {
        exposed.min(EXPOSED_MAX)
    } else {
        0.0
    }
}

/// The sRGB curve (IEC 61966-2-1, equations 8 to 10).
struct Srgb {
    /// The power part, over light in units of `TABLE_FROM`.
    power: OctaveTable,
}

impl Srgb {
    /// Below this value the curve is a straight line.
    const LINE_END: f64 = 0.003_130_8;
    /// A power of two below the end of the line, 2^-9.
    const TABLE_FROM: f64 = 1.0 / 512.0;

    fn new() -> Self {
        let power = |light| 1.055 * libm::pow(light * Self::TABLE_FROM, 1.0 / 2.4) - 0.055;
        Self {
            power: OctaveTable::new(9, power),
        }
    }

    /// The code value, in [0, 1], of linear light of at least 0.
    fn code(&self, linear: f64) -> f64 {
        if linear <= Self::LINE_END {
            12.92 * linear
        } else {
            // The table ends at 1.
            self.power.at((linear / Self::TABLE_FROM) as f32)
        }
    }
}
