//! The sky and the sun of a scene.

use super::stage::{Assets, BuildReport};
use crate::light::{MapTables, SkyDome, SkyLight, SkyMap, SunLight, atmosphere};
use crate::load::load_sky;
use glam::{DVec3, Vec3};
use shearwater_shared::film::SAMPLE_MAX;
use shearwater_shared::scene::{Mis, Sampling, SceneDescription, SceneError, Sky, SkySampling};
use std::sync::Arc;

/// The sky's light, without the sun, in a render space whose origin is `anchor_m`.
pub(super) fn build_sky(
    description: &SceneDescription,
    assets: &Assets,
    anchor_m: DVec3,
    report: &mut BuildReport,
) -> Result<Option<SkyLight>, SceneError> {
    let tables = map_tables(&description.sampling);
    Ok(match &description.sky {
        None => None,
        Some(Sky::Constant(sky)) => Some(SkyLight::Constant(Vec3::from_array(sky.radiance))),
        Some(Sky::Map(sky)) => {
            let map = picture(
                &sky.file,
                sky.intensity,
                sky.rotation_deg,
                tables,
                assets,
                report,
            )?;
            Some(SkyLight::Map(Arc::new(map)))
        }
        Some(Sky::Dome(sky)) => {
            let map = picture(
                &sky.file,
                sky.intensity,
                sky.rotation_deg,
                tables,
                assets,
                report,
            )?;
            let centre = (DVec3::from_array(sky.centre_m) - anchor_m).as_vec3();
            let dome = SkyDome::new(Arc::new(map), centre, sky.radius_m as f32);
            Some(SkyLight::Dome(dome))
        }
        Some(Sky::Atmosphere(sky)) => {
            let sun = description.sun.as_ref().ok_or_else(|| no_sun("sky"))?;
            let rgb = atmosphere::sky_map(sky, sun);
            for value in rgb.iter().flatten() {
                check_radiance(*value, "sky.intensity", "the sky's radiance")?;
            }
            let (width, height) = (atmosphere::WIDTH, atmosphere::HEIGHT);
            let map = SkyMap::new(width, height, rgb, 0.0, tables);
            Some(SkyLight::Map(Arc::new(map)))
        }
    })
}

// The tables of a sky map, as a scene wants it sampled.
fn map_tables(sampling: &Sampling) -> MapTables {
    MapTables {
        any_contrast: match sampling.sky_sampling {
            SkySampling::Auto | SkySampling::Rough | SkySampling::Never => false,
            SkySampling::AnySky | SkySampling::Always => true,
        },
        compensated: sampling.map_compensation,
    }
}

/// Whether a scene samples its sky beside the surfaces' own directions.
pub(super) fn is_sampled(sky: &SkyLight, sampling: &Sampling) -> bool {
    if sampling.mis == Mis::ScatteringOnly {
        return false;
    }
    match sampling.sky_sampling {
        SkySampling::Never => false,
        SkySampling::Auto | SkySampling::Rough => sky.is_sampled(),
        // Nothing of an even sky lies above its mean.
        SkySampling::AnySky | SkySampling::Always => match sky {
            SkyLight::Constant(_) => !sampling.map_compensation,
            SkyLight::Map(_) | SkyLight::Dome(_) => sky.is_sampled(),
        },
    }
}

/// The sun's light: its own, or that of the real sun through the atmosphere.
pub(super) fn build_sun(description: &SceneDescription) -> Result<Option<SunLight>, SceneError> {
    let Some(sun) = &description.sun else {
        return Ok(None);
    };
    match &description.sky {
        Some(Sky::Atmosphere(sky)) if sun.radiance.is_none() => {
            let radiance = atmosphere::sun_radiance(sky, sun);
            for value in radiance {
                check_radiance(
                    value,
                    "sun.angular_radius_deg",
                    "the radiance of so small a sun",
                )?;
            }
            Ok(SunLight::with_radiance(sun, Vec3::from_array(radiance)))
        }
        _ if sun.radiance.is_none() => Err(no_sun("sun.radiance")),
        _ => Ok(SunLight::new(sun)),
    }
}

fn no_sun(path: &str) -> SceneError {
    let message = "an atmosphere and the sun's place belong together";
    SceneError::new("scene.json", path, message)
}

fn check_radiance(value: f32, path: &str, what: &str) -> Result<(), SceneError> {
    if (0.0..=SAMPLE_MAX).contains(&value) {
        return Ok(());
    }
    let message = format!("{value:e} would be {what}: at most {SAMPLE_MAX:e}");
    Err(SceneError::new("scene.json", path, message))
}

// A picture of radiance, `intensity` times as bright.
fn picture(
    file: &str,
    intensity: f32,
    rotation_deg: f64,
    tables: MapTables,
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
        tables,
    ))
}
