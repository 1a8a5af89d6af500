//! Paint of the fuselage and of the nacelles, by place on the skin.

use super::font;
use super::paint::{
    ALUMINIUM, CREAM, Colour, NAVY, ORANGE, RUBBER, SEAM, band, cover, over, round_rect, seam,
};
use crate::curve::{mix, pchip, smoothstep};
use crate::noise::fbm;
use crate::plane::shape::{CABIN_WINDOWS, FUSELAGE, NACELLE, angle_of_turn, cabin_pane};

/// Size of a texel on the fuselage, metres.
const TEXEL: f64 = 0.006;

/// Stations of the fuselage's ring seams.
const FRAMES: [f64; 13] = [
    0.42, 0.95, 1.62, 2.95, 3.25, 4.36, 5.47, 6.58, 7.45, 8.25, 9.15, 10.15, 11.2,
];

/// Middle of the cheat line against station: it sweeps up to the fin.
const CHEAT: [(f64, f64); 8] = [
    (0.0, -0.17),
    (1.0, -0.10),
    (2.2, 0.02),
    (3.4, 0.05),
    (7.6, 0.05),
    (9.4, 0.16),
    (11.0, 0.36),
    (12.2, 0.52),
];

/// Paint of the fuselage at a station and turn.
#[must_use]
pub(super) fn fuselage(t: f64, turn: f64) -> Colour {
    let angle = angle_of_turn(turn.clamp(0.0, 1.0));
    let p = FUSELAGE.point(t.clamp(0.0, 12.2), angle);
    let right = turn < 0.5;
    let line = p.y - pchip(&CHEAT, t);
    // Cream above the line, aluminium below it.
    let mut colour = over(ALUMINIUM, CREAM, cover(-line - 0.10, TEXEL));
    let width =
        mix(0.06, 0.135, smoothstep(0.0, 2.5, t)) * mix(1.0, 0.75, smoothstep(9.5, 12.0, t));
    colour = over(colour, NAVY, band(line, -width, width, TEXEL));
    colour = over(
        colour,
        ORANGE,
        band(line, -width - 0.075, -width - 0.030, TEXEL),
    );
    colour = over(
        colour,
        ORANGE,
        band(line, width + 0.030, width + 0.050, TEXEL),
    );
    colour = titles(colour, t, angle, right);
    colour = anti_glare(colour, t, angle);
    colour = seams(colour, t, p.x, p.y, line, right);
    windows(dirt(colour, t, p.y, angle), t, angle)
}

/// Name over the windows, registration before the tail.
fn titles(colour: Colour, t: f64, angle: f64, right: bool) -> Colour {
    // Read from outside: the right side runs from tail to nose in t. Letters
    // stand on an angle of the skin and climb along it, so they do not stretch.
    let degrees = angle.to_degrees();
    let side = if right { degrees } else { 180.0 - degrees };
    let text = |colour: Colour, text: &str, span: (f64, f64), foot: f64, metres: f64| {
        let unit = (span.1 - span.0) / font::text_width(text);
        let x = if right { span.1 - t } else { t - span.0 } / unit;
        let y = (side - foot) * metres / unit;
        let distance = font::distance(text, x, y) - 0.55;
        over(colour, NAVY, cover(distance * unit, TEXEL))
    };
    let colour = text(colour, "SHEARWATER", (4.45, 6.70), 40.5, 0.0150);
    text(colour, "N42SW", (8.74, 9.84), 19.0, 0.0096)
}

/// Dull black before the windscreen.
fn anti_glare(colour: Colour, t: f64, angle: f64) -> Colour {
    let from_top = (angle.to_degrees() - 90.0).abs();
    let shape = (from_top - mix(24.0, 36.0, smoothstep(0.3, 1.8, t))) * 0.010;
    let reach = (0.30 - t).max(t - 1.80);
    over(colour, RUBBER, 0.92 * cover(shape.max(reach), TEXEL * 1.5))
}

fn seams(mut colour: Colour, t: f64, x: f64, y: f64, line: f64, right: bool) -> Colour {
    for frame in FRAMES {
        colour = over(colour, SEAM, 0.55 * seam(t, frame, 0.004, TEXEL));
    }
    if (1.0..11.3).contains(&t) {
        for height in [0.62, -0.34, -0.62] {
            colour = over(colour, SEAM, 0.45 * seam(y, height, 0.004, TEXEL));
        }
        colour = over(colour, SEAM, 0.35 * seam(line, -0.215, 0.004, TEXEL));
    }
    if !right {
        // The door behind the wing, with its handle.
        let door = round_rect((t, y), (7.98, 0.02), (0.36, 0.66), 0.10).abs() - 0.004;
        colour = over(colour, SEAM, 0.85 * cover(door, TEXEL));
        let handle = round_rect((t, y), (7.74, -0.02), (0.07, 0.02), 0.02);
        colour = over(colour, RUBBER, cover(handle, TEXEL));
    }
    if t < 1.0 && x.abs() < 0.5 {
        // Baggage lid in the nose.
        let lid = round_rect((t, x), (0.70, 0.0), (0.2, 0.28), 0.05).abs() - 0.003;
        colour = over(colour, SEAM, 0.5 * cover(lid, TEXEL));
    }
    colour
}

/// Dark rubber around the panes: the skin shows there in the gaps.
fn windows(mut colour: Colour, t: f64, angle: f64) -> Colour {
    let degrees = angle.to_degrees();
    let side = if degrees > 90.0 {
        180.0 - degrees
    } else {
        degrees
    };
    for i in 0..CABIN_WINDOWS {
        let pane = cabin_pane(i);
        let middle = (0.5 * (pane[0].0 + pane[1].0), 0.5 * (pane[0].1 + pane[2].1));
        let half = (0.5 * (pane[1].0 - pane[0].0), 0.5 * (pane[2].1 - pane[0].1));
        // One degree is about 14 mm of skin.
        let p = (t - middle.0, (side - middle.1) * 0.014);
        let gap = round_rect(
            p,
            (0.0, 0.0),
            (half.0 + 0.035, half.1 * 0.014 + 0.035),
            0.11,
        );
        colour = over(colour, RUBBER, 0.8 * cover(gap, TEXEL));
    }
    colour
}

/// Streaks and soot: a few per cent, along the airflow.
fn dirt(colour: Colour, t: f64, y: f64, angle: f64) -> Colour {
    let streak = fbm(t * 0.7, angle * 4.0, 3.0, 3, 0.5, 91);
    let patch = fbm(t * 0.9, angle * 1.3, 9.0, 3, 0.5, 17);
    let belly = smoothstep(0.1, -0.8, y);
    let amount = 0.05 * (streak + 0.2).max(0.0) + 0.05 * (patch + 0.1).max(0.0) + 0.10 * belly;
    over(colour, [92.0, 84.0, 74.0], amount.clamp(0.0, 0.3))
}

/// Paint of a nacelle or its cowling at a station and turn.
#[must_use]
pub(super) fn nacelle(s: f64, turn: f64) -> Colour {
    let texel = 0.012;
    let angle = angle_of_turn(turn.clamp(0.0, 1.0));
    let p = NACELLE.point(s.max(0.7), angle);
    let mut colour = over(ALUMINIUM, CREAM, cover(s - 0.70, texel));
    colour = over(colour, NAVY, band(s, -0.1, 0.34, texel));
    colour = over(colour, ORANGE, band(s, 0.37, 0.42, texel));
    for ring in [0.70, 1.30, 2.1, 3.0, 3.8] {
        colour = over(colour, SEAM, 0.5 * seam(s, ring, 0.006, texel));
    }
    // Cowl flaps: short seams around the gills.
    if (0.70..0.98).contains(&s) {
        let flap = (turn * 24.0 - (turn * 24.0).floor() - 0.5).abs() / 24.0 * 4.0;
        colour = over(colour, SEAM, 0.6 * cover(flap - 0.006, texel));
    }
    // Wheel doors below.
    if (1.5..2.8).contains(&s) && p.y < -0.3 {
        colour = over(colour, SEAM, 0.6 * seam(p.x.abs(), 0.30, 0.008, texel));
    }
    // Soot from the stacks.
    let low =
        smoothstep(0.0, -0.6, p.y) * smoothstep(0.9, 1.6, s) * smoothstep(0.15, 0.45, p.x.abs());
    let streak = 0.5 + 0.5 * fbm(s * 0.6, angle * 5.0, 5.0, 3, 0.5, 41);
    over(
        colour,
        [54.0, 48.0, 44.0],
        (0.55 * low * streak).clamp(0.0, 0.5),
    )
}
