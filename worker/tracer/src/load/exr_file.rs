//! OpenEXR pictures as linear RGB.

use exr::prelude::{
    Compression, MetaData, ReadChannels, ReadLayers, ReadSpecificChannel, Vec2, read,
};
use shearwater_shared::limits::{TEXELS_MAX, TEXTURE_DECODE_BYTES_MAX};
use shearwater_shared::scene::SceneError;
use std::io::Cursor;

/// Linear RGB texels, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LinearImage {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) rgb: Vec<[f32; 3]>,
    /// Texels that were negative or not finite.
    pub(super) bad_texels: u64,
}

/// First bytes of every EXR file.
pub(super) const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Read the first part that has R, G and B, or else Y, at full size.
pub(super) fn read_exr(file: &str, bytes: &[u8]) -> Result<LinearImage, SceneError> {
    read_exr_within(file, bytes, TEXELS_MAX)
}

/// The same, with a limit of one's own on the texels.
pub(super) fn read_exr_within(
    file: &str,
    bytes: &[u8],
    texels_max: u64,
) -> Result<LinearImage, SceneError> {
    let fail = |message: String| SceneError::new(file, ".", message);
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false)
        .map_err(|e| fail(format!("not a readable EXR header: {e}")))?;
    let has = |header: &exr::meta::header::Header, name: &str| {
        header.channels.list.iter().any(|c| c.name.eq(name))
    };
    let color = meta
        .headers
        .iter()
        .find(|h| ["R", "G", "B"].iter().all(|name| has(h, name)));
    let Some(header) = color.or_else(|| meta.headers.iter().find(|h| has(h, "Y"))) else {
        return Err(fail(
            "the EXR has neither channels R, G, B nor Y: expected one of them in its first part"
                .to_owned(),
        ));
    };
    if header.deep {
        return Err(fail("deep EXR: expected a flat picture".to_owned()));
    }
    // The decoder of these two takes other code, with other bits, on machines
    // with AVX2.
    let lossy = |c| matches!(c, Compression::DWAA(_) | Compression::DWAB(_));
    if meta.headers.iter().any(|h| lossy(h.compression)) {
        return Err(fail(
            "DWAA or DWAB compression, whose decoding differs between machines: \
             expected any other; convert it: `oiiotool in.exr --compression zip -o out.exr`"
                .to_owned(),
        ));
    }
    let bytes_per_texel: u64 = header
        .channels
        .list
        .iter()
        .map(|c| c.sample_type.bytes_per_sample() as u64)
        .sum();
    let size = header.layer_size;
    check_size(
        file,
        [size.width() as u64, size.height() as u64],
        bytes_per_texel,
        texels_max,
    )?;
    let mut image = if color.is_some() {
        decode_rgb(bytes)
    } else {
        decode_luminance(bytes)
    }
    .map_err(|e| fail(format!("not a readable EXR: {e}")))?;
    image.clean();
    Ok(image)
}

/// Refuse sizes before memory is taken for them.
pub(super) fn check_size(
    file: &str,
    [width, height]: [u64; 2],
    bytes_per_texel: u64,
    texels_max: u64,
) -> Result<(), SceneError> {
    let texels = width.saturating_mul(height);
    if texels == 0 || texels > texels_max {
        let message = format!("{width} x {height} texels: expected 1 to {texels_max} in all");
        return Err(SceneError::new(file, ".", message));
    }
    let bytes = texels.saturating_mul(bytes_per_texel);
    if bytes > TEXTURE_DECODE_BYTES_MAX {
        let message = format!(
            "{bytes} bytes when decoded ({bytes_per_texel} for each texel): expected at most \
             {TEXTURE_DECODE_BYTES_MAX}"
        );
        return Err(SceneError::new(file, ".", message));
    }
    Ok(())
}

fn blank(size: Vec2<usize>) -> LinearImage {
    LinearImage {
        width: size.width() as u32,
        height: size.height() as u32,
        rgb: vec![[0.0; 3]; size.area()],
        bad_texels: 0,
    }
}

fn set(image: &mut LinearImage, at: Vec2<usize>, rgb: [f32; 3]) {
    let index = at.y() * image.width as usize + at.x();
    if let Some(texel) = image.rgb.get_mut(index) {
        *texel = rgb;
    }
}

fn decode_rgb(bytes: &[u8]) -> exr::error::Result<LinearImage> {
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| blank(size),
            |image, at, (r, g, b): (f32, f32, f32)| set(image, at, [r, g, b]),
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))?;
    Ok(image.layer_data.channel_data.pixels)
}

fn decode_luminance(bytes: &[u8]) -> exr::error::Result<LinearImage> {
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels()
        .required("Y")
        .collect_pixels(
            |size, _| blank(size),
            |image, at, (y,): (f32,)| set(image, at, [y; 3]),
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))?;
    Ok(image.layer_data.channel_data.pixels)
}

impl LinearImage {
    /// Set what cannot be light to 0, and count those texels.
    fn clean(&mut self) {
        for texel in &mut self.rgb {
            if texel.iter().all(|&x| x.is_finite() && x >= 0.0) {
                continue;
            }
            self.bad_texels += 1;
            *texel = texel.map(|x| if x.is_finite() { x.max(0.0) } else { 0.0 });
        }
    }
}
