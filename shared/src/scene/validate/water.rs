//! Ranges of the water.

use super::super::at::At;
use super::super::range::{
    COORDINATE, LENGTH, Range, SHARE, TURN, VELOCITY_MPS, count, number, numbers,
};
use super::super::{SceneError, Water, Whitecaps};

/// Fastest wind in metres per second: twice the worst storm. Calm is a light
/// breeze; the spectrum has no waves at 0.
const WIND_MPS: Range = Range::Closed(0.1, 200.0);
/// Side of the water tile in metres: from a puddle to where one period spans
/// the sea that a camera sees.
const TILE_M: Range = Range::Closed(0.01, 1e6);
/// When the waves are looked at, in seconds: eleven days around 0.
const TIME_S: Range = Range::Closed(-1e6, 1e6);
/// After how many seconds the waves are back: from one frame of the fastest camera
/// to as long as time may run.
const LOOP_S: Range = Range::Closed(1e-3, 1e6);
/// Height fields of one frame: each costs the memory and the time of one.
const SHUTTER_FIELDS_MAX: u64 = 4;
/// How far waves may fold: beyond a hundred times over it is all foam.
const FOLD_MAX: f64 = 100.0;

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
    number(&at.field("time_s"), w.time_s, TIME_S, "s")?;
    if let Some(loop_s) = w.loop_s {
        number(&at.field("loop_s"), loop_s, LOOP_S, "s")?;
    }
    let fields_at = at.field("shutter_fields");
    let fields = u64::from(w.shutter_fields);
    count(&fields_at, fields, 1, SHUTTER_FIELDS_MAX)?;
    match &w.whitecaps {
        Some(caps) => whitecaps(&at.field("whitecaps"), caps),
        None => Ok(()),
    }
}

fn whitecaps(at: &At<'_>, caps: &Whitecaps) -> Result<(), SceneError> {
    let (factor, fold) = (
        Range::Closed(0.0, FOLD_MAX),
        Range::Closed(-FOLD_MAX, FOLD_MAX),
    );
    number(&at.field("choppiness"), caps.choppiness, factor, "")?;
    number(&at.field("threshold"), caps.threshold, fold, "")?;
    let softness = Range::Closed(1e-3, FOLD_MAX);
    number(&at.field("softness"), caps.softness, softness, "")?;
    numbers(&at.field("albedo"), &caps.albedo, SHARE, "")?;
    number(&at.field("roughness"), caps.roughness, SHARE, "")
}
