//! PNG pictures: what a screen shows.

use super::{Picture, PictureError, Planes, Range, check_size};
use image::{ImageDecoder, ImageFormat, ImageReader};
use std::io::Cursor;

/// First bytes of every PNG file.
pub(super) const MAGIC: [u8; 8] = *b"\x89PNG\r\n\x1a\n";

/// 8 or 16 bits, grey or colour; alpha is left out.
pub(super) fn decode(file: &str, bytes: &[u8]) -> Result<Picture, PictureError> {
    let fail = |e: image::ImageError| {
        PictureError::content(file, format!("not a readable PNG picture: {e}"))
    };
    let mut decoder = ImageReader::with_format(Cursor::new(bytes), ImageFormat::Png)
        .into_decoder()
        .map_err(fail)?;
    let (width, height) = decoder.dimensions();
    check_size(file, width.into(), height.into())?;
    let mut limits = image::Limits::default();
    limits.max_alloc = Some(shearwater_shared::limits::TEXTURE_DECODE_BYTES_MAX);
    decoder.set_limits(limits).map_err(fail)?;
    let image = image::DynamicImage::from_decoder(decoder).map_err(fail)?;
    let rgb = image.into_rgb32f();
    Ok(Picture {
        width: width as usize,
        height: height as usize,
        rgb: rgb.pixels().map(|pixel| pixel.0).collect(),
        range: Range::Display,
        planes: Planes::default(),
    })
}
