//! Ranges of sky and sun.

use super::super::at::At;
use super::super::range::{RADIANCE, Range, TURN, asset, number, numbers};
use super::super::{SceneError, Sky, Sun};

pub(super) fn sky(at: &At<'_>, sky: &Sky) -> Result<(), SceneError> {
    match sky {
        Sky::Constant(sky) => numbers(&at.field("radiance"), &sky.radiance, RADIANCE, ""),
        Sky::Map(sky) => {
            asset(&at.field("file"), &sky.file)?;
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
