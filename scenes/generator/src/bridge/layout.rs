//! The bridge in numbers. Metres; x along the bridge, y above the water, z
//! across; the origin is the water under the middle of the main span.

/// Half the main span: the towers stand at plus and minus this x.
pub const TOWER_X: f64 = 640.0;
/// End of the side spans (343 m each).
pub const END_X: f64 = 983.0;
/// End of the approach viaducts.
pub const APPROACH_END_X: f64 = 1320.0;
/// Height of the towers, where the cables lie in their saddles.
pub const TOWER_TOP: f64 = 227.0;
/// Distance of the cables and trusses from the middle.
pub const CABLE_Z: f64 = 13.7;
/// Radius of a main cable.
pub const CABLE_RADIUS: f64 = 0.46;
/// Distance between suspenders.
pub const SUSPENDER_STEP: f64 = 15.24;
/// Length of a panel of the truss: half a suspender step.
pub const PANEL: f64 = 7.62;
/// Depth of the stiffening truss.
pub const TRUSS_DEPTH: f64 = 7.6;
/// Half the width of the roadway slab.
pub const ROAD_HALF_WIDTH: f64 = 13.4;

/// Height of the roadway: a parabola over the main span, straight beyond.
#[must_use]
pub fn road_height(x: f64) -> f64 {
    let a = x.abs();
    if a <= TOWER_X {
        let s = a / TOWER_X;
        76.0 - 5.0 * s * s
    } else {
        71.0 - (a - TOWER_X) * (10.0 / TOWER_X)
    }
}

/// Height of the cable: the parabola of a cable under an even load, with 143 m
/// of sag in the main span and a tenth of it, by the square of the lengths, in
/// the side spans.
#[must_use]
pub fn cable_height(x: f64) -> f64 {
    let a = x.abs();
    let sag = 143.0;
    if a <= TOWER_X {
        let s = a / TOWER_X;
        TOWER_TOP - sag + sag * s * s
    } else {
        let length = END_X - TOWER_X;
        let s = ((a - TOWER_X) / length).min(1.0);
        let foot = road_height(END_X) + 2.6;
        let side_sag = sag * (length / (2.0 * TOWER_X)) * (length / (2.0 * TOWER_X));
        TOWER_TOP + (foot - TOWER_TOP) * s - 4.0 * side_sag * s * (1.0 - s)
    }
}
