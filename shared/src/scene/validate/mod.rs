//! Ranges and references of a scene, one file for each part of it.

mod animation;
mod camera;
mod clouds;
mod materials;
mod meshes;
mod parents;
mod post;
mod sampling;
mod sky;
mod volume;
mod water;
#[cfg(test)]
mod water_tests;

use super::at::At;
use super::range::count;
use super::{Image, JobDefaults, SceneDescription, SceneError};
use crate::limits;

/// Check every range and every name.
pub(super) fn validate(scene: &SceneDescription) -> Result<(), SceneError> {
    let root = At::root();
    name(&root.field("name"), &scene.name)?;
    image(&root.field("image"), scene.image)?;
    job(&root.field("job"), &scene.job)?;
    camera::camera(&root.field("camera"), &scene.camera)?;
    animation::animation(&root, scene)?;
    materials::materials(&root.field("materials"), scene)?;
    meshes::meshes(&root.field("meshes"), scene)?;
    meshes::instances(&root.field("instances"), scene)?;
    if let Some(sky_described) = &scene.sky {
        sky::sky(&root.field("sky"), sky_described)?;
    }
    if let Some(sun_described) = &scene.sun {
        sky::sun(&root.field("sun"), sun_described)?;
    }
    sky::sun_for_sky(
        &root.field("sky"),
        scene.sky.as_ref(),
        &root.field("sun"),
        scene.sun.as_ref(),
    )?;
    if let Some(water_described) = &scene.water {
        water::water(&root.field("water"), water_described)?;
    }
    clouds::clouds(&root.field("clouds"), &scene.clouds)?;
    sampling::sampling(&root.field("sampling"), &scene.sampling)?;
    post::post(&root.field("post"), &scene.post)
}

/// The scene's name becomes the name of files.
fn name(at: &At<'_>, name: &str) -> Result<(), SceneError> {
    count(at, name.len() as u64, 1, limits::NAME_BYTES_MAX as u64)
        .map_err(|e| at.error(format!("{} bytes", e.message)))?;
    if name.contains(['/', '\\']) || name.starts_with('.') || name.chars().any(char::is_control) {
        return Err(at.error(format!(
            "{name:?}: expected a name for files, without `/`, `\\`, control characters or a \
             leading `.`"
        )));
    }
    Ok(())
}

fn image(at: &At<'_>, image: Image) -> Result<(), SceneError> {
    let side = u64::from(limits::IMAGE_SIDE_MAX);
    count(&at.field("width"), image.width.into(), 1, side)?;
    count(&at.field("height"), image.height.into(), 1, side)?;
    let pixels = u64::from(image.width) * u64::from(image.height);
    if pixels > limits::IMAGE_PIXELS_MAX {
        return Err(at.error(format!(
            "{pixels} pixels: expected at most {}",
            limits::IMAGE_PIXELS_MAX
        )));
    }
    Ok(())
}

fn job(at: &At<'_>, job: &JobDefaults) -> Result<(), SceneError> {
    samples(at, job.samples)?;
    if let Some(seconds) = job.seconds {
        let most = limits::STOP_SECONDS_MAX.into();
        count(&at.field("seconds"), seconds.into(), 1, most)?;
    }
    Ok(())
}

fn samples(at: &At<'_>, samples: u32) -> Result<(), SceneError> {
    let at = at.field("samples");
    count(&at, samples.into(), 2, limits::SAMPLES_MAX.into())?;
    if samples.is_multiple_of(2) {
        Ok(())
    } else {
        Err(at.error(format!(
            "{samples}: expected an even number, because samples come in two halves"
        )))
    }
}

#[cfg(test)]
#[path = "../validate_tests/mod.rs"]
mod tests;
