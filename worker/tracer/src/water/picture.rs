//! The height field as pictures: what the sea's settings mean, to be looked at.

use super::Spectrum;
use exr::prelude::{SpecificChannels, WritableImage};
use image::{ExtendedColorType, ImageEncoder};
use shearwater_shared::scene::TessendorfWater;
use std::io::Cursor;

/// A height field as files.
#[derive(Clone, Debug)]
pub struct HeightPictures {
    /// 16-bit grey PNG: black is the lowest point, white the highest.
    pub png: Vec<u8>,
    /// EXR: heights `Y` in metres and slopes `slope.X` and `slope.Z`.
    pub exr: Vec<u8>,
    /// Lowest point in metres.
    pub lowest_m: f32,
    /// Highest point in metres.
    pub highest_m: f32,
}

/// A height field that could not be written.
#[derive(Debug, thiserror::Error)]
pub enum HeightPictureError {
    /// The PNG encoder failed.
    #[error("the height map could not be written as PNG: {0}")]
    Png(#[from] image::ImageError),
    /// The EXR encoder failed.
    #[error("the height map could not be written as EXR: {0}")]
    Exr(#[from] exr::error::Error),
}

/// The sea at its time as pictures, `grid` points square; rows run along z.
///
/// # Errors
/// An encoder fails, which only lack of memory can cause.
pub fn height_pictures(sea: &TessendorfWater) -> Result<HeightPictures, HeightPictureError> {
    let field = Spectrum::new(sea).at(sea.time_s);
    let n = field.n;
    let lowest_m = field.height.iter().copied().fold(f32::INFINITY, f32::min);
    let highest_m = field
        .height
        .iter()
        .copied()
        .fold(f32::NEG_INFINITY, f32::max);
    let scale = if highest_m > lowest_m {
        65_535.0 / (highest_m - lowest_m)
    } else {
        0.0
    };
    let grey: Vec<u8> = field
        .height
        .iter()
        .flat_map(|h| (((h - lowest_m) * scale + 0.5) as u16).to_ne_bytes())
        .collect();
    let mut png = Vec::new();
    let side = n as u32;
    image::codecs::png::PngEncoder::new(&mut png).write_image(
        &grey,
        side,
        side,
        ExtendedColorType::L16,
    )?;
    let mut exr = Vec::new();
    let channels = SpecificChannels::build()
        .with_channel::<f32>("Y")
        .with_channel::<f32>("slope.X")
        .with_channel::<f32>("slope.Z")
        .with_pixel_fn(|at: exr::math::Vec2<usize>| {
            let i = at.y() * n + at.x();
            (field.height[i], field.slope_x[i], field.slope_z[i])
        });
    exr::image::Image::from_channels((n, n), channels)
        .write()
        .to_buffered(Cursor::new(&mut exr))?;
    Ok(HeightPictures {
        png,
        exr,
        lowest_m,
        highest_m,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_picture_spans_the_range_of_the_heights() {
        let sea = crate::water::tests::sea();
        let pictures = height_pictures(&sea).expect("written");
        assert!(pictures.lowest_m < 0.0 && pictures.highest_m > 0.0);
        let image = image::load_from_memory(&pictures.png)
            .expect("a PNG")
            .into_luma16();
        assert_eq!(image.dimensions(), (128, 128));
        let values = image.as_raw();
        assert_eq!(
            (values.iter().min(), values.iter().max()),
            (Some(&0), Some(&65_535))
        );
    }
}
