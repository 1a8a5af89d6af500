//! The linear picture and its auxiliary planes as one OpenEXR file.
//!
//! One part, because many programs show only the first one; the beauty as plain
//! `R`, `G`, `B`, the rest under dotted names; scan lines, ZIP over 16 lines
//! (lossless, and decoded alike on every CPU, which DWAA is not). Beauty is
//! linear light without bloom, exposure or view. No alpha channel: the sky
//! covers every pixel.
//!
//! | channel | type | meaning |
//! |---|---|---|
//! | `R` `G` `B` | f32 | mean radiance, linear Rec. 709 |
//! | `albedo.R/G/B` | f16 | linear, [0, 1], zero where nothing was hit |
//! | `normal.X/Y/Z` | f16 | world space, zero where nothing was hit |
//! | `depth.Z` | f32 | metres along the camera ray; [`DEPTH_NOTHING_M`] where nothing was hit |
//! | `variance.R/G/B` | f32 | variance of the pixel mean |
//! | `sampleCount` | u32 | samples of the pixel |

use std::io::Cursor;

use exr::meta::attribute::Chromaticities;
use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Encoding, FlatSamples, Image, ImageAttributes,
    IntegerBounds, Layer, LayerAttributes, SmallVec, Text, Vec2, WritableImage, f16,
};
use rayon::prelude::*;

use super::error::DevelopError;
use super::exr_header::sort_attributes;
use super::picture::Picture;

/// Depth in files where nothing was hit, in metres: the value Blender's Cycles
/// writes. It is finite, so that filters and differences make no NaN of it; it
/// sorts behind everything, so that depth compositing and fog work without a
/// special case, which 0 would need.
pub const DEPTH_NOTHING_M: f32 = 1e10;

/// Longest text attribute in bytes: what the oldest readers take.
pub const EXR_TEXT_BYTES_MAX: usize = 255;

/// Where a picture comes from; stands in the header of its EXR file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExrAttributes {
    /// Program and version, such as `Shearwater 0.1.0`: attribute `software`.
    pub software: String,
    /// Hash of the film, hexadecimal: attribute `filmHash`.
    pub film_hash: String,
    /// Hash of the scene, hexadecimal: attribute `sceneHash`.
    pub scene_hash: String,
    /// Job that made the picture: attribute `jobId`.
    pub job_id: String,
    /// Samples per pixel, the mean if they differ: attribute `samplesPerPixel`.
    pub samples_per_pixel: f32,
    /// What ended the picture, such as `adaptive, relMSE 0.01`: attribute `stop`.
    pub stop: String,
    /// Render time in seconds, summed over the workers' threads or wall time as
    /// the caller counts it: attribute `renderSeconds`.
    pub render_seconds: f32,
}

/// The EXR file of `picture`; the same bytes for the same arguments.
///
/// # Errors
/// [`DevelopError::PictureSize`], [`DevelopError::PlaneLength`],
/// [`DevelopError::AttributeText`] for the caller's faults,
/// [`DevelopError::Exr`] and [`DevelopError::Layout`] for the encoder's.
pub fn encode_exr(picture: &Picture, attributes: &ExrAttributes) -> Result<Vec<u8>, DevelopError> {
    picture.check()?;
    let size = Vec2(picture.width as usize, picture.height as usize);
    let layer = Layer::new(
        size,
        layer_attributes(attributes)?,
        // Lines from top to bottom: the writer's threads may not reorder them.
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(channels(picture)),
    );
    let mut shared = ImageAttributes::new(IntegerBounds::from_dimensions(size));
    shared.chromaticities = Some(rec709());
    let mut file = Cursor::new(Vec::new());
    Image::new(shared, layer).write().to_buffered(&mut file)?;
    let mut file = file.into_inner();
    sort_attributes(&mut file)?;
    Ok(file)
}

fn channels(picture: &Picture) -> SmallVec<[AnyChannel<FlatSamples>; 4]> {
    const RGB: [&str; 3] = ["R", "G", "B"];
    let mut list = SmallVec::new();
    for (c, name) in RGB.into_iter().enumerate() {
        list.push(channel(name, single(&picture.beauty, c)));
    }
    if let Some(albedo) = &picture.albedo {
        for (c, name) in ["albedo.R", "albedo.G", "albedo.B"].into_iter().enumerate() {
            list.push(channel(name, half(albedo, c)));
        }
    }
    if let Some(normal) = &picture.normal {
        for (c, name) in ["normal.X", "normal.Y", "normal.Z"].into_iter().enumerate() {
            list.push(channel(name, half(normal, c)));
        }
    }
    if let Some(depth) = &picture.depth {
        let values = depth.par_iter().map(|&depth_m| file_depth_m(depth_m));
        list.push(channel("depth.Z", FlatSamples::F32(values.collect())));
    }
    if let Some(variance) = &picture.variance {
        let names = ["variance.R", "variance.G", "variance.B"];
        for (c, name) in names.into_iter().enumerate() {
            list.push(channel(name, single(variance, c)));
        }
    }
    let counts = FlatSamples::U32(picture.sample_count.clone());
    list.push(channel("sampleCount", counts));
    list
}

fn channel(name: &str, samples: FlatSamples) -> AnyChannel<FlatSamples> {
    // Not `AnyChannel::new`: its flag for lossy compression follows the name.
    AnyChannel {
        name: Text::from(name),
        sample_data: samples,
        quantize_linearly: true,
        sampling: Vec2(1, 1),
    }
}

fn single(plane: &[[f32; 3]], c: usize) -> FlatSamples {
    FlatSamples::F32(plane.par_iter().map(|pixel| pixel[c]).collect())
}

/// 11 significant bits are plenty for values within [-1, 1] that guide filters.
fn half(plane: &[[f32; 3]], c: usize) -> FlatSamples {
    let values = plane.par_iter().map(|pixel| f16::from_f32(pixel[c]));
    FlatSamples::F16(values.collect())
}

fn file_depth_m(depth_m: f32) -> f32 {
    if depth_m > 0.0 && depth_m < DEPTH_NOTHING_M {
        depth_m
    } else {
        DEPTH_NOTHING_M
    }
}

fn layer_attributes(attributes: &ExrAttributes) -> Result<LayerAttributes, DevelopError> {
    let mut layer = LayerAttributes {
        software_name: Some(text("software", &attributes.software)?),
        ..LayerAttributes::default()
    };
    let texts = [
        ("filmHash", &attributes.film_hash),
        ("sceneHash", &attributes.scene_hash),
        ("jobId", &attributes.job_id),
        ("stop", &attributes.stop),
    ];
    for (name, value) in texts {
        let value = AttributeValue::Text(text(name, value)?);
        layer.other.insert(Text::from(name), value);
    }
    let numbers = [
        ("samplesPerPixel", attributes.samples_per_pixel),
        ("renderSeconds", attributes.render_seconds),
    ];
    for (name, value) in numbers {
        layer
            .other
            .insert(Text::from(name), AttributeValue::F32(value));
    }
    Ok(layer)
}

fn text(name: &'static str, value: &str) -> Result<Text, DevelopError> {
    let printable = value.bytes().all(|byte| matches!(byte, b' '..=b'~'));
    Text::new_or_none(value)
        .filter(|_| printable && value.len() <= EXR_TEXT_BYTES_MAX)
        .ok_or(DevelopError::AttributeText {
            name,
            bytes_max: EXR_TEXT_BYTES_MAX,
        })
}

/// Primaries and white of Rec. 709 (ITU-R BT.709-6, items 1.3 and 1.4).
fn rec709() -> Chromaticities {
    Chromaticities {
        red: Vec2(0.640, 0.330),
        green: Vec2(0.300, 0.600),
        blue: Vec2(0.150, 0.060),
        white: Vec2(0.3127, 0.3290),
    }
}
