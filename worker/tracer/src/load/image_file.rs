//! PNG and JPEG pictures as 8-bit texels.

use super::exr_file::{MAGIC, check_size};
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use shearwater_shared::limits::{TEXELS_MAX, TEXTURE_DECODE_BYTES_MAX};
use shearwater_shared::scene::SceneError;
use std::io::Cursor;

/// What a picture file is, by its first bytes and not by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Exr,
    Png,
    Jpeg,
}

/// 8-bit texels, rows from the top; their user knows what a byte means.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ByteImage {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) rgba: Vec<[u8; 4]>,
}

pub(super) fn format_of(file: &str, bytes: &[u8]) -> Result<Format, SceneError> {
    if bytes.starts_with(&MAGIC) {
        return Ok(Format::Exr);
    }
    match image::guess_format(bytes) {
        Ok(ImageFormat::Png) => Ok(Format::Png),
        Ok(ImageFormat::Jpeg) => Ok(Format::Jpeg),
        _ => Err(SceneError::new(
            file,
            ".",
            "not a picture that can be read: expected PNG, JPEG or EXR",
        )),
    }
}

/// Decode; 16 bits are rounded to 8, grey becomes RGB, profiles are ignored.
pub(super) fn read_image(
    file: &str,
    bytes: &[u8],
    format: Format,
) -> Result<ByteImage, SceneError> {
    read_image_within(file, bytes, format, TEXELS_MAX)
}

/// The same, with a limit of one's own on the texels.
pub(super) fn read_image_within(
    file: &str,
    bytes: &[u8],
    format: Format,
    texels_max: u64,
) -> Result<ByteImage, SceneError> {
    let (format, name) = match format {
        Format::Jpeg => (ImageFormat::Jpeg, "JPEG"),
        Format::Png | Format::Exr => (ImageFormat::Png, "PNG"),
    };
    let fail =
        |e: image::ImageError| SceneError::new(file, ".", format!("not a readable {name}: {e}"));
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(TEXTURE_DECODE_BYTES_MAX);
    // A row or column alone may not be longer than the whole may be.
    limits.max_image_width = u32::try_from(texels_max).ok();
    limits.max_image_height = limits.max_image_width;
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(fail)?;
    let (width, height) = decoder.dimensions();
    let bytes_per_texel = u64::from(decoder.color_type().bytes_per_pixel());
    check_size(
        file,
        [width.into(), height.into()],
        bytes_per_texel,
        texels_max,
    )?;
    let rgba = DynamicImage::from_decoder(decoder)
        .map_err(fail)?
        .into_rgba8()
        .into_raw();
    Ok(ByteImage {
        width,
        height,
        rgba: bytemuck::allocation::try_cast_vec(rgba).unwrap_or_else(|(_, rgba)| {
            rgba.chunks_exact(4)
                .map(|t| [t[0], t[1], t[2], t[3]])
                .collect()
        }),
    })
}
