//! Ranges of the water.

use super::super::at::At;
use super::super::range::{COORDINATE, LENGTH, Range, SHARE, TURN, VELOCITY_MPS, number, numbers};
use super::super::{SceneError, Water};

/// Fastest wind in metres per second: twice the worst storm. Calm is a light
/// breeze; the spectrum has no waves at 0.
const WIND_MPS: Range = Range::Closed(0.1, 200.0);
/// Side of the water tile in metres: from a puddle to where one period spans
/// the sea that a camera sees.
const TILE_M: Range = Range::Closed(0.01, 1e6);

pub(super) fn water(at: &At<'_>, water: &Water) -> Result<(), SceneError> {
    let Water::Tessendorf(w) = water;
    number(&at.field("height_m"), w.height_m, COORDINATE, "m")?;
    if !(16..=2048).contains(&w.grid) || !w.grid.is_power_of_two() {
        return Err(at
            .field("grid")
            .error(format!("{}: expected a power of two, 16 to 2048", w.grid)));
    }
    number(&at.field("tile_m"), w.tile_m, TILE_M, "m")?;
    number(
        &at.field("wind_speed_mps"),
        w.wind_speed_mps,
        WIND_MPS,
        "m/s",
    )?;
    let wind_at = at.field("wind_direction_deg");
    number(&wind_at, w.wind_direction_deg, TURN, "degrees")?;
    number(
        &at.field("amplitude"),
        w.amplitude,
        Range::Closed(0.0, 10.0),
        "",
    )?;
    number(&at.field("cutoff_m"), w.cutoff_m, LENGTH, "m")?;
    numbers(&at.field("body_color"), &w.body_color, SHARE, "")?;
    number(&at.field("ior"), w.ior, Range::Closed(1.0, 4.0), "")?;
    number(&at.field("roughness"), w.roughness, SHARE, "")?;
    numbers(
        &at.field("velocity_mps"),
        &w.velocity_mps,
        VELOCITY_MPS,
        "m/s",
    )?;
    number(&at.field("time_s"), w.time_s, Range::Closed(-1e6, 1e6), "s")
}
