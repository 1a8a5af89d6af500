//! EXR files, read back by the reader of the same crate.

use std::io::Cursor;

use exr::prelude::{
    AttributeValue, FlatImage, FlatSamples, ReadChannels, ReadLayers, Text, Vec2, f16, read,
};
use shearwater_coordinator::develop::{
    DEPTH_NOTHING_M, DevelopError, ExrAttributes, Picture, encode_exr,
};

use crate::pictures::full_picture;

fn attributes() -> ExrAttributes {
    ExrAttributes {
        software: "Shearwater 0.1.0".to_owned(),
        film_hash: "f".repeat(64),
        scene_hash: "5".repeat(64),
        job_id: "17".to_owned(),
        samples_per_pixel: 512.0,
        stop: "adaptive, relMSE 0.01".to_owned(),
        render_seconds: 12.5,
    }
}

fn read_back(file: &[u8]) -> FlatImage {
    read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(Cursor::new(file))
        .unwrap()
}

fn channel<'a>(image: &'a FlatImage, name: &str) -> &'a FlatSamples {
    let list = &image.layer_data[0].channel_data.list;
    let name = Text::from(name);
    let found = list.iter().find(|channel| channel.name == name);
    &found
        .unwrap_or_else(|| panic!("no channel {name}"))
        .sample_data
}

/// The samples of an f32 channel as bits, so that NaN and -0 count too.
fn single_bits(image: &FlatImage, name: &str) -> Vec<u32> {
    match channel(image, name) {
        FlatSamples::F32(values) => values.iter().map(|value| value.to_bits()).collect(),
        other => panic!("{name} is {other:?}"),
    }
}

#[test]
fn every_channel_comes_back_from_one_part() {
    // More than one block of 16 lines, and a cut-off one.
    let mut picture = full_picture(37, 41);
    picture.beauty[7] = [f32::INFINITY, -0.0, 1e-40];
    let image = read_back(&encode_exr(&picture, &attributes()).unwrap());
    assert_eq!(image.layer_data.len(), 1);
    let layer = &image.layer_data[0];
    assert_eq!(layer.size, Vec2(37, 41));
    assert_eq!(layer.attributes.layer_name, None);
    let names: Vec<String> = layer
        .channel_data
        .list
        .iter()
        .map(|channel| channel.name.to_string())
        .collect();
    let expected = [
        "B",
        "G",
        "R",
        "albedo.B",
        "albedo.G",
        "albedo.R",
        "depth.Z",
        "normal.X",
        "normal.Y",
        "normal.Z",
        "sampleCount",
        "variance.B",
        "variance.G",
        "variance.R",
    ];
    assert_eq!(names, expected);
    let variance = picture.variance.as_ref().unwrap();
    for (c, letter) in ["R", "G", "B"].into_iter().enumerate() {
        let bits = |plane: &[[f32; 3]]| plane.iter().map(|p| p[c].to_bits()).collect::<Vec<_>>();
        assert_eq!(single_bits(&image, letter), bits(&picture.beauty));
        assert_eq!(
            single_bits(&image, &format!("variance.{letter}")),
            bits(variance)
        );
    }
    let half = |value: f32| FlatSamples::F16(vec![f16::from_f32(value); 37 * 41]);
    assert_eq!(channel(&image, "albedo.R"), &half(0.25));
    assert_eq!(channel(&image, "albedo.B"), &half(1.0));
    assert_eq!(channel(&image, "normal.Y"), &half(-1.0));
    assert_eq!(channel(&image, "normal.Z"), &half(0.5));
    assert_eq!(
        channel(&image, "sampleCount"),
        &FlatSamples::U32(picture.sample_count.clone())
    );
}

#[test]
fn depth_without_a_hit_is_the_stated_value() {
    let picture = full_picture(8, 4);
    let image = read_back(&encode_exr(&picture, &attributes()).unwrap());
    let FlatSamples::F32(depth) = channel(&image, "depth.Z") else {
        panic!("depth is not f32");
    };
    // Infinity, zero and NaN in the picture.
    assert_eq!(depth[..3], [DEPTH_NOTHING_M; 3]);
    assert_eq!(depth[3..], picture.depth.unwrap()[3..]);
}

#[test]
fn attributes_come_back() {
    let picture = full_picture(8, 4);
    let image = read_back(&encode_exr(&picture, &attributes()).unwrap());
    let own = &image.layer_data[0].attributes;
    assert_eq!(own.software_name, Some(Text::from("Shearwater 0.1.0")));
    let get = |name: &str| own.other.get(&Text::from(name)).cloned();
    let text = |value: &str| Some(AttributeValue::Text(Text::from(value)));
    assert_eq!(get("filmHash"), text(&"f".repeat(64)));
    assert_eq!(get("sceneHash"), text(&"5".repeat(64)));
    assert_eq!(get("jobId"), text("17"));
    assert_eq!(get("stop"), text("adaptive, relMSE 0.01"));
    assert_eq!(get("samplesPerPixel"), Some(AttributeValue::F32(512.0)));
    assert_eq!(get("renderSeconds"), Some(AttributeValue::F32(12.5)));
    let chromaticities = image.attributes.chromaticities.unwrap();
    assert_eq!(chromaticities.red, Vec2(0.64, 0.33));
    assert_eq!(chromaticities.white, Vec2(0.3127, 0.329));
}

#[test]
fn same_picture_same_bytes() {
    // The encoder's attributes are in a hash map with another order each time:
    // without sorting, 32 files of five such attributes agree by no chance.
    let picture = full_picture(50, 70);
    let first = encode_exr(&picture, &attributes()).unwrap();
    for threads in 1..32 {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads % 4 + 1)
            .build()
            .unwrap();
        let again = pool.install(|| encode_exr(&picture, &attributes()).unwrap());
        assert!(first == again, "file {threads} differs");
    }
}

#[test]
fn absent_planes_are_absent_channels() {
    let picture = Picture {
        width: 1,
        height: 1,
        beauty: vec![[1.0, 2.0, 3.0]],
        sample_count: vec![4],
        ..Picture::default()
    };
    let image = read_back(&encode_exr(&picture, &attributes()).unwrap());
    assert_eq!(image.layer_data[0].channel_data.list.len(), 4);
}

#[test]
fn texts_that_a_header_cannot_hold_are_refused() {
    let picture = full_picture(4, 4);
    for job_id in [
        "x".repeat(256),
        "a\0b".to_owned(),
        "möwe".to_owned(),
        "a\nb".to_owned(),
    ] {
        let attributes = ExrAttributes {
            job_id,
            ..attributes()
        };
        let error = encode_exr(&picture, &attributes).unwrap_err();
        assert!(matches!(
            error,
            DevelopError::AttributeText { name: "jobId", .. }
        ));
    }
    let empty = encode_exr(&picture, &ExrAttributes::default()).unwrap();
    assert_eq!(read_back(&empty).layer_data.len(), 1);
}
