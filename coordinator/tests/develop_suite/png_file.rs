//! PNG files, read back by a decoder.

use std::io::Cursor;

use image::codecs::png::PngDecoder;
use image::{ColorType, ImageDecoder};
use shearwater_coordinator::develop::{
    Bloom, DevelopError, DevelopedImage, PngDepth, PostSettings, View, develop, develop_png,
    encode_png,
};

use crate::pictures::full_picture;

fn ramp() -> DevelopedImage {
    DevelopedImage {
        width: 256,
        height: 2,
        rgb: (0..512_u16)
            .map(|i| {
                [
                    f32::from(i % 256) / 255.0,
                    f32::from(i / 256),
                    f32::from(i) / 511.0,
                ]
            })
            .collect(),
        non_finite_values: 0,
    }
}

#[test]
fn eight_bits_come_back() {
    let image = ramp();
    let file = encode_png(&image, PngDepth::Eight).unwrap();
    let decoder = PngDecoder::new(Cursor::new(file.as_slice())).unwrap();
    assert_eq!(decoder.dimensions(), (256, 2));
    assert_eq!(decoder.color_type(), ColorType::Rgb8);
    let mut bytes = vec![0; 256 * 2 * 3];
    decoder.read_image(&mut bytes).unwrap();
    for (pixel, bytes) in image.rgb.iter().zip(bytes.chunks(3)) {
        for (code, &byte) in pixel.iter().zip(bytes) {
            assert!((f64::from(*code) * 255.0 - f64::from(byte)).abs() <= 0.5);
        }
    }
}

#[test]
fn sixteen_bits_come_back() {
    let image = ramp();
    let file = encode_png(&image, PngDepth::Sixteen).unwrap();
    let decoder = PngDecoder::new(Cursor::new(file.as_slice())).unwrap();
    assert_eq!(decoder.color_type(), ColorType::Rgb16);
    let mut bytes = vec![0; 256 * 2 * 6];
    decoder.read_image(&mut bytes).unwrap();
    for (code, pair) in image.rgb.as_flattened().iter().zip(bytes.chunks(2)) {
        let word = f64::from(u16::from_ne_bytes([pair[0], pair[1]]));
        assert!((f64::from(*code) * 65_535.0 - word).abs() <= 0.501);
    }
}

/// CRC-32 of the PNG standard (annex D), bit by bit.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| {
            (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg())
        })
    })
}

#[test]
fn chunks_are_valid_and_mark_the_file_as_srgb() {
    let file = encode_png(&ramp(), PngDepth::Eight).unwrap();
    let mut names = Vec::new();
    let mut rest = &file[8..];
    while !rest.is_empty() {
        let len = u32::from_be_bytes(rest[..4].try_into().unwrap()) as usize;
        let stored = u32::from_be_bytes(rest[8 + len..12 + len].try_into().unwrap());
        assert_eq!(crc(&rest[4..8 + len]), stored);
        if &rest[4..8] == b"sRGB" {
            assert_eq!(rest[8..8 + len], [0]);
        }
        names.push(String::from_utf8(rest[4..8].to_vec()).unwrap());
        rest = &rest[12 + len..];
    }
    assert_eq!(names[..2], ["IHDR", "sRGB"]);
    assert_eq!(names.last().map(String::as_str), Some("IEND"));
}

#[test]
fn one_call_is_the_two_steps_and_repeats_bit_for_bit() {
    let picture = full_picture(40, 30);
    let post = PostSettings {
        exposure_ev: -1.5,
        bloom: Some(Bloom::default()),
        view: View::Agx,
    };
    let developed = develop(&picture, &post).unwrap();
    assert_eq!((developed.width, developed.height), (40, 30));
    let file = develop_png(&picture, &post, PngDepth::Eight).unwrap();
    assert_eq!(file, encode_png(&developed, PngDepth::Eight).unwrap());
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(3)
        .build()
        .unwrap();
    let again = pool.install(|| develop_png(&picture, &post, PngDepth::Eight).unwrap());
    assert_eq!(file, again);
}

#[test]
fn exposure_acts_behind_the_bloom() {
    // Twice the light, half the exposure: equal only if the threshold is
    // compared before exposure, which it is; so the two differ.
    let mut picture = full_picture(32, 32);
    picture.beauty = vec![[0.8; 3]; 32 * 32];
    let post = |exposure_ev| PostSettings {
        exposure_ev,
        bloom: Some(Bloom {
            strength: 1.0,
            ..Bloom::default()
        }),
        view: View::Standard,
    };
    let plain = develop(&picture, &post(0.0)).unwrap();
    picture.beauty = vec![[1.6; 3]; 32 * 32];
    let bloomed = develop(&picture, &post(-1.0)).unwrap();
    // (1.6 + 0.6) / 2 = 1.1 is white; 0.8 is not.
    assert!(plain.rgb[0][0] < 0.95);
    assert_eq!(bloomed.rgb[0][0], 1.0);
}

#[test]
fn contradictory_images_are_refused() {
    let mut image = ramp();
    image.rgb.pop();
    let error = encode_png(&image, PngDepth::Eight).unwrap_err();
    assert!(matches!(
        error,
        DevelopError::PlaneLength {
            plane: "rgb",
            len: 511,
            expected: 512
        }
    ));
    image.width = 0;
    let error = encode_png(&image, PngDepth::Eight).unwrap_err();
    assert!(matches!(error, DevelopError::PictureSize { .. }));
}

#[test]
fn stray_codes_are_clamped() {
    let image = DevelopedImage {
        width: 1,
        height: 1,
        rgb: vec![[-3.0, 9.0, f32::NAN]],
        non_finite_values: 1,
    };
    for (depth, expected) in [
        (PngDepth::Eight, vec![0, 255, 0]),
        (PngDepth::Sixteen, vec![0, 0, 255, 255, 0, 0]),
    ] {
        let file = encode_png(&image, depth).unwrap();
        let mut bytes = vec![7; expected.len()];
        PngDecoder::new(Cursor::new(file.as_slice()))
            .unwrap()
            .read_image(&mut bytes)
            .unwrap();
        assert_eq!(bytes, expected);
    }
}
