//! The waves as pictures: what the water's settings mean, to be looked at.

use super::gerstner::GerstnerStage;
use super::{HeightField, Spectrum};
use exr::prelude::{SpecificChannels, WritableImage};
use glam::{Vec2, Vec3};
use image::{ExtendedColorType, ImageEncoder};
use shearwater_shared::scene::{GerstnerWater, Water};
use std::io::Cursor;

/// Points along a side of the picture of waves that have no grid.
const POINTS: usize = 256;
/// Side of that picture, in wavelengths of the longest wave.
const WAVELENGTHS: f64 = 4.0;

/// Heights and normals of waves as files; rows run along z, columns along x.
#[derive(Clone, Debug)]
pub struct WaterPictures {
    /// 16-bit grey PNG: black is the lowest point, white the highest.
    pub height_png: Vec<u8>,
    /// EXR: heights `Y` in metres and slopes `slope.X` and `slope.Z`.
    pub height_exr: Vec<u8>,
    /// 8-bit PNG of unit normals, -1 to 1 as 0 to 255: red is +x (right), green -z
    /// (up in the picture), blue +y (out of the water), as normal maps have it.
    pub normal_png: Vec<u8>,
    /// EXR of unit normals: `normal.X`, `normal.Y`, `normal.Z` along the scene's axes.
    pub normal_exr: Vec<u8>,
    /// Lowest point in metres.
    pub lowest_m: f32,
    /// Highest point in metres.
    pub highest_m: f32,
    /// Points along a side.
    pub points: usize,
    /// Metres along a side.
    pub side_m: f64,
}

/// Waves that could not be written.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// There are none.
    #[error("flat water has no waves to show: take `tessendorf` or `gerstner`")]
    Flat,
    /// The PNG encoder failed.
    #[error("the waves could not be written as PNG: {0}")]
    Png(#[from] image::ImageError),
    /// The EXR encoder failed.
    #[error("the waves could not be written as EXR: {0}")]
    Exr(#[from] exr::error::Error),
}

/// The waves `time_s` after the water's own time. Tessendorf's on their grid;
/// Gerstner's, which need not repeat, on 256 x 256 points over four of the longest
/// waves from the scene's origin.
///
/// # Errors
/// [`PictureError::Flat`]; else an encoder fails, which only lack of memory can
/// cause.
pub fn water_pictures(water: &Water, time_s: f64) -> Result<WaterPictures, PictureError> {
    let field = match water {
        Water::Tessendorf(sea) => Spectrum::new(sea).at(sea.time_s + time_s),
        Water::Gerstner(sea) => gerstner_field(sea, time_s),
        Water::Flat(_) => return Err(PictureError::Flat),
    };
    let (low, high) = (f32::INFINITY, f32::NEG_INFINITY);
    let lowest_m = field.height.iter().copied().fold(low, f32::min);
    let highest_m = field.height.iter().copied().fold(high, f32::max);
    let normals: Vec<Vec3> = field
        .slope_x
        .iter()
        .zip(&field.slope_z)
        .map(|(&x, &z)| Vec3::new(-x, 1.0, -z).normalize())
        .collect();
    Ok(WaterPictures {
        height_png: height_png(&field, lowest_m, highest_m)?,
        height_exr: height_exr(&field)?,
        normal_png: normal_png(&normals, field.n)?,
        normal_exr: normal_exr(&normals, field.n)?,
        lowest_m,
        highest_m,
        points: field.n,
        side_m: field.tile_m,
    })
}

fn gerstner_field(sea: &GerstnerWater, time_s: f64) -> HeightField {
    let longest_m = sea.waves.iter().map(|w| w.wavelength_m).fold(0.0, f64::max);
    let side_m = longest_m * WAVELENGTHS;
    let step = side_m / POINTS as f64;
    let waves = GerstnerStage::new(sea).at(time_s, [0.0; 2]);
    let at = |i: usize| {
        let (x, z) = ((i % POINTS) as f64 * step, (i / POINTS) as f64 * step);
        Vec2::new(x as f32, z as f32)
    };
    let points = || (0..POINTS * POINTS).map(at);
    let slopes: Vec<Vec2> = points().map(|p| waves.at(p, 0.0, 0.0).slope).collect();
    HeightField {
        n: POINTS,
        tile_m: side_m,
        height: points().map(|p| waves.height_m(p, 0.0)).collect(),
        slope_x: slopes.iter().map(|s| s.x).collect(),
        slope_z: slopes.iter().map(|s| s.y).collect(),
    }
}

fn height_png(field: &HeightField, low: f32, high: f32) -> Result<Vec<u8>, PictureError> {
    let scale = if high > low {
        65_535.0 / (high - low)
    } else {
        0.0
    };
    let grey: Vec<u8> = field
        .height
        .iter()
        .flat_map(|h| (((h - low) * scale + 0.5) as u16).to_ne_bytes())
        .collect();
    png(&grey, field.n, ExtendedColorType::L16)
}

fn normal_png(normals: &[Vec3], n: usize) -> Result<Vec<u8>, PictureError> {
    let rgb: Vec<u8> = normals
        .iter()
        .flat_map(|v| [v.x, -v.z, v.y].map(|c| (c * 127.5 + 128.0) as u8))
        .collect();
    png(&rgb, n, ExtendedColorType::Rgb8)
}

fn png(bytes: &[u8], n: usize, color: ExtendedColorType) -> Result<Vec<u8>, PictureError> {
    let mut file = Vec::new();
    let side = n as u32;
    image::codecs::png::PngEncoder::new(&mut file).write_image(bytes, side, side, color)?;
    Ok(file)
}

fn height_exr(field: &HeightField) -> Result<Vec<u8>, PictureError> {
    exr(field.n, ["Y", "slope.X", "slope.Z"], |i| {
        (field.height[i], field.slope_x[i], field.slope_z[i])
    })
}

fn normal_exr(normals: &[Vec3], n: usize) -> Result<Vec<u8>, PictureError> {
    exr(n, ["normal.X", "normal.Y", "normal.Z"], |i| {
        normals[i].into()
    })
}

fn exr(
    n: usize,
    names: [&str; 3],
    value: impl Fn(usize) -> (f32, f32, f32) + Sync,
) -> Result<Vec<u8>, PictureError> {
    let channels = SpecificChannels::build()
        .with_channel::<f32>(names[0])
        .with_channel::<f32>(names[1])
        .with_channel::<f32>(names[2])
        .with_pixel_fn(|at: exr::math::Vec2<usize>| value(at.y() * n + at.x()));
    let mut file = Vec::new();
    exr::image::Image::from_channels((n, n), channels)
        .write()
        .to_buffered(Cursor::new(&mut file))?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use shearwater_shared::scene::{GerstnerWave, Profile};

    #[test]
    fn the_pictures_span_heights_and_normals() {
        let one = GerstnerWave {
            amplitude_m: 0.5,
            wavelength_m: 10.0,
            direction_deg: 90.0,
            phase_deg: 0.0,
        };
        let by_hand = GerstnerWater {
            waves: vec![one],
            profile: Profile::Sine,
            height_m: 0.0,
            body_color: [0.0; 3],
            ior: 1.333,
            roughness: 0.0,
            velocity_mps: [0.0; 2],
            time_s: 0.0,
            loop_s: None,
        };
        let random = Water::Tessendorf(crate::water::tests::sea());
        for (water, side) in [(random, 128), (Water::Gerstner(by_hand), 256)] {
            let pictures = water_pictures(&water, 0.0).expect("written");
            assert!(pictures.lowest_m < 0.0 && pictures.highest_m > 0.0);
            let image = image::load_from_memory(&pictures.height_png)
                .expect("a PNG")
                .into_luma16();
            assert_eq!(image.dimensions(), (side, side));
            let values = image.as_raw();
            let range = (values.iter().min(), values.iter().max());
            assert_eq!(range, (Some(&0), Some(&65_535)));
            // Where a column rises to the right its normal leans to the left.
            let normals = image::load_from_memory(&pictures.normal_png)
                .expect("a PNG")
                .into_rgb8();
            let at = |x: u32, y: u32| i32::from(image.get_pixel(x, y).0[0]);
            let mut agree = 0;
            for (x, y) in (1..side - 1).flat_map(|x| (1..side - 1).map(move |y| (x, y))) {
                let [red, green, blue] = normals.get_pixel(x, y).0.map(i32::from);
                assert!(blue >= 127);
                let right = at(x + 1, y) - at(x - 1, y);
                let up = at(x, y - 1) - at(x, y + 1);
                agree += i32::from((right > 0) == (red < 128)) + i32::from(up * (green - 128) <= 0);
            }
            let all = 2 * (side - 2) * (side - 2);
            assert!(f64::from(agree) > 0.85 * f64::from(all), "{agree} of {all}");
        }
    }

    #[test]
    fn still_water_says_so() {
        let flat = serde_json::json!({"type": "flat"});
        let flat: Water = serde_json::from_value(flat).expect("water");
        assert!(matches!(
            water_pictures(&flat, 0.0),
            Err(PictureError::Flat)
        ));
    }
}
