//! Ranges of the camera.

use super::super::at::At;
use super::super::range::{
    COORDINATE, LENGTH, Range, SIZE, direction, length_squared, number, numbers,
};
use super::super::{Camera, SceneError};

/// Longest shutter in seconds: an hour.
const SHUTTER_S_MAX: f64 = 3600.0;
/// Sine of the smallest angle between `up` and the view: below it the picture's
/// horizontal is noise of the last digits.
const UP_SINE_MIN: f64 = 1e-6;

pub(super) fn camera(at: &At<'_>, camera: &Camera) -> Result<(), SceneError> {
    numbers(&at.field("position_m"), &camera.position_m, COORDINATE, "m")?;
    numbers(&at.field("target_m"), &camera.target_m, COORDINATE, "m")?;
    direction(&at.field("up"), &camera.up)?;
    let fov = Range::Between(0.0, 179.0);
    let fov_at = at.field("vertical_fov_deg");
    number(&fov_at, camera.vertical_fov_deg, fov, "degrees")?;
    let shutter = Range::Closed(0.0, SHUTTER_S_MAX);
    number(&at.field("shutter_s"), camera.shutter_s, shutter, "s")?;
    number(
        &at.field("lens_radius_m"),
        camera.lens_radius_m,
        LENGTH,
        "m",
    )?;
    if let Some(distance) = camera.focus_distance_m {
        number(&at.field("focus_distance_m"), distance, SIZE, "m")?;
    }
    let [px, py, pz] = camera.position_m;
    let [tx, ty, tz] = camera.target_m;
    let view = [tx - px, ty - py, tz - pz];
    if length_squared(view) == 0.0 {
        return Err(at.field("target_m").error(format!(
            "{:?}: expected another point than position_m",
            camera.target_m
        )));
    }
    let side = cross(view, camera.up);
    let least = UP_SINE_MIN * UP_SINE_MIN * length_squared(view) * length_squared(camera.up);
    if length_squared(side) <= least {
        return Err(at.field("up").error(format!(
            "{:?}: expected a direction that is not along the view",
            camera.up
        )));
    }
    Ok(())
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
