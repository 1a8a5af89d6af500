//! The plane in numbers: what mesh and livery share.
//!
//! Metres; nose towards -z, y up, +x the right (starboard) wing; the origin is
//! the centre of mass, `NOSE_Z` behind the tip of the nose.

use crate::curve::{mix, pchip, signed_pow, smoothstep};
use crate::vec3::{Vec3, vec3};
use std::f64::consts::{FRAC_PI_2, TAU};

/// z of the tip of the nose.
pub const NOSE_Z: f64 = -4.35;
/// Length of the fuselage.
pub const LENGTH: f64 = 12.2;
/// Half the wing's span.
pub const SEMI_SPAN: f64 = 8.8;
/// Half the tailplane's span.
pub const TAIL_SEMI_SPAN: f64 = 3.0;
/// Distance of an engine's axis from the plane's middle.
pub const ENGINE_X: f64 = 2.45;
/// Height of the engines' axes.
pub const ENGINE_Y: f64 = -0.42;
/// z of the front lip of the cowlings.
pub const COWL_Z: f64 = -2.6;
/// z of the propellers' discs.
pub const PROPELLER_Z: f64 = COWL_Z - 0.24;
/// Length of a nacelle from the lip to its tail.
pub const NACELLE_LENGTH: f64 = 4.6;
/// Radius of a propeller.
pub const PROPELLER_RADIUS: f64 = 1.22;

/// A body of superelliptic sections along z.
pub struct Body {
    /// Half width against station.
    pub width: &'static [(f64, f64)],
    /// Top edge against station.
    pub top: &'static [(f64, f64)],
    /// Bottom edge against station.
    pub bottom: &'static [(f64, f64)],
    /// Exponent of the superellipse against station.
    pub exponent: &'static [(f64, f64)],
    /// Whether station 0 is a round nose (the curves then run over sqrt t).
    pub round_nose: bool,
    /// Station where the tail starts to round off, and its end.
    pub tail: (f64, f64),
}

impl Body {
    /// Point of the skin: station `t` in metres, `angle` in radians from +x
    /// over +y; z is the station itself.
    #[must_use]
    pub fn point(&self, t: f64, angle: f64) -> Vec3 {
        let at = if self.round_nose {
            t.max(0.0).sqrt()
        } else {
            t
        };
        let width = pchip(self.width, at);
        let (top, bottom) = (pchip(self.top, at), pchip(self.bottom, at));
        let power = 2.0 / pchip(self.exponent, at);
        let (from, end) = self.tail;
        let past = ((t - from) / (end - from)).clamp(0.0, 1.0);
        let rounding = (1.0 - past * past).max(0.0).sqrt();
        let middle = 0.5 * (top + bottom);
        let x = width * signed_pow(libm::cos(angle), power) * rounding;
        let y = 0.5 * (top - bottom) * signed_pow(libm::sin(angle), power) * rounding;
        vec3(x, middle + y, t)
    }

    /// Point `height` metres outside the skin.
    #[must_use]
    pub fn offset_point(&self, t: f64, angle: f64, height: f64) -> Vec3 {
        let step = 1e-3;
        let along = self.point(t + step, angle) - self.point(t - step, angle);
        let around = self.point(t, angle + step) - self.point(t, angle - step);
        self.point(t, angle) + around.cross(along).normalized() * height
    }
}

/// The fuselage. The knots are over sqrt(station).
pub const FUSELAGE: Body = Body {
    width: &[
        (0.0, 0.0),
        (0.39, 0.225),
        (0.63, 0.365),
        (0.95, 0.535),
        (1.18, 0.635),
        (1.32, 0.685),
        (1.5, 0.745),
        (1.64, 0.775),
        (1.9, 0.80),
        (2.4, 0.80),
        (2.65, 0.765),
        (2.92, 0.63),
        (3.16, 0.44),
        (3.36, 0.235),
        (3.45, 0.13),
        (3.493, 0.08),
    ],
    top: &[
        (0.0, -0.16),
        (0.39, 0.045),
        (0.63, 0.165),
        (0.95, 0.315),
        (1.18, 0.415),
        (1.30, 0.475),
        (1.35, 0.53),
        (1.47, 0.80),
        (1.53, 0.875),
        (1.64, 0.93),
        (1.9, 0.965),
        (2.4, 0.95),
        (2.65, 0.91),
        (2.92, 0.80),
        (3.16, 0.66),
        (3.36, 0.50),
        (3.493, 0.40),
    ],
    bottom: &[
        (0.0, -0.16),
        (0.39, -0.36),
        (0.63, -0.49),
        (0.95, -0.64),
        (1.18, -0.72),
        (1.5, -0.79),
        (1.9, -0.83),
        (2.4, -0.81),
        (2.65, -0.71),
        (2.92, -0.45),
        (3.16, -0.13),
        (3.36, 0.13),
        (3.493, 0.24),
    ],
    exponent: &[
        (0.0, 2.0),
        (1.0, 2.05),
        (1.6, 2.25),
        (2.4, 2.25),
        (3.0, 2.05),
        (3.493, 2.0),
    ],
    round_nose: true,
    tail: (11.85, LENGTH),
};

/// A nacelle behind its cowling; stations from the cowling's lip.
pub const NACELLE: Body = Body {
    width: &[
        (0.7, 0.55),
        (1.2, 0.60),
        (1.9, 0.60),
        (2.5, 0.56),
        (3.1, 0.47),
        (3.7, 0.33),
        (4.2, 0.18),
        (4.6, 0.09),
    ],
    top: &[
        (0.7, 0.55),
        (1.2, 0.56),
        (1.7, 0.49),
        (2.3, 0.35),
        (3.0, 0.20),
        (3.7, 0.05),
        (4.6, -0.12),
    ],
    bottom: &[
        (0.7, -0.55),
        (1.2, -0.62),
        (1.9, -0.70),
        (2.5, -0.69),
        (3.1, -0.60),
        (3.7, -0.45),
        (4.2, -0.32),
        (4.6, -0.24),
    ],
    exponent: &[(0.7, 2.0), (1.4, 2.15), (2.6, 2.2), (4.6, 2.0)],
    round_nose: false,
    tail: (4.3, NACELLE_LENGTH),
};

/// Angle of the skin at `turn` in [0, 1]: from the bottom line over the right
/// side, the top and the left side back to the bottom.
#[must_use]
pub fn angle_of_turn(turn: f64) -> f64 {
    turn * TAU - FRAC_PI_2
}

/// Leading edge z and chord of a lifting surface at a place of its span.
#[derive(Clone, Copy, Debug)]
pub struct Chord {
    /// z of the leading edge.
    pub front: f64,
    /// Length of the chord.
    pub length: f64,
}

/// Rounds a tip: the chord shrinks elliptically about `pivot` of itself over
/// the last stretch `over` before `tip`.
fn rounded(chord: Chord, pivot: f64, place: f64, tip: f64, over: f64) -> Chord {
    let s = ((place - (tip - over)) / over).clamp(0.0, 1.0);
    let shrink = (1.0 - s * s).max(0.0).sqrt();
    Chord {
        front: chord.front + pivot * chord.length * (1.0 - shrink),
        length: chord.length * shrink,
    }
}

/// The wing's chord at distance |x| from the middle, fillet at the root included.
#[must_use]
pub fn wing_chord(x: f64) -> Chord {
    let a = x.abs();
    let outer = ((a - 2.4) / (SEMI_SPAN - 2.4)).max(0.0);
    let near = (a - 0.72) / 0.30;
    let fillet = libm::exp(-near * near);
    let front = mix(-1.0, -0.38, outer) - 0.10 * fillet;
    let back = mix(1.75, 0.86, outer) + 0.34 * fillet;
    rounded(
        Chord {
            front,
            length: back - front,
        },
        0.42,
        a,
        SEMI_SPAN,
        1.05,
    )
}

/// Height of the wing's chord line at distance |x|: flat between the engines,
/// six degrees of dihedral outside.
#[must_use]
pub fn wing_height(x: f64) -> f64 {
    let a = x.abs();
    // Integral of a smooth turn from 0 to tan 6 degrees about |x| = 2.4.
    let past = (a - 2.1).max(0.0);
    let bend = if past < 0.6 {
        past * past / 1.2
    } else {
        past - 0.3
    };
    -0.52 + 0.1051 * bend
}

/// The tailplane's chord at distance |x| from the middle.
#[must_use]
pub fn tailplane_chord(x: f64) -> Chord {
    let a = x.abs();
    let s = a / TAIL_SEMI_SPAN;
    let front = mix(5.55, 6.12, s);
    let back = mix(7.20, 7.06, s);
    rounded(
        Chord {
            front,
            length: back - front,
        },
        0.45,
        a,
        TAIL_SEMI_SPAN,
        0.6,
    )
}

/// Foot and tip of the fin.
pub const FIN_SPAN: (f64, f64) = (0.30, 2.62);

/// The fin's chord at height y; its foot runs forward into a dorsal fillet.
#[must_use]
pub fn fin_chord(y: f64) -> Chord {
    let s = (y - FIN_SPAN.0) / (FIN_SPAN.1 - FIN_SPAN.0);
    let dorsal = 1.0 - smoothstep(0.0, 0.42, s);
    let front = mix(5.15, 6.55, s) - 1.0 * dorsal * dorsal;
    let back = mix(7.78, 7.62, s) - 0.22 * (1.0 - smoothstep(0.0, 0.25, s));
    rounded(
        Chord {
            front,
            length: back - front,
        },
        0.55,
        y,
        FIN_SPAN.1,
        0.62,
    )
}

/// A window as a quadrilateral on the fuselage: (station, angle in degrees)
/// of its corners, forward-low, aft-low, aft-high, forward-high, for the right
/// side; the left side mirrors it.
pub type Pane = [(f64, f64); 4];

/// Front and side panes of the cockpit.
pub const COCKPIT_PANES: [Pane; 3] = [
    [(1.80, 88.2), (1.88, 54.0), (2.20, 58.0), (2.24, 88.0)],
    [(1.93, 49.5), (2.34, 33.0), (2.34, 54.0), (2.23, 55.5)],
    [(2.39, 32.0), (2.86, 27.0), (2.80, 51.5), (2.39, 53.8)],
];

/// Number of cabin windows on each side.
pub const CABIN_WINDOWS: usize = 6;

/// A cabin window of the right side.
#[must_use]
pub fn cabin_pane(index: usize) -> Pane {
    let t = 3.62 + 0.74 * index as f64;
    let (half, low, high) = (0.215, 7.5, 34.0);
    [
        (t - half, low),
        (t + half, low),
        (t + half, high),
        (t - half, high),
    ]
}
