//! The livery texture: every texel asks the paint of the place of the skin
//! that it covers, so seams of the layout do not show.

pub mod font;
mod fuselage;
mod paint;
mod surfaces;

use crate::plane::atlas::{
    FIN_LEFT, FIN_RIGHT, FUSELAGE, Island, NACELLE, SIZE, TAIL_LOWER, TAIL_UPPER, WING_LOWER,
    WING_UPPER,
};
use paint::{CREAM, Colour};

/// Texels painted beyond an island's edge, for the filter's sake.
const BLEED: f64 = 5.0;

/// Colour of a place of a skin, by its two coordinates.
type Painter = fn(f64, f64) -> Colour;

/// The texture's bytes: RGB, row by row, sRGB.
#[must_use]
pub fn pixels() -> Vec<u8> {
    let side = SIZE as usize;
    let base = CREAM.map(byte);
    let mut out: Vec<u8> = base.iter().copied().cycle().take(side * side * 3).collect();
    let islands: [(Island, Painter); 8] = [
        (FUSELAGE, fuselage::fuselage),
        (WING_UPPER, |x, z| surfaces::wing(x, z, true)),
        (WING_LOWER, |x, z| surfaces::wing(x, z, false)),
        (TAIL_UPPER, surfaces::tailplane),
        (TAIL_LOWER, surfaces::tailplane),
        (FIN_RIGHT, surfaces::fin),
        (FIN_LEFT, surfaces::fin),
        (NACELLE, fuselage::nacelle),
    ];
    for (island, colour_at) in islands {
        fill(&mut out, side, island, colour_at);
    }
    out
}

fn fill(out: &mut [u8], side: usize, island: Island, colour_at: Painter) {
    let [x, y, w, h] = island.pixels;
    let range = |from: f64, size: f64| {
        let low = (from - BLEED).max(0.0) as usize;
        low..((from + size + BLEED) as usize).min(side)
    };
    for row in range(y, h) {
        for column in range(x, w) {
            let (a, b) = island.skin(column as f64 + 0.5, row as f64 + 0.5);
            let at = (row * side + column) * 3;
            out[at..at + 3].copy_from_slice(&colour_at(a, b).map(byte));
        }
    }
}

fn byte(value: f64) -> u8 {
    (value + 0.5).clamp(0.0, 255.0) as u8
}
