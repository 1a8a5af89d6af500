//! Encodes the textures: PNG for colours, half-float EXR for radiance.

use exr::prelude::{
    Encoding, Image, Layer, LayerAttributes, SpecificChannels, WritableImage as _, f16,
};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder as _};
use std::io::Cursor;

/// An encoder's complaint, with the picture it was about.
#[derive(Debug)]
pub struct EncodeError {
    /// Which picture.
    pub what: &'static str,
    /// The encoder's words.
    pub reason: String,
}

impl std::fmt::Display for EncodeError {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            out,
            "cannot encode {}: {}; this is a fault of the generator",
            self.what, self.reason
        )
    }
}

impl std::error::Error for EncodeError {}

/// PNG file of sRGB bytes.
///
/// # Errors
/// When the encoder refuses, which a right size cannot cause.
pub fn png(rgb: &[u8], width: u32, height: u32) -> Result<Vec<u8>, EncodeError> {
    let mut out = Vec::new();
    PngEncoder::new_with_quality(&mut out, CompressionType::Best, FilterType::Adaptive)
        .write_image(rgb, width, height, ExtendedColorType::Rgb8)
        .map_err(|error| EncodeError {
            what: "a PNG texture",
            reason: error.to_string(),
        })?;
    Ok(out)
}

/// EXR file of linear Rec. 709 in half floats, ZIP by 16 lines.
///
/// Each half is first rounded to 8 bits of mantissa: steps of 0.4 % at most,
/// under what a display shows, for a third less of the file.
///
/// # Errors
/// When the encoder refuses, which a right size cannot cause.
pub fn exr(pixels: &[[f32; 3]], width: usize, height: usize) -> Result<Vec<u8>, EncodeError> {
    let channels = SpecificChannels::rgb(|place: exr::prelude::Vec2<usize>| {
        let [r, g, b] = pixels[place.y() * width + place.x()].map(short_half);
        (r, g, b)
    });
    let layer = Layer::new(
        (width, height),
        LayerAttributes::named("sky"),
        Encoding {
            compression: exr::prelude::Compression::ZIP16,
            ..Encoding::SMALL_LOSSLESS
        },
        channels,
    );
    let mut out = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .non_parallel()
        .to_buffered(&mut out)
        .map_err(|error| EncodeError {
            what: "the EXR sky",
            reason: error.to_string(),
        })?;
    Ok(out.into_inner())
}

/// Half float whose two last mantissa bits are rounded away (ties to even).
fn short_half(value: f32) -> f16 {
    let bits = f16::from_f32(value).to_bits();
    let odd = (bits >> 2) & 1;
    f16::from_bits(bits.saturating_add(1 + odd) & !3)
}
