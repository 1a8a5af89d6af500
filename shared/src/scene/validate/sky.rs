//! Ranges of sky and sun.

use super::super::at::At;
use super::super::range::{
    COORDINATE, LENGTH_M_MAX, RADIANCE, Range, TURN, asset, number, numbers,
};
use super::super::{SceneError, Sky, Sun};

/// Radius of a dome: from a millimetre, far above the rounding of hit points near
/// the camera.
const DOME_RADIUS: Range = Range::Closed(1e-3, LENGTH_M_MAX);

pub(super) fn sky(at: &At<'_>, sky: &Sky) -> Result<(), SceneError> {
    match sky {
        Sky::Constant(sky) => numbers(&at.field("radiance"), &sky.radiance, RADIANCE, ""),
        Sky::Map(sky) => {
            asset(&at.field("file"), &sky.file)?;
            number(&at.field("rotation_deg"), sky.rotation_deg, TURN, "degrees")?;
            number(&at.field("intensity"), sky.intensity, RADIANCE, "")
        }
        Sky::Dome(sky) => {
            asset(&at.field("file"), &sky.file)?;
            numbers(&at.field("centre_m"), &sky.centre_m, COORDINATE, "m")?;
            number(&at.field("radius_m"), sky.radius_m, DOME_RADIUS, "m")?;
            number(&at.field("rotation_deg"), sky.rotation_deg, TURN, "degrees")?;
            number(&at.field("intensity"), sky.intensity, RADIANCE, "")
        }
    }
}

pub(super) fn sun(at: &At<'_>, sun: &Sun) -> Result<(), SceneError> {
    number(&at.field("azimuth_deg"), sun.azimuth_deg, TURN, "degrees")?;
    let elevation = Range::Closed(-90.0, 90.0);
    let elevation_at = at.field("elevation_deg");
    number(&elevation_at, sun.elevation_deg, elevation, "degrees")?;
    let radius = Range::Above(0.0, 45.0);
    let radius_at = at.field("angular_radius_deg");
    number(&radius_at, sun.angular_radius_deg, radius, "degrees")?;
    numbers(&at.field("radiance"), &sun.radiance, RADIANCE, "")
}
