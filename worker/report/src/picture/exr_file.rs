//! EXR pictures, ours and those of other programs.

use super::{Picture, PictureError, Planes, Range, check_size};
use exr::image::read::read;
use exr::prelude::{
    AnyChannels, FlatImage, FlatSamples, Layer, MetaData, ReadChannels, ReadLayers, Vec2,
};
use shearwater_shared::limits::TEXTURES_BYTES_MAX;
use std::io::Cursor;

/// First bytes of every EXR file.
pub(super) const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Plain `R`, `G`, `B` of the first layer that has them; else the three of a
/// prefix (`ViewLayer.Combined.R`), preferring names for the whole picture; else
/// `Y` as grey.
pub(super) fn decode(file: &str, bytes: &[u8]) -> Result<Picture, PictureError> {
    let fail = |what: &str, e: exr::error::Error| {
        PictureError::content(file, format!("not a readable EXR {what}: {e}"))
    };
    let meta =
        MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|e| fail("header", e))?;
    check_sizes(file, &meta)?;
    let image = read_flat(bytes).map_err(|e| fail("picture", e))?;
    let Some((layer, planes)) = choose(&image) else {
        let message =
            "no channels R, G, B (with or without a prefix) and no Y: expected one of them";
        return Err(PictureError::content(file, message));
    };
    let (width, height) = (layer.size.width(), layer.size.height());
    let beside = beside(layer);
    let list = &layer.channel_data.list;
    let planes = planes.map(|index| &list[index]);
    if planes.iter().any(|plane| plane.sampling != Vec2(1, 1)) {
        let message = "channels with fewer samples than pixels: expected one for each";
        return Err(PictureError::content(file, message));
    }
    let value = |plane: usize, pixel: usize| sample(&planes[plane].sample_data, pixel);
    let rgb = (0..width * height)
        .map(|pixel| [0, 1, 2].map(|plane| value(plane, pixel)))
        .collect();
    Ok(Picture {
        width,
        height,
        rgb,
        range: Range::Linear,
        planes: beside,
    })
}

/// Numbers of samples and variances, where the layer of the picture has them as our own
/// files do.
fn beside(layer: &FlatLayer) -> Planes {
    let find = |name: &str| {
        let mut list = layer.channel_data.list.iter();
        list.find(|c| c.name.eq(name) && c.sampling == Vec2(1, 1))
            .map(|channel| &channel.sample_data)
    };
    let sample_count = find("sampleCount").and_then(|samples| match samples {
        FlatSamples::U32(counts) => Some(counts.clone()),
        _ => None,
    });
    let variance = || {
        let (r, g, b) = (
            find("variance.R")?,
            find("variance.G")?,
            find("variance.B")?,
        );
        let at = |pixel| [r, g, b].map(|plane| sample(plane, pixel));
        let plane: Vec<_> = (0..layer.size.area()).map(at).collect();
        let sound = |v: &f32| v.is_finite() && *v >= 0.0;
        plane.iter().flatten().all(sound).then_some(plane)
    };
    Planes {
        sample_count,
        variance: variance(),
    }
}

/// Refuse what is too large to be decoded before memory is taken for it.
fn check_sizes(file: &str, meta: &MetaData) -> Result<(), PictureError> {
    let mut bytes = 0u64;
    for header in &meta.headers {
        let (width, height) = (header.layer_size.width(), header.layer_size.height());
        check_size(file, width as u64, height as u64)?;
        let of_pixel = header.channels.bytes_per_pixel as u64;
        bytes = bytes.saturating_add((width as u64 * height as u64).saturating_mul(of_pixel));
    }
    if bytes > TEXTURES_BYTES_MAX {
        let message = format!("{bytes} bytes when decoded: expected at most {TEXTURES_BYTES_MAX}");
        return Err(PictureError::content(file, message));
    }
    Ok(())
}

fn read_flat(bytes: &[u8]) -> exr::error::Result<FlatImage> {
    read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
}

/// Prefixes of a whole picture, best first; no prefix goes before all.
const WHOLE: [&str; 4] = ["combined", "beauty", "rgba", "color"];

/// How good a prefix is; lower is better.
fn rank(prefix: &str) -> usize {
    let lower = prefix.to_lowercase();
    if prefix.is_empty() {
        return 0;
    }
    let known = WHOLE.iter().position(|name| lower.contains(name));
    1 + known.unwrap_or(WHOLE.len())
}

type FlatLayer = Layer<AnyChannels<FlatSamples>>;

/// The layer and the numbers of its three channels.
fn choose(image: &FlatImage) -> Option<(&FlatLayer, [usize; 3])> {
    let mut best: Option<(usize, &FlatLayer, [usize; 3])> = None;
    for layer in &image.layer_data {
        let names: Vec<String> = layer
            .channel_data
            .list
            .iter()
            .map(|channel| channel.name.to_string())
            .collect();
        let find = |name: String| names.iter().position(|other| *other == name);
        for name in &names {
            let Some(prefix) = name
                .strip_suffix('R')
                .filter(|p| p.is_empty() || p.ends_with('.'))
            else {
                continue;
            };
            let channel = |c: &str| find(format!("{prefix}{c}"));
            if let (Some(r), Some(g), Some(b)) = (channel("R"), channel("G"), channel("B"))
                && best.is_none_or(|(other, ..)| rank(prefix) < other)
            {
                best = Some((rank(prefix), layer, [r, g, b]));
            }
        }
    }
    let grey = || {
        image.layer_data.iter().find_map(|layer| {
            let list = &layer.channel_data.list;
            let y = list.iter().position(|channel| channel.name.eq("Y"))?;
            Some((layer, [y; 3]))
        })
    };
    best.map(|(_, layer, planes)| (layer, planes)).or_else(grey)
}

fn sample(samples: &FlatSamples, pixel: usize) -> f32 {
    match samples {
        FlatSamples::F16(values) => values[pixel].to_f32(),
        FlatSamples::F32(values) => values[pixel],
        FlatSamples::U32(values) => values[pixel] as f32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::{AnyChannel, Encoding, Image, LayerAttributes, WritableImage};

    fn file(names: &[&str]) -> Vec<u8> {
        let list = names.iter().enumerate().map(|(number, name)| {
            let values = (0..6).map(|p| number as f32 + p as f32 / 8.0).collect();
            AnyChannel::new(*name, FlatSamples::F32(values))
        });
        file_of(list.collect())
    }

    fn file_of(list: exr::prelude::SmallVec<[AnyChannel<FlatSamples>; 4]>) -> Vec<u8> {
        let layer = Layer::new(
            (3, 2),
            LayerAttributes::default(),
            Encoding::SMALL_LOSSLESS,
            AnyChannels::sort(list),
        );
        let mut out = Cursor::new(Vec::new());
        Image::from_layer(layer)
            .write()
            .to_buffered(&mut out)
            .expect("written");
        out.into_inner()
    }

    #[test]
    fn the_whole_picture_is_found_among_other_channels() {
        let cases: [(&[&str], [f32; 3]); 5] = [
            (&["R", "G", "B"], [0.0, 1.0, 2.0]),
            (
                &["albedo.R", "albedo.G", "albedo.B", "R", "G", "B"],
                [3.0, 4.0, 5.0],
            ),
            (
                &[
                    "View.Emit.R",
                    "View.Emit.G",
                    "View.Emit.B",
                    "View.Combined.R",
                    "View.Combined.G",
                    "View.Combined.B",
                ],
                [3.0, 4.0, 5.0],
            ),
            (&["Z", "Y"], [1.0, 1.0, 1.0]),
            (&["only.R", "only.G", "only.B", "Z"], [0.0, 1.0, 2.0]),
        ];
        for (names, first) in cases {
            let picture = decode("a.exr", &file(names)).expect("picture");
            assert_eq!((picture.width, picture.height), (3, 2));
            assert_eq!(picture.rgb[0], first, "{names:?}");
            assert_eq!(picture.rgb[5], first.map(|v| v + 5.0 / 8.0));
        }
    }

    #[test]
    fn samples_and_variances_of_our_own_files_are_read() {
        let plain = decode("a.exr", &file(&["R", "G", "B"])).expect("picture");
        assert_eq!(plain.planes, Planes::default());
        let names = ["R", "G", "B", "variance.R", "variance.G", "variance.B"];
        let picture = decode("a.exr", &file(&names)).expect("picture");
        let variance = picture.planes.variance.expect("plane");
        assert_eq!((variance.len(), variance[2]), (6, [3.25, 4.25, 5.25]));
        // Counts are whole numbers: others are somebody else's channel.
        let other = decode("a.exr", &file(&["R", "G", "B", "sampleCount"])).expect("picture");
        assert_eq!(other.planes.sample_count, None);
        let counts: Vec<u32> = (64..70).collect();
        let light = || FlatSamples::F32(vec![0.5; 6]);
        let list = [
            AnyChannel::new("R", light()),
            AnyChannel::new("G", light()),
            AnyChannel::new("B", light()),
            AnyChannel::new("sampleCount", FlatSamples::U32(counts.clone())),
        ];
        let ours = decode("a.exr", &file_of(list.into_iter().collect())).expect("picture");
        assert_eq!(ours.planes.sample_count, Some(counts));
    }

    #[test]
    fn a_file_without_colour_is_refused() {
        let error = decode("a.exr", &file(&["Z", "id"])).expect_err("no colour");
        assert!(error.to_string().contains("no channels R, G, B"), "{error}");
    }
}
