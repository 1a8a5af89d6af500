//! The sky of a scene.

use super::stage::{Assets, BuildReport};
use crate::light::{SkyLight, SkySampling};
use crate::load::load_sky;
use glam::Vec3;
use shearwater_shared::film::SAMPLE_MAX;
use shearwater_shared::scene::{SceneDescription, SceneError, Sky};

/// The sky's light, without the sun.
pub(super) fn build_sky(
    description: &SceneDescription,
    assets: &Assets,
    report: &mut BuildReport,
) -> Result<Option<SkyLight>, SceneError> {
    Ok(match &description.sky {
        None => None,
        Some(Sky::Constant(sky)) => Some(SkyLight::Constant(Vec3::from_array(sky.radiance))),
        Some(Sky::Map(map)) => {
            let bytes = assets.get(&map.file).ok_or_else(|| {
                SceneError::new(
                    &map.file,
                    "sky.file",
                    "the file was not supplied with the scene",
                )
            })?;
            let mut image = load_sky(&map.file, bytes)?;
            if image.bad_texels > 0 {
                let bad = image.bad_texels;
                report.notes.push(format!(
                    "sky {}: {bad} texels that are no radiance are black",
                    map.file
                ));
            }
            for value in image.rgb.iter_mut().flatten() {
                *value *= map.intensity;
                if !(0.0..=SAMPLE_MAX).contains(value) {
                    let message =
                        format!("{value:e} times the sky's texel: at most {SAMPLE_MAX:e} in all");
                    return Err(SceneError::new("scene.json", "sky.intensity", message));
                }
            }
            Some(SkyLight::map(
                image.width as usize,
                image.height as usize,
                image.rgb,
                map.rotation_deg,
                SkySampling::WhereItPays,
            ))
        }
    })
}
