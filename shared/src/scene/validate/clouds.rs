//! Ranges of clouds.

use super::super::at::At;
use super::super::range::{
    COORDINATE, LENGTH, LENGTH_M_MAX, Range, SHARE, SIZE, TURN, asset, bounds, count, direction,
    number, numbers,
};
use super::super::{Cloud, Formation, ImageFormation, ParticleCloud, SceneError, SpriteCloud};
use crate::limits;

/// Radius of a sprite: its square and the inverse of that stay far inside f32.
const SPRITE_SIZE: Range = Range::Closed(1e-4, LENGTH_M_MAX);

/// Mean cosine of a phase function; at 1 it would be no scattering at all.
const ASYMMETRY: Range = Range::Closed(-0.99, 0.99);

pub(super) fn clouds(at: &At<'_>, clouds: &[Cloud]) -> Result<(), SceneError> {
    let most = limits::PARTICLES_MAX as u64;
    let mut parts = 0_u64;
    let mut volumes = 0_usize;
    for (i, described) in clouds.iter().enumerate() {
        let at = at.index(i);
        match described {
            Cloud::Particles(cloud) => {
                particle_cloud(&at, cloud)?;
                parts += u64::from(cloud.count);
            }
            Cloud::Sprites(cloud) => {
                sprite_cloud(&at, cloud)?;
                parts += u64::from(cloud.count);
            }
            Cloud::Volume(cloud) => {
                super::volume::volume_cloud(&at, cloud)?;
                volumes += 1;
            }
        }
        if parts > most {
            return Err(at.field("count").error(format!(
                "{parts} particles and sprites in all clouds so far: expected at most {most}"
            )));
        }
        if volumes > limits::VOLUMES_MAX {
            let most = limits::VOLUMES_MAX;
            return Err(at.error(format!("{volumes} volumes: expected at most {most}")));
        }
    }
    Ok(())
}

fn particle_cloud(at: &At<'_>, cloud: &ParticleCloud) -> Result<(), SceneError> {
    formation(&at.field("formation"), &cloud.formation)?;
    let most = limits::PARTICLES_MAX as u64;
    count(&at.field("count"), cloud.count.into(), 1, most)?;
    let radius_at = at.field("particle_radius_m");
    bounds(&radius_at, &cloud.particle_radius_m, SIZE, "m")?;
    let stretch = Range::Closed(1e-3, 1e3);
    bounds(&at.field("stretch_x"), &cloud.stretch_x, stretch, "")?;
    bounds(&at.field("opacity"), &cloud.opacity, SHARE, "")?;
    numbers(&at.field("albedo"), &cloud.albedo, SHARE, "")
}

fn sprite_cloud(at: &At<'_>, cloud: &SpriteCloud) -> Result<(), SceneError> {
    formation(&at.field("formation"), &cloud.formation)?;
    let most = limits::PARTICLES_MAX as u64;
    count(&at.field("count"), cloud.count.into(), 1, most)?;
    let radius_at = at.field("sprite_radius_m");
    bounds(&radius_at, &cloud.sprite_radius_m, SPRITE_SIZE, "m")?;
    bounds(&at.field("opacity"), &cloud.opacity, SHARE, "")?;
    number(&at.field("g"), cloud.g, ASYMMETRY, "")?;
    let softness = Range::Closed(0.01, 1.0);
    number(&at.field("softness"), cloud.softness, softness, "")?;
    numbers(&at.field("albedo"), &cloud.albedo, SHARE, "")
}

fn formation(at: &At<'_>, formation: &Formation) -> Result<(), SceneError> {
    match formation {
        Formation::Radial(radial) => {
            numbers(&at.field("centre_m"), &radial.centre_m, COORDINATE, "m")?;
            numbers(&at.field("radii_m"), &radial.radii_m, SIZE, "m")?;
            direction(&at.field("direction"), &radial.direction)?;
            number(&at.field("length_m"), radial.length_m, LENGTH, "m")
        }
        Formation::Image(image) => image_formation(at, image),
    }
}

fn image_formation(at: &At<'_>, image: &ImageFormation) -> Result<(), SceneError> {
    asset(&at.field("file"), &image.file)?;
    numbers(&at.field("centre_m"), &image.centre_m, COORDINATE, "m")?;
    number(&at.field("width_m"), image.width_m, SIZE, "m")?;
    if let Some(height_m) = image.height_m {
        number(&at.field("height_m"), height_m, SIZE, "m")?;
    }
    number(&at.field("depth_m"), image.depth_m, LENGTH, "m")?;
    numbers(&at.field("rotate_deg"), &image.rotate_deg, TURN, "degrees")
}
