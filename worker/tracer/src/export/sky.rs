//! The sky as an equirectangular picture.

use super::ExportedSky;
use crate::light::SkyLight;
use crate::math::elementary::sin_cos;
use exr::prelude::{SpecificChannels, WritableImage};
use glam::Vec3;
use shearwater_shared::scene::SceneError;
use std::f32::consts::PI;
use std::io::Cursor;

/// Size of the picture of an even sky: it only has to be there.
pub(super) const CONSTANT_SIZE: (usize, usize) = (4, 2);

/// What the tracer sees in each direction, at the map's own texels where there is a
/// map: one that is not turned keeps them.
pub(super) fn picture(light: &SkyLight) -> Result<ExportedSky, SceneError> {
    let (width, height) = match light {
        SkyLight::Constant(_) => CONSTANT_SIZE,
        SkyLight::Map(map) => map.size(),
        SkyLight::Dome(dome) => dome.map().size(),
    };
    let radiance = |x: usize, y: usize| {
        let (sin_theta, cos_theta) = sin_cos((y as f32 + 0.5) / height as f32 * PI);
        let (sin_phi, cos_phi) = sin_cos(((x as f32 + 0.5) / width as f32 - 0.5) * 2.0 * PI);
        let d = Vec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi);
        light.radiance(Vec3::ZERO, d).to_array()
    };
    let exr = encode(width, height, radiance).map_err(|e| {
        let message = format!("could not be written as EXR: {e}");
        SceneError::new("scene.json", "sky", message)
    })?;
    Ok(ExportedSky { exr, width, height })
}

fn encode(
    width: usize,
    height: usize,
    radiance: impl Fn(usize, usize) -> [f32; 3] + Sync,
) -> Result<Vec<u8>, exr::error::Error> {
    let channels = SpecificChannels::build()
        .with_channel::<f32>("R")
        .with_channel::<f32>("G")
        .with_channel::<f32>("B")
        .with_pixel_fn(|at: exr::math::Vec2<usize>| {
            let [r, g, b] = radiance(at.x(), at.y());
            (r, g, b)
        });
    let mut file = Cursor::new(Vec::new());
    exr::prelude::Image::from_channels((width, height), channels)
        .write()
        .to_buffered(&mut file)?;
    Ok(file.into_inner())
}
