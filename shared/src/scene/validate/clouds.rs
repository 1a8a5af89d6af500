//! Ranges of clouds.

use super::super::at::At;
use super::super::range::{
    COORDINATE, LENGTH, Range, SHARE, SIZE, bounds, count, direction, number, numbers,
};
use super::super::{Cloud, Formation, ParticleCloud, SceneError};
use crate::limits;

pub(super) fn clouds(at: &At<'_>, clouds: &[Cloud]) -> Result<(), SceneError> {
    let most = limits::PARTICLES_MAX as u64;
    let mut particles = 0_u64;
    for (i, described) in clouds.iter().enumerate() {
        let at = at.index(i);
        match described {
            Cloud::Particles(cloud) => {
                particle_cloud(&at, cloud)?;
                particles += u64::from(cloud.count);
            }
        }
        if particles > most {
            return Err(at.field("count").error(format!(
                "{particles} particles in all clouds so far: expected at most {most}"
            )));
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

fn formation(at: &At<'_>, formation: &Formation) -> Result<(), SceneError> {
    match formation {
        Formation::Radial(radial) => {
            numbers(&at.field("centre_m"), &radial.centre_m, COORDINATE, "m")?;
            numbers(&at.field("radii_m"), &radial.radii_m, SIZE, "m")?;
            direction(&at.field("direction"), &radial.direction)?;
            number(&at.field("length_m"), radial.length_m, LENGTH, "m")
        }
    }
}
