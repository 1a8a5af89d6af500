//! Ranges of the camera.

use super::super::at::At;
use super::super::range::{
    COORDINATE, LENGTH, Range, SIZE, VELOCITY_MPS, direction, length_squared, number, numbers,
};
use super::super::{Camera, CameraKey, SceneError};
use super::animation::path;

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
    let velocity_at = at.field("velocity_mps");
    numbers(&velocity_at, &camera.velocity_mps, VELOCITY_MPS, "m/s")?;
    view(at, camera, [0.0; 3], [0.0; 3])?;
    let time = |key: &CameraKey| key.time_s;
    path(&at.field("path"), &camera.path, time, |at, key| {
        numbers(&at.field("offset_m"), &key.offset_m, COORDINATE, "m")?;
        let target_at = at.field("target_offset_m");
        numbers(&target_at, &key.target_offset_m, COORDINATE, "m")?;
        view(at, camera, key.offset_m, key.target_offset_m)
    })
}

/// There must be a direction to look in, and `up` must not be along it. The
/// velocity moves both ends of the view alike.
fn view(
    at: &At<'_>,
    camera: &Camera,
    offset_m: [f64; 3],
    target_offset_m: [f64; 3],
) -> Result<(), SceneError> {
    let is_key = offset_m != [0.0; 3] || target_offset_m != [0.0; 3];
    let view = std::array::from_fn(|i| {
        (camera.target_m[i] + target_offset_m[i]) - (camera.position_m[i] + offset_m[i])
    });
    if length_squared(view) == 0.0 {
        return Err(if is_key {
            at.error("the target is where the eye is: expected another point")
        } else {
            at.field("target_m").error(format!(
                "{:?}: expected another point than position_m",
                camera.target_m
            ))
        });
    }
    let side = cross(view, camera.up);
    let least = UP_SINE_MIN * UP_SINE_MIN * length_squared(view) * length_squared(camera.up);
    if length_squared(side) <= least {
        return Err(if is_key {
            at.error(format!(
                "the view is along `up`, {:?}: expected another direction",
                camera.up
            ))
        } else {
            at.field("up").error(format!(
                "{:?}: expected a direction that is not along the view",
                camera.up
            ))
        });
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
