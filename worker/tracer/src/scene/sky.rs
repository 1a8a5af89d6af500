//! The sky of a scene.

use super::stage::{Assets, BuildReport};
use crate::light::{SkyDome, SkyLight, SkyMap, SkySampling};
use crate::load::load_sky;
use glam::{DVec3, Vec3};
use shearwater_shared::film::SAMPLE_MAX;
use shearwater_shared::scene::{SceneDescription, SceneError, Sky};
use std::sync::Arc;

/// The sky's light, without the sun, in a render space whose origin is `anchor_m`.
pub(super) fn build_sky(
    description: &SceneDescription,
    assets: &Assets,
    anchor_m: DVec3,
    report: &mut BuildReport,
) -> Result<Option<SkyLight>, SceneError> {
    Ok(match &description.sky {
        None => None,
        Some(Sky::Constant(sky)) => Some(SkyLight::Constant(Vec3::from_array(sky.radiance))),
        Some(Sky::Map(sky)) => {
            let map = picture(&sky.file, sky.intensity, sky.rotation_deg, assets, report)?;
            Some(SkyLight::Map(Arc::new(map)))
        }
        Some(Sky::Dome(sky)) => {
            let map = picture(&sky.file, sky.intensity, sky.rotation_deg, assets, report)?;
            let centre = (DVec3::from_array(sky.centre_m) - anchor_m).as_vec3();
            let dome = SkyDome::new(Arc::new(map), centre, sky.radius_m as f32);
            Some(SkyLight::Dome(dome))
        }
    })
}

// A picture of radiance, `intensity` times as bright.
fn picture(
    file: &str,
    intensity: f32,
    rotation_deg: f64,
    assets: &Assets,
    report: &mut BuildReport,
) -> Result<SkyMap, SceneError> {
    let bytes = assets.get(file).ok_or_else(|| {
        SceneError::new(file, "sky.file", "the file was not supplied with the scene")
    })?;
    let mut image = load_sky(file, bytes)?;
    if image.bad_texels > 0 {
        let bad = image.bad_texels;
        report.notes.push(format!(
            "sky {file}: {bad} texels that are no radiance are black"
        ));
    }
    for value in image.rgb.iter_mut().flatten() {
        *value *= intensity;
        if !(0.0..=SAMPLE_MAX).contains(value) {
            let message = format!("{value:e} times the sky's texel: at most {SAMPLE_MAX:e} in all");
            return Err(SceneError::new("scene.json", "sky.intensity", message));
        }
    }
    Ok(SkyMap::new(
        image.width as usize,
        image.height as usize,
        image.rgb,
        rotation_deg,
        SkySampling::WhereItPays,
    ))
}
