//! Time: frames, turning parts, keyframes.

use super::SceneDescription;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The frames of a moving picture. Frame `f` is at `start_s + f / fps`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Animation {
    /// Frames per second, 0.1 to 1000.
    #[schemars(range(min = 0.1, max = 1000.0))]
    pub fps: f64,
    /// Number of frames, 1 to 1,000,000.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub frames: u32,
    /// Time of frame 0 in seconds.
    #[serde(default)]
    #[schemars(range(min = -1e6, max = 1e6))]
    pub start_s: f64,
}

/// A steady turn of a mesh, before it is scaled and placed: a propeller, a wheel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Spin {
    /// Axis in mesh space, any length but zero. Seen against it (it points at
    /// the viewer) a positive turn is counter-clockwise.
    pub axis: [f64; 3],
    /// Turns per minute; negative turns the other way. The mesh stands as
    /// modelled at time 0.
    #[schemars(range(min = -1e6, max = 1e6))]
    pub rpm: f64,
    /// A point of the axis, mesh space, metres.
    #[serde(default)]
    #[schemars(inner(range(min = -1e9, max = 1e9)))]
    pub pivot_m: [f64; 3],
}

/// Where an instance is at one time, besides its placement and velocity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InstanceKey {
    /// When, in seconds.
    #[schemars(range(min = -1e6, max = 1e6))]
    pub time_s: f64,
    /// Added to `translate_m`.
    #[serde(default)]
    #[schemars(inner(range(min = -1e9, max = 1e9)))]
    pub offset_m: [f64; 3],
    /// Added to `rotate_deg`.
    #[serde(default)]
    #[schemars(inner(range(min = -1e6, max = 1e6)))]
    pub turn_deg: [f64; 3],
}

/// Where the camera is at one time, besides its placement and velocity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CameraKey {
    /// When, in seconds.
    #[schemars(range(min = -1e6, max = 1e6))]
    pub time_s: f64,
    /// Added to `position_m`.
    #[serde(default)]
    #[schemars(inner(range(min = -1e9, max = 1e9)))]
    pub offset_m: [f64; 3],
    /// Added to `target_m`.
    #[serde(default)]
    #[schemars(inner(range(min = -1e9, max = 1e9)))]
    pub target_offset_m: [f64; 3],
}

impl SceneDescription {
    /// When the shutter opens for a frame, in seconds; 0 without an animation.
    #[must_use]
    pub fn frame_time_s(&self, frame: u32) -> f64 {
        self.animation
            .map_or(0.0, |a| a.start_s + f64::from(frame) / a.fps)
    }
}
