//! Paint of wing, tailplane and fin, by place on the skin.

use super::font;
use super::paint::{
    ALUMINIUM, CREAM, Colour, NAVY, ORANGE, RUBBER, SEAM, band, cover, over, round_rect, seam,
};
use crate::curve::smoothstep;
use crate::noise::fbm;
use crate::plane::shape::{ENGINE_X, FIN_SPAN, fin_chord, tailplane_chord, wing_chord};

/// Size of a texel of these skins, metres.
const TEXEL: f64 = 0.0087;

/// Paint of the wing at (x, z), from above or from below.
#[must_use]
pub(super) fn wing(x: f64, z: f64, upper: bool) -> Colour {
    let a = x.abs();
    let chord = wing_chord(x.clamp(-8.79, 8.79));
    let part = (z - chord.front) / chord.length.max(0.05);
    let mut colour = ALUMINIUM;
    colour = over(colour, ORANGE, cover(7.55 - a, TEXEL));
    colour = over(colour, NAVY, band(a, 7.38, 7.50, TEXEL));
    colour = registration(colour, x, z, upper);
    // Spars and ribs.
    for spar in [0.16, 0.38, 0.66] {
        colour = over(
            colour,
            SEAM,
            0.45 * seam((part - spar) * chord.length, 0.0, 0.005, TEXEL),
        );
    }
    for rib in [1.25, 1.85, 3.05, 3.9, 4.75, 5.6, 6.45, 7.3] {
        colour = over(colour, SEAM, 0.40 * seam(a, rib, 0.005, TEXEL));
    }
    // Flap inboard, aileron outboard, with real gaps.
    let hinge = (part - 0.76) * chord.length;
    if (1.0..7.75).contains(&a) {
        colour = over(colour, RUBBER, 0.9 * seam(hinge, 0.0, 0.012, TEXEL));
    }
    if part > 0.76 {
        for end in [1.0, 4.4, 4.47, 7.75] {
            colour = over(colour, RUBBER, 0.9 * seam(a, end, 0.012, TEXEL));
        }
    }
    // Walkway at the root, fuel cap, landing lights.
    if upper {
        let walk = round_rect((a, z), (1.15, 0.35), (0.22, 0.95), 0.04);
        colour = over(colour, RUBBER, 0.75 * cover(walk, TEXEL));
        for cap in [3.4, 5.1] {
            let (dx, dz) = (a - cap, z - chord.front - 0.45);
            let ring = ((dx * dx + dz * dz).sqrt() - 0.075).abs() - 0.006;
            colour = over(colour, SEAM, 0.8 * cover(ring, TEXEL));
        }
    }
    if a > ENGINE_X + 0.9 && a < 7.6 {
        colour = over(colour, RUBBER, cover((part - 0.055) * chord.length, TEXEL));
    }
    soot(dirt(colour, x, z), a, part, upper)
}

/// Registration on the right wing above and the left wing below.
fn registration(colour: Colour, x: f64, z: f64, upper: bool) -> Colour {
    let text = "N42SW";
    let (from, width) = (3.75, 3.1);
    let unit = width / font::text_width(text);
    // Above: the letters' heads point forward, seen from behind left to right.
    let (along, up) = if upper {
        (x - from, 0.78 - z)
    } else {
        (-x - from, 0.78 - z)
    };
    // The letters keep their width and grow a little taller.
    let distance = font::distance(text, along / unit, up / (unit * 1.1)) - 0.55;
    over(colour, NAVY, cover(distance * unit, TEXEL))
}

fn dirt(colour: Colour, x: f64, z: f64) -> Colour {
    let panel = fbm(
        (x / 0.85).floor() * 7.7,
        (z / 0.9).floor() * 3.3,
        0.5,
        1,
        0.5,
        23,
    );
    let streak = fbm(x * 3.0, z * 0.5, 1.0, 3, 0.5, 71);
    let amount = 0.03 + 0.05 * panel + 0.06 * streak.max(0.0);
    over(colour, [96.0, 90.0, 84.0], amount.clamp(0.0, 0.2))
}

/// Exhaust stain behind the engines.
fn soot(colour: Colour, a: f64, part: f64, upper: bool) -> Colour {
    let off = (a - ENGINE_X).abs();
    let trail = (1.0 - smoothstep(0.25, 0.75, off)) * smoothstep(0.3, 0.8, part);
    let most = if upper { 0.22 } else { 0.45 };
    over(colour, [50.0, 46.0, 42.0], most * trail)
}

/// Paint of the tailplane at (x, z).
#[must_use]
pub(super) fn tailplane(x: f64, z: f64) -> Colour {
    let a = x.abs();
    let chord = tailplane_chord(x.clamp(-2.99, 2.99));
    let part = (z - chord.front) / chord.length.max(0.05);
    let mut colour = over(ALUMINIUM, ORANGE, cover(2.55 - a, TEXEL));
    colour = over(colour, NAVY, band(a, 2.43, 2.50, TEXEL));
    colour = over(
        colour,
        RUBBER,
        0.9 * seam((part - 0.60) * chord.length, 0.0, 0.012, TEXEL),
    );
    for rib in [0.7, 1.3, 1.9] {
        colour = over(colour, SEAM, 0.4 * seam(a, rib, 0.005, TEXEL));
    }
    colour = over(colour, RUBBER, cover((part - 0.06) * chord.length, TEXEL));
    dirt(colour, x + 20.0, z)
}

/// Paint of the fin at (z, y): cream, navy head, the bird in an orange sun.
#[must_use]
pub(super) fn fin(z: f64, y: f64) -> Colour {
    let chord = fin_chord(y.clamp(FIN_SPAN.0, FIN_SPAN.1 - 0.01));
    let part = (z - chord.front) / chord.length.max(0.05);
    // Stripes lean with the leading edge.
    let lean = y - 0.18 * (z - 6.5);
    let mut colour = over(CREAM, NAVY, cover(2.12 - lean, TEXEL));
    colour = over(colour, ORANGE, band(lean, 2.03, 2.08, TEXEL));
    colour = emblem(colour, z - 6.62, y - 1.52);
    colour = over(
        colour,
        RUBBER,
        0.9 * seam((part - 0.60) * chord.length, 0.0, 0.012, TEXEL),
    );
    for rib in [0.95, 1.95] {
        colour = over(colour, SEAM, 0.35 * seam(y, rib, 0.005, TEXEL));
    }
    colour = over(colour, RUBBER, cover((part - 0.05) * chord.length, TEXEL));
    dirt(colour, y + 40.0, z)
}

/// A shearwater over the sun: two long wings drawn as tapering strokes.
fn emblem(colour: Colour, z: f64, y: f64) -> Colour {
    let radius = (z * z + y * y).sqrt();
    let colour = over(colour, ORANGE, cover(radius - 0.40, TEXEL));
    let wing: [(f64, f64); 5] = [
        (-0.52, 0.17),
        (-0.26, 0.20),
        (0.0, 0.02),
        (0.26, -0.08),
        (0.54, -0.20),
    ];
    let mut nearest = 1e3;
    for pair in wing.windows(2) {
        let reach = font::to_segment((z, y), pair[0], pair[1]);
        // Thick at the body, pointed at the tips.
        nearest = f64::min(
            nearest,
            reach - 0.065 * (1.0 - (z / 0.56) * (z / 0.56)).max(0.0),
        );
    }
    let body = font::to_segment((z, y), (-0.13, -0.07), (0.12, 0.08)) - 0.055;
    over(colour, NAVY, cover(nearest.min(body), TEXEL))
}
