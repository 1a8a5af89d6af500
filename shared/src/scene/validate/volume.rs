//! Ranges of volumes.

use super::super::at::At;
use super::super::range::{COORDINATE, Range, SHARE, SIZE, TURN, asset, count, number, numbers};
use super::super::{
    EllipsoidVolume, GridVolume, SceneError, VolumeCloud, VolumeMethod, VolumeNoise, VolumeShape,
};
use crate::limits::{MARCH_STEPS_MAX, OPTICAL_THICKNESS_MAX, VOLUME_RESOLUTION_MAX};

/// Extinction per metre: up to a mean free path of a micrometre.
const SIGMA_T_PER_M: Range = Range::Closed(0.0, 1e6);
/// Anisotropy: beyond, f32 cannot tell the peak from straight on.
const G: Range = Range::Closed(-0.99, 0.99);

pub(super) fn volume_cloud(at: &At<'_>, cloud: &VolumeCloud) -> Result<(), SceneError> {
    let shape_at = at.field("shape");
    match &cloud.shape {
        VolumeShape::Ellipsoid(shape) => ellipsoid(&shape_at, shape)?,
        VolumeShape::Grid(shape) => grid(&shape_at, shape)?,
    }
    let sigma_at = at.field("sigma_t_per_m");
    number(&sigma_at, cloud.sigma_t_per_m, SIGMA_T_PER_M, "per m")?;
    let thickness = cloud.sigma_t_per_m * cloud.shape.longest_m();
    if thickness > OPTICAL_THICKNESS_MAX {
        return Err(sigma_at.error(format!(
            "{}: makes the volume {thickness:.0} mean free paths thick; expected at most \
             {OPTICAL_THICKNESS_MAX}, a solid thing by all looks",
            cloud.sigma_t_per_m
        )));
    }
    numbers(&at.field("albedo"), &cloud.albedo, SHARE, "")?;
    number(&at.field("g"), cloud.g, G, "")?;
    method(&at.field("method"), cloud)
}

fn method(at: &At<'_>, cloud: &VolumeCloud) -> Result<(), SceneError> {
    let VolumeMethod::March(march) = cloud.method else {
        return Ok(());
    };
    let at = at.field("step_m");
    number(&at, march.step_m, SIZE, "m")?;
    let least = cloud.shape.longest_m() / f64::from(MARCH_STEPS_MAX);
    if march.step_m >= least {
        return Ok(());
    }
    Err(at.error(format!(
        "{}: expected at least {least} m, so that at most {MARCH_STEPS_MAX} steps cross the volume",
        march.step_m
    )))
}

fn ellipsoid(at: &At<'_>, shape: &EllipsoidVolume) -> Result<(), SceneError> {
    numbers(&at.field("centre_m"), &shape.centre_m, COORDINATE, "m")?;
    numbers(&at.field("radii_m"), &shape.radii_m, SIZE, "m")?;
    number(&at.field("edge"), shape.edge, SHARE, "")?;
    let most = VOLUME_RESOLUTION_MAX.into();
    count(&at.field("resolution"), shape.resolution.into(), 4, most)?;
    match &shape.noise {
        Some(described) => noise(&at.field("noise"), described),
        None => Ok(()),
    }
}

fn noise(at: &At<'_>, noise: &VolumeNoise) -> Result<(), SceneError> {
    number(&at.field("scale_m"), noise.scale_m, SIZE, "m")?;
    number(&at.field("amplitude"), noise.amplitude, SHARE, "")?;
    number(&at.field("coverage"), noise.coverage, SHARE, "")?;
    count(&at.field("octaves"), noise.octaves.into(), 1, 10)?;
    let lacunarity = Range::Closed(1.0, 4.0);
    number(&at.field("lacunarity"), noise.lacunarity, lacunarity, "")?;
    number(&at.field("gain"), noise.gain, SHARE, "")
}

fn grid(at: &At<'_>, shape: &GridVolume) -> Result<(), SceneError> {
    asset(&at.field("file"), &shape.file)?;
    numbers(&at.field("centre_m"), &shape.centre_m, COORDINATE, "m")?;
    numbers(&at.field("size_m"), &shape.size_m, SIZE, "m")?;
    number(
        &at.field("rotate_y_deg"),
        shape.rotate_y_deg,
        TURN,
        "degrees",
    )
}
