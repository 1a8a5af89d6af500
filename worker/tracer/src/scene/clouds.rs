//! The clouds of a scene.

use super::stage::geometry_error;
use crate::cloud;
use crate::geometry::{Ellipsoid, Particles};
use glam::DVec3;
use shearwater_shared::limits::PARTICLES_MAX;
use shearwater_shared::scene::{self, SceneDescription, SceneError};

// Particles wholly under the water can be neither seen nor shadow anything.
pub(super) fn build_clouds(
    description: &SceneDescription,
    origin: DVec3,
) -> Result<(Option<Particles>, Vec<u16>), SceneError> {
    let floor = description.water.as_ref().map(|water| {
        let scene::Water::Tessendorf(sea) = water;
        (sea.height_m - origin.y) as f32
    });
    let mut ellipsoids: Vec<Ellipsoid> = Vec::new();
    let mut owners = Vec::new();
    for (number, cloud) in description.clouds.iter().enumerate() {
        let path = format!("clouds[{number}]");
        let owner = u16::try_from(number)
            .map_err(|_| SceneError::new("scene.json", &*path, "at most 65536 clouds"))?;
        let scene::Cloud::Particles(cloud) = cloud;
        let seen = cloud::particles(cloud, origin)
            .filter(|p| floor.is_none_or(|y| p.centre.y + p.radii.y > y));
        let before = ellipsoids.len();
        ellipsoids.extend(seen);
        if ellipsoids.len() > PARTICLES_MAX {
            return Err(SceneError::new(
                "scene.json",
                path,
                format!("more than {PARTICLES_MAX} particles in all"),
            ));
        }
        owners.resize(owners.len() + ellipsoids.len() - before, owner);
    }
    if ellipsoids.is_empty() {
        return Ok((None, owners));
    }
    let particles = Particles::build(&ellipsoids).map_err(|e| geometry_error("clouds", &e))?;
    Ok((Some(particles), owners))
}
