//! Camera.

use super::animation::CameraKey;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A thin-lens camera; a pinhole when `lens_radius_m` is 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Eye point in metres.
    #[schemars(inner(range(min = -1e9, max = 1e9)))]
    pub position_m: [f64; 3],
    /// Point in the middle of the picture, in metres.
    #[schemars(inner(range(min = -1e9, max = 1e9)))]
    pub target_m: [f64; 3],
    /// Direction that is up in the picture; need not be normal to the view.
    #[serde(default = "up")]
    pub up: [f64; 3],
    /// Full vertical angle of view in degrees, above 0 and below 179.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 179))]
    pub vertical_fov_deg: f64,
    /// Time that the shutter is open, in seconds; 0 freezes everything.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub shutter_s: f64,
    /// Radius of the lens in metres; 0 is a pinhole.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1e9))]
    pub lens_radius_m: f64,
    /// Distance of perfect focus in metres; default is the target's.
    #[serde(default)]
    #[schemars(range(min = 1e-10, max = 1e9))]
    pub focus_distance_m: Option<f64>,
    /// Velocity of eye and target, in metres per second: at time t both stand
    /// `velocity_mps * t` from where they are placed.
    #[serde(default)]
    #[schemars(inner(range(min = -1e5, max = 1e5)))]
    pub velocity_mps: [f64; 3],
    /// Keys in the order of their times; smooth between them, still before the
    /// first and after the last.
    #[serde(default)]
    #[schemars(length(max = 10_000))]
    pub path: Vec<CameraKey>,
}

const fn up() -> [f64; 3] {
    [0.0, 1.0, 0.0]
}
