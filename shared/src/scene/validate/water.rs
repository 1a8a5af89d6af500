//! Ranges of the water.

use super::super::at::At;
use super::super::range::{
    COORDINATE, LENGTH, Range, SHARE, TURN, VELOCITY_MPS, asset, count, number, numbers,
};
use super::super::{
    FlatWater, GerstnerWater, Profile, SceneError, TessendorfWater, Water, Whitecaps,
};
use std::f64::consts::PI;

/// Fastest wind in metres per second: twice the worst storm. Calm is a light
/// breeze; the spectrum has no waves at 0.
const WIND_MPS: Range = Range::Closed(0.1, 200.0);
/// Side of the water tile or of its texture, or length of a wave, in metres: from a
/// puddle in a scene whose unit is the kilometre to where one period spans the sea that
/// a camera sees.
const TILE_M: Range = Range::Closed(1e-5, 1e6);
/// When the waves are looked at, in seconds: eleven days around 0.
const TIME_S: Range = Range::Closed(-1e6, 1e6);
/// After how many seconds the waves are back: from one frame of the fastest camera
/// to as long as time may run.
const LOOP_S: Range = Range::Closed(1e-3, 1e6);
/// Height fields of one frame: each costs the memory and the time of one.
const SHUTTER_FIELDS_MAX: u64 = 4;
/// How far waves may fold: beyond a hundred times over it is all foam.
const FOLD_MAX: f64 = 100.0;
/// Waves by hand: every point of the picture sums them all.
const WAVES_MAX: u64 = 64;
/// Slack of the sum of steepnesses, for decimals that should sum to 1.
const STEEPNESS_SLACK: f64 = 1e-9;

pub(super) fn water(at: &At<'_>, water: &Water) -> Result<(), SceneError> {
    let look = water.look();
    number(&at.field("height_m"), look.height_m, COORDINATE, "m")?;
    numbers(&at.field("body_color"), &look.body_color, SHARE, "")?;
    number(&at.field("ior"), look.ior, Range::Closed(1.0, 4.0), "")?;
    number(&at.field("roughness"), look.roughness, SHARE, "")?;
    let velocity_at = at.field("velocity_mps");
    numbers(&velocity_at, &look.velocity_mps, VELOCITY_MPS, "m/s")?;
    match water {
        Water::Tessendorf(w) => tessendorf(at, w),
        Water::Gerstner(w) => gerstner(at, w),
        Water::Flat(w) => flat(at, w),
    }
}

fn tessendorf(at: &At<'_>, w: &TessendorfWater) -> Result<(), SceneError> {
    if !(16..=2048).contains(&w.grid) || !w.grid.is_power_of_two() {
        return Err(at
            .field("grid")
            .error(format!("{}: expected a power of two, 16 to 2048", w.grid)));
    }
    number(&at.field("tile_m"), w.tile_m, TILE_M, "m")?;
    let wind_at = at.field("wind_speed_mps");
    number(&wind_at, w.wind_speed_mps, WIND_MPS, "m/s")?;
    let wind_at = at.field("wind_direction_deg");
    number(&wind_at, w.wind_direction_deg, TURN, "degrees")?;
    let amplitude = Range::Closed(0.0, 10.0);
    number(&at.field("amplitude"), w.amplitude, amplitude, "")?;
    number(&at.field("cutoff_m"), w.cutoff_m, LENGTH, "m")?;
    times(at, w.time_s, w.loop_s)?;
    let fields_at = at.field("shutter_fields");
    let fields = u64::from(w.shutter_fields);
    count(&fields_at, fields, 1, SHUTTER_FIELDS_MAX)?;
    match &w.whitecaps {
        Some(caps) => whitecaps(&at.field("whitecaps"), caps),
        None => Ok(()),
    }
}

fn times(at: &At<'_>, time_s: f64, loop_s: Option<f64>) -> Result<(), SceneError> {
    number(&at.field("time_s"), time_s, TIME_S, "s")?;
    match loop_s {
        Some(loop_s) => number(&at.field("loop_s"), loop_s, LOOP_S, "s"),
        None => Ok(()),
    }
}

fn whitecaps(at: &At<'_>, caps: &Whitecaps) -> Result<(), SceneError> {
    let factor = Range::Closed(0.0, FOLD_MAX);
    number(&at.field("choppiness"), caps.choppiness, factor, "")?;
    let fold = Range::Closed(-FOLD_MAX, FOLD_MAX);
    number(&at.field("threshold"), caps.threshold, fold, "")?;
    let softness = Range::Closed(1e-3, FOLD_MAX);
    number(&at.field("softness"), caps.softness, softness, "")?;
    numbers(&at.field("albedo"), &caps.albedo, SHARE, "")?;
    number(&at.field("roughness"), caps.roughness, SHARE, "")
}

fn gerstner(at: &At<'_>, w: &GerstnerWater) -> Result<(), SceneError> {
    let waves_at = at.field("waves");
    count(&waves_at, w.waves.len() as u64, 1, WAVES_MAX)?;
    for (i, wave) in w.waves.iter().enumerate() {
        let at = waves_at.index(i);
        let amplitude = Range::Closed(0.0, 1e6);
        number(&at.field("amplitude_m"), wave.amplitude_m, amplitude, "m")?;
        number(&at.field("wavelength_m"), wave.wavelength_m, TILE_M, "m")?;
        let direction_at = at.field("direction_deg");
        number(&direction_at, wave.direction_deg, TURN, "degrees")?;
        number(&at.field("phase_deg"), wave.phase_deg, TURN, "degrees")?;
    }
    times(at, w.time_s, w.loop_s)?;
    let steepness =
        |wave: &super::super::GerstnerWave| 2.0 * PI * wave.amplitude_m / wave.wavelength_m;
    let sum: f64 = w.waves.iter().map(steepness).sum();
    if w.profile == Profile::Trochoid && sum > 1.0 + STEEPNESS_SLACK {
        return Err(waves_at.error(format!(
            "2 pi amplitude / wavelength sums to {sum:.4}: expected at most 1, or crests loop; \
             lower the amplitudes or take the profile `sine`"
        )));
    }
    Ok(())
}

fn flat(at: &At<'_>, w: &FlatWater) -> Result<(), SceneError> {
    if let Some(texture) = &w.texture {
        asset(&at.field("texture"), texture)?;
    }
    number(&at.field("texture_size_m"), w.texture_size_m, TILE_M, "m")
}
