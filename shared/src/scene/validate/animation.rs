//! Ranges of everything that moves.

use super::super::at::At;
use super::super::range::{COORDINATE, Range, count, direction, number, numbers};
use super::super::{Animation, SceneDescription, SceneError, Spin};
use crate::limits;

/// Frames per second: from a frame every ten seconds to a high-speed camera.
const FPS: Range = Range::Closed(0.1, 1000.0);
/// Any time in seconds: eleven days, in which a microsecond still has digits.
const TIME: Range = Range::Closed(-1e6, 1e6);
/// Turns per minute: twice a dentist's drill.
const RPM: Range = Range::Closed(-1e6, 1e6);
/// Least time between two keys in seconds: a closer pair is a jump.
const KEY_GAP_S_MIN: f64 = 1e-6;

pub(super) fn animation(root: &At<'_>, scene: &SceneDescription) -> Result<(), SceneError> {
    let Some(animation) = &scene.animation else {
        return Ok(());
    };
    ranges(&root.field("animation"), animation)?;
    let (shutter_s, fps) = (scene.camera.shutter_s, animation.fps);
    if shutter_s * fps > 1.0 {
        return Err(root.field("camera").field("shutter_s").error(format!(
            "{shutter_s}: expected at most {} s, the time of one frame at {fps} frames per second",
            1.0 / fps
        )));
    }
    Ok(())
}

fn ranges(at: &At<'_>, animation: &Animation) -> Result<(), SceneError> {
    number(&at.field("fps"), animation.fps, FPS, "frames per second")?;
    let most = limits::FRAMES_MAX.into();
    count(&at.field("frames"), animation.frames.into(), 1, most)?;
    number(&at.field("start_s"), animation.start_s, TIME, "s")
}

pub(super) fn spin(at: &At<'_>, spin: &Spin) -> Result<(), SceneError> {
    direction(&at.field("axis"), &spin.axis)?;
    number(&at.field("rpm"), spin.rpm, RPM, "turns per minute")?;
    numbers(&at.field("pivot_m"), &spin.pivot_m, COORDINATE, "m")
}

/// Number and times of keys; what else a key holds is checked by `key`.
pub(super) fn path<K>(
    at: &At<'_>,
    keys: &[K],
    time_s: impl Fn(&K) -> f64,
    check: impl Fn(&At<'_>, &K) -> Result<(), SceneError>,
) -> Result<(), SceneError> {
    count(at, keys.len() as u64, 0, limits::KEYS_MAX as u64)?;
    let mut before: Option<f64> = None;
    for (i, key) in keys.iter().enumerate() {
        let key_at = at.index(i);
        let (time_at, time) = (key_at.field("time_s"), time_s(key));
        number(&time_at, time, TIME, "s")?;
        if let Some(before) = before
            && time - before < KEY_GAP_S_MIN
        {
            return Err(time_at.error(format!(
                "{time}: expected a time after {before} s, that of the key before it \
                 (by {KEY_GAP_S_MIN} s at least)"
            )));
        }
        before = Some(time);
        check(&key_at, key)?;
    }
    Ok(())
}
