//! Pictures that clouds are formed by.

use super::exr_file::read_exr_within;
use super::image_file::{Format, format_of, read_image_within};
use super::texture::srgb_table;
use shearwater_shared::limits::CLOUD_PIXELS_MAX;
use shearwater_shared::scene::SceneError;

/// Shares of linear red, green and blue in luminance (Rec. 709).
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// A picture as densities, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct CloudImage {
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// Linear luminance times alpha, finite and not negative; `width * height` of
    /// them.
    pub density: Vec<f32>,
    /// Texels of an EXR that were negative or not finite: set to 0.
    pub bad_texels: u64,
}

/// Read a PNG or JPEG (sRGB, alpha apart) or an EXR (linear; by its convention
/// colours are multiplied by alpha already).
///
/// # Errors
/// Another format, a damaged file, more than 2^24 pixels, DWAA or DWAB.
pub fn load_cloud_image(file: &str, bytes: &[u8]) -> Result<CloudImage, SceneError> {
    let format = format_of(file, bytes)?;
    if format == Format::Exr {
        let image = read_exr_within(file, bytes, CLOUD_PIXELS_MAX)?;
        let luminance = |rgb: &[f32; 3]| density(*rgb, 1.0);
        return Ok(CloudImage {
            width: image.width,
            height: image.height,
            density: image.rgb.iter().map(luminance).collect(),
            bad_texels: image.bad_texels,
        });
    }
    let image = read_image_within(file, bytes, format, CLOUD_PIXELS_MAX)?;
    let linear = srgb_table();
    let of_texel = |&[r, g, b, a]: &[u8; 4]| {
        let rgb = [r, g, b].map(|byte| linear[usize::from(byte)]);
        density(rgb, f64::from(a) / 255.0)
    };
    Ok(CloudImage {
        width: image.width,
        height: image.height,
        density: image.rgba.iter().map(of_texel).collect(),
        bad_texels: 0,
    })
}

fn density(rgb: [f32; 3], alpha: f64) -> f32 {
    let [r, g, b] = rgb.map(f64::from);
    ((r * LUMINANCE[0] + g * LUMINANCE[1] + b * LUMINANCE[2]) * alpha) as f32
}
