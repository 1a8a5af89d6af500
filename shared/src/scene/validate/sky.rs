//! Ranges of sky and sun.

use super::super::at::At;
use super::super::range::{
    COORDINATE, LENGTH_M_MAX, RADIANCE, Range, SHARE, TURN, asset, number, numbers,
};
use super::super::{SceneError, Sky, Sun};

/// Radius of a dome: from a millimetre, far above the rounding of hit points near
/// the camera.
const DOME_RADIUS: Range = Range::Closed(1e-3, LENGTH_M_MAX);

/// Turbidity of air alone, up to that of thick haze.
const TURBIDITY: Range = Range::Closed(1.0, 10.0);

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
        Sky::Atmosphere(sky) => {
            number(&at.field("turbidity"), sky.turbidity, TURBIDITY, "")?;
            number(&at.field("ground_albedo"), sky.ground_albedo, SHARE, "")?;
            number(&at.field("intensity"), sky.intensity, RADIANCE, "")
        }
    }
}

/// Under an atmosphere the sun's place is needed, its radiance is not.
pub(super) fn sun_for_sky(
    sky_at: &At<'_>,
    sky: Option<&Sky>,
    sun_at: &At<'_>,
    sun: Option<&Sun>,
) -> Result<(), SceneError> {
    let atmosphere = matches!(sky, Some(Sky::Atmosphere(_)));
    match sun {
        None if atmosphere => Err(sky_at.error(
            "an atmosphere needs to know where the sun stands: expected `sun` with `azimuth_deg` \
             and `elevation_deg` (its `radiance` may be left out)"
                .to_owned(),
        )),
        Some(sun) if sun.radiance.is_none() && !atmosphere => Err(sun_at.field("radiance").error(
            "missing: expected linear RGB; only under a sky of type `atmosphere` may it be \
                 left out"
                .to_owned(),
        )),
        _ => Ok(()),
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
    match &sun.radiance {
        Some(radiance) => numbers(&at.field("radiance"), radiance, RADIANCE, ""),
        None => Ok(()),
    }
}
