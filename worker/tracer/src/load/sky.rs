//! Pictures of the sky.

use super::exr_file::read_exr;
use super::image_file::{Format, format_of, read_image};
use super::texture::srgb_table;
use shearwater_shared::scene::SceneError;

/// An equirectangular picture of radiance, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyImage {
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// Linear RGB, finite and not negative; `width * height` of them.
    pub rgb: Vec<[f32; 3]>,
    /// Texels of the file that were negative or not finite: set to 0.
    pub bad_texels: u64,
}

/// Read an EXR (radiance) or a PNG or JPEG (sRGB) as a sky.
///
/// # Errors
/// Another format, a damaged file, more texels than allowed, DWAA or DWAB.
pub fn load_sky(file: &str, bytes: &[u8]) -> Result<SkyImage, SceneError> {
    let format = format_of(file, bytes)?;
    if format == Format::Exr {
        let image = read_exr(file, bytes)?;
        return Ok(SkyImage {
            width: image.width,
            height: image.height,
            rgb: image.rgb,
            bad_texels: image.bad_texels,
        });
    }
    let image = read_image(file, bytes, format)?;
    let linear = srgb_table();
    let to_linear = |[r, g, b, _]: &[u8; 4]| [r, g, b].map(|byte| linear[usize::from(*byte)]);
    Ok(SkyImage {
        width: image.width,
        height: image.height,
        rgb: image.rgba.iter().map(to_linear).collect(),
        bad_texels: 0,
    })
}
