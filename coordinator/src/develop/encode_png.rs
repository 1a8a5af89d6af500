//! Code values to a PNG file, marked as sRGB.

use image::ExtendedColorType;
use image::ImageEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use rayon::prelude::*;

use super::DevelopedImage;
use super::error::DevelopError;
use super::picture::{check_len, check_size};

/// Bits per channel of a PNG.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PngDepth {
    /// 8 bits: what every viewer shows.
    #[default]
    Eight,
    /// 16 bits: for further work, without steps in soft skies.
    Sixteen,
}

/// Bytes of the signature and of the IHDR chunk (4 length, 4 name, 13 data,
/// 4 check), which the PNG standard puts first.
const IHDR_END: usize = 8 + 25;

/// On a noisy 1024 x 512 picture level 3 takes 48 ms and 5 % more bytes than
/// the encoder's default of 6, which takes 175 ms; level 1 adds 26 % more.
const PNG_COMPRESSION: CompressionType = CompressionType::Level(3);

/// The chunk `sRGB` with rendering intent 0, perceptual (PNG standard 11.3.2.5):
/// length 1, name, data, CRC-32 of name and data. The encoder has no setting
/// for it, and without it some programs guess another colour space.
const SRGB_CHUNK: [u8; 13] = [
    0, 0, 0, 1, b's', b'R', b'G', b'B', 0, 0xAE, 0xCE, 0x1C, 0xE9,
];

/// The PNG file (RGB, 8 or 16 bits) of a developed image. Values outside [0, 1]
/// are clamped, NaN becomes 0; integers are the nearest ones, halves up.
///
/// # Errors
/// [`DevelopError::PictureSize`], [`DevelopError::PlaneLength`] for an image
/// whose fields contradict each other, [`DevelopError::Png`].
pub fn encode_png(image: &DevelopedImage, depth: PngDepth) -> Result<Vec<u8>, DevelopError> {
    let pixels = check_size(image.width, image.height)?;
    check_len("rgb", image.rgb.len(), pixels)?;
    let (samples, color) = match depth {
        PngDepth::Eight => (bytes_8(&image.rgb), ExtendedColorType::Rgb8),
        PngDepth::Sixteen => (bytes_16(&image.rgb), ExtendedColorType::Rgb16),
    };
    let mut file = Vec::new();
    PngEncoder::new_with_quality(&mut file, PNG_COMPRESSION, FilterType::Adaptive).write_image(
        &samples,
        image.width,
        image.height,
        color,
    )?;
    mark_srgb(&mut file)?;
    Ok(file)
}

fn mark_srgb(file: &mut Vec<u8>) -> Result<(), DevelopError> {
    if file.get(12..16) != Some(b"IHDR".as_slice()) || file.len() < IHDR_END {
        return Err(DevelopError::Layout {
            format: "PNG",
            detail: "the file does not begin with IHDR",
        });
    }
    file.splice(IHDR_END..IHDR_END, SRGB_CHUNK);
    Ok(())
}

fn bytes_8(rgb: &[[f32; 3]]) -> Vec<u8> {
    rgb.par_iter()
        // A cast of a float saturates, and takes NaN to 0.
        .flat_map_iter(|pixel| pixel.map(|code| (code * 255.0 + 0.5) as u8))
        .collect()
}

/// In native byte order, as the encoder wants it.
fn bytes_16(rgb: &[[f32; 3]]) -> Vec<u8> {
    rgb.par_iter()
        .flat_map_iter(|pixel| {
            // In f64: 65535.5 has no place in the 24 bits of an f32.
            let codes = pixel.map(|code| (f64::from(code) * 65_535.0 + 0.5) as u16);
            codes.into_iter().flat_map(u16::to_ne_bytes)
        })
        .collect()
}
