//! Pictures as the world writes them, and as nobody should.
#![allow(missing_docs, clippy::unwrap_used)]

use exr::prelude::{
    AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes,
    SmallVec, SpecificChannels, WritableImage, f16,
};
use image::{DynamicImage, GrayImage, ImageBuffer, ImageFormat, Rgb, RgbImage, RgbaImage};
use shearwater_shared::scene::SceneError;
use shearwater_tracer::load::{
    Encoding as Bytes, Texture, load_cloud_image, load_sky, load_texture,
};
use std::io::Cursor;

fn load_color(file: &str, bytes: &[u8]) -> Result<Texture, SceneError> {
    load_texture(file, bytes, Bytes::Srgb)
}

fn encode(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

fn png(pixels: &[[u8; 3]], width: u32) -> Vec<u8> {
    let height = pixels.len() as u32 / width;
    let image = RgbImage::from_raw(width, height, pixels.concat()).unwrap();
    encode(&DynamicImage::ImageRgb8(image), ImageFormat::Png)
}

fn exr_with(
    width: usize,
    height: usize,
    compression: Compression,
    texel: impl Fn(usize, usize) -> (f32, f32, f32) + Sync,
) -> Vec<u8> {
    let channels = SpecificChannels::rgb(|at: exr::math::Vec2<usize>| texel(at.x(), at.y()));
    let encoding = Encoding {
        compression,
        ..Encoding::SMALL_LOSSLESS
    };
    let layer = Layer::new(
        (width, height),
        LayerAttributes::named(""),
        encoding,
        channels,
    );
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .non_parallel()
        .to_buffered(&mut bytes)
        .unwrap();
    bytes.into_inner()
}

fn near(a: [f32; 3], b: [f32; 3]) {
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() < 1e-5, "{a} {b}");
    }
}

/// sRGB to linear by hand.
fn linear(byte: u8) -> f32 {
    let v = f64::from(byte) / 255.0;
    (if v <= 0.04045 {
        v / 12.92
    } else {
        libm::pow((v + 0.055) / 1.055, 2.4)
    }) as f32
}

#[test]
fn data_are_not_colours() {
    let bytes = png(&[[0, 51, 128], [255; 3]], 2);
    let texture = load_texture("t.png", &bytes, Bytes::Linear).unwrap();
    near(texture.rgb(0.25, 0.5), [0.0, 0.2, 128.0 / 255.0]);
    near(texture.rgb(0.75, 0.5), [1.0; 3]);
    let image = exr_with(1, 1, Compression::ZIP1, |_, _| (0.25, 0.5, 0.75));
    for encoding in [Bytes::Srgb, Bytes::Linear] {
        let texture = load_texture("t.exr", &image, encoding).unwrap();
        near(texture.rgb(0.5, 0.5), [0.25, 0.5, 0.75]);
    }
}

#[test]
fn a_png_is_srgb_repeats_and_has_its_top_row_at_v_1() {
    // Red and green on top, blue and white below.
    let bytes = png(&[[255, 0, 0], [0, 188, 0], [0, 0, 255], [255; 3]], 2);
    let texture = load_color("t.png", &bytes).unwrap();
    assert_eq!((texture.width, texture.height, texture.bytes()), (2, 2, 16));
    let (red, green, blue, white) = (
        [1.0, 0.0, 0.0],
        [0.0, linear(188), 0.0],
        [0.0, 0.0, 1.0],
        [1.0; 3],
    );
    for turn in [0.0, 1.0, -1.0, 5.0, -7.0] {
        near(texture.rgb(0.25 + turn, 0.75 - turn), red);
        near(texture.rgb(0.75 + turn, 0.75 + turn), green);
        near(texture.rgb(0.25 - turn, 0.25 + turn), blue);
        near(texture.rgb(0.75 - turn, 0.25 - turn), white);
    }
    // Between centres, and across both seams.
    let half = |a: [f32; 3], b: [f32; 3]| std::array::from_fn(|i| (a[i] + b[i]) / 2.0);
    near(texture.rgb(0.5, 0.75), half(red, green));
    near(texture.rgb(0.0, 0.75), half(red, green));
    near(texture.rgb(1.0, 0.25), half(blue, white));
    near(texture.rgb(0.25, 0.0), half(red, blue));
    near(texture.rgb(0.25, 1.0), half(red, blue));
    let quarter = texture.rgb(0.375, 0.75);
    near(quarter, [0.75, 0.25 * green[1], 0.0]);
}

#[test]
fn odd_coordinates_are_answered() {
    let texture = load_color("t.png", &png(&[[200; 3]; 6], 3)).unwrap();
    for u in [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        1e30,
        -1e30,
        3e9,
        f32::MIN_POSITIVE,
        -1e-9,
        0.999_999_94,
        16_777_217.0,
    ] {
        for v in [u, 0.3, -0.0, 1.0] {
            near(texture.rgb(u, v), [linear(200); 3]);
            near(texture.rgb(v, u), [linear(200); 3]);
        }
    }
}

#[test]
fn every_kind_of_png_and_a_jpeg_are_read() {
    let grey = DynamicImage::ImageLuma8(GrayImage::from_pixel(3, 2, image::Luma([128])));
    let wide: ImageBuffer<Rgb<u16>, Vec<u16>> = ImageBuffer::from_pixel(3, 2, Rgb([128 * 257; 3]));
    let clear =
        DynamicImage::ImageRgba8(RgbaImage::from_pixel(3, 2, image::Rgba([128, 128, 128, 0])));
    for image in [grey.clone(), DynamicImage::ImageRgb16(wide), clear] {
        let texture = load_color("t", &encode(&image, ImageFormat::Png)).unwrap();
        near(texture.rgb(0.4, 0.4), [linear(128); 3]);
    }
    for image in [grey.clone(), DynamicImage::ImageRgb8(grey.to_rgb8())] {
        let bytes = encode(&image, ImageFormat::Jpeg);
        let value = load_color("t", &bytes).unwrap().rgb(0.4, 0.4);
        assert!((value[0] - linear(128)).abs() < 0.02, "{value:?}");
        let sky = load_sky("s", &bytes).unwrap();
        assert_eq!((sky.width, sky.height, sky.rgb.len()), (3, 2, 6));
        assert!((sky.rgb[0][1] - linear(128)).abs() < 0.02);
    }
}

#[test]
fn an_exr_keeps_its_radiance_and_its_rows() {
    let texel = |x: usize, y: usize| (x as f32 * 0.5, y as f32 * 100.0, 6e4);
    for compression in [
        Compression::Uncompressed,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::RLE,
    ] {
        let sky = load_sky("s.exr", &exr_with(5, 40, compression, texel)).unwrap();
        assert_eq!((sky.width, sky.height, sky.bad_texels), (5, 40, 0));
        for (i, rgb) in sky.rgb.iter().enumerate() {
            let (r, g, b) = texel(i % 5, i / 5);
            assert_eq!(*rgb, [r, g, b]);
        }
    }
}

#[test]
fn what_is_not_light_is_zero_and_counted() {
    let bytes = exr_with(4, 1, Compression::ZIP16, |x, _| match x {
        0 => (f32::NAN, 1.0, 2.0),
        1 => (f32::INFINITY, 1.0, -3.0),
        2 => (-1.0, 5.0, 0.5),
        _ => (0.25, 0.5, 0.75),
    });
    let sky = load_sky("s.exr", &bytes).unwrap();
    assert_eq!(
        sky.rgb,
        [
            [0.0, 1.0, 2.0],
            [0.0, 1.0, 0.0],
            [0.0, 5.0, 0.5],
            [0.25, 0.5, 0.75]
        ]
    );
    assert_eq!(sky.bad_texels, 3);
    // As reflectance, what is above 1 is too much as well.
    let texture = load_color("t.exr", &bytes).unwrap();
    assert_eq!(texture.rgb(0.625, 0.5), [0.0, 1.0, 0.5]);
    assert_eq!(texture.bad_texels, 5);
}

#[test]
fn half_floats_and_luminance_are_read() {
    let samples: Vec<f16> = [0.5, 1.5, 2.5, 3.5].map(f16::from_f32).to_vec();
    let list = |names: &[&str]| -> SmallVec<[AnyChannel<FlatSamples>; 4]> {
        names
            .iter()
            .map(|&n| AnyChannel::new(n, FlatSamples::F16(samples.clone())))
            .collect()
    };
    let write = |names: &[&str]| {
        let image = Image::from_channels((2, 2), AnyChannels::sort(list(names)));
        let mut bytes = Cursor::new(Vec::new());
        image
            .write()
            .non_parallel()
            .to_buffered(&mut bytes)
            .unwrap();
        bytes.into_inner()
    };
    for names in [
        &["R", "G", "B"][..],
        &["Y"],
        &["Y", "Z"],
        &["A", "B", "G", "R"],
    ] {
        let sky = load_sky("s.exr", &write(names)).unwrap();
        assert_eq!(
            sky.rgb,
            [[0.5; 3], [1.5; 3], [2.5; 3], [3.5; 3]],
            "{names:?}"
        );
    }
    let error = load_sky("s.exr", &write(&["Z"])).unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("s.exr: .: the EXR has neither"),
        "{error}"
    );
}

#[test]
fn dwa_is_refused_with_the_cure() {
    for compression in [Compression::DWAA(None), Compression::DWAB(None)] {
        let bytes = exr_with(64, 64, compression, |x, y| (x as f32, y as f32, 1.0));
        let error = load_sky("s.exr", &bytes).unwrap_err().to_string();
        assert!(
            error.contains("oiiotool in.exr --compression zip -o out.exr"),
            "{error}"
        );
    }
}

/// A PNG that says it is huge.
fn png_header(width: u32, height: u32) -> Vec<u8> {
    let mut chunk = b"IHDR".to_vec();
    chunk.extend(width.to_be_bytes());
    chunk.extend(height.to_be_bytes());
    chunk.extend([8, 2, 0, 0, 0]);
    let mut bytes = b"\x89PNG\r\n\x1a\n\0\0\0\x0d".to_vec();
    bytes.extend(&chunk);
    bytes.extend(crc32(&chunk).to_be_bytes());
    bytes.extend(b"\0\0\0\0IDAT\x35\xaf\x06\x1e");
    bytes
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |c, _| {
            if c & 1 == 1 {
                0xedb8_8320 ^ (c >> 1)
            } else {
                c >> 1
            }
        })
    })
}

#[test]
fn huge_pictures_are_refused_by_their_header() {
    for (width, height) in [(100_000, 100_000), (2_000_000_000, 2), (16_385, 8_192)] {
        let error = load_color("t.png", &png_header(width, height))
            .unwrap_err()
            .to_string();
        assert!(
            error.contains(&format!("{width} x {height} texels: expected 1 to"))
                || error.contains("limit"),
            "{error}"
        );
    }
    // A small EXR whose data window is rewritten to be huge.
    let mut bytes = exr_with(4, 4, Compression::ZIP16, |_, _| (1.0, 1.0, 1.0));
    let name = b"dataWindow\0box2i\0";
    let at = bytes.windows(name.len()).position(|w| w == name).unwrap() + name.len() + 4;
    bytes[at + 8..at + 12].copy_from_slice(&99_999_i32.to_le_bytes());
    bytes[at + 12..at + 16].copy_from_slice(&99_999_i32.to_le_bytes());
    let error = load_sky("s.exr", &bytes).unwrap_err().to_string();
    assert!(error.contains("100000 x 100000 texels"), "{error}");
}

#[test]
fn other_formats_are_named() {
    for bytes in [&b""[..], b"#?RADIANCE\n", b"GIF89a\x01\0\x01\0", b"<svg>"] {
        let error = load_color("t.hdr", bytes).unwrap_err().to_string();
        assert_eq!(
            error,
            "t.hdr: .: not a picture that can be read: expected PNG, JPEG or EXR"
        );
    }
}

#[test]
fn damaged_files_are_errors_or_pictures_but_never_panics() {
    let noise = |x: usize, y: usize| ((x * 7 + y) as f32, (x * y) as f32, 1.0 / (1 + x) as f32);
    let pixels: Vec<[u8; 3]> = (0..300_u32)
        .map(|i| [i as u8, (i * 7) as u8, (i * i) as u8])
        .collect();
    let rgb = DynamicImage::ImageRgb8(RgbImage::from_raw(20, 15, pixels.concat()).unwrap());
    let files = [
        png(&pixels, 20),
        encode(&rgb, ImageFormat::Jpeg),
        exr_with(20, 15, Compression::ZIP16, noise),
        exr_with(20, 15, Compression::PIZ, noise),
        exr_with(20, 15, Compression::RLE, noise),
        exr_with(20, 15, Compression::PXR24, noise),
        exr_with(20, 15, Compression::B44, noise),
    ];
    let mut state = 7_u64;
    let mut random = move |below: usize| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    for file in &files {
        assert!(load_color("t", file).is_ok());
        for length in 0..file.len().min(700) {
            let _ = load_color("t", &file[..length]);
        }
        assert!(load_color("t", &file[..file.len() / 2]).is_err() || file.starts_with(&[0xff]));
        for _ in 0..3000 {
            let mut damaged = file.clone();
            for _ in 0..=random(4) {
                let at = random(damaged.len());
                damaged[at] = random(256) as u8;
            }
            if let Ok(sky) = load_sky("t", &damaged) {
                assert_eq!(
                    sky.rgb.len() as u64,
                    u64::from(sky.width) * u64::from(sky.height)
                );
                assert!(
                    sky.rgb
                        .as_flattened()
                        .iter()
                        .all(|x| x.is_finite() && *x >= 0.0)
                );
            }
        }
    }
}

#[test]
fn a_cloud_is_luminance_times_alpha() {
    let texels = [
        [255, 0, 0, 255],
        [0, 255, 0, 128],
        [255, 255, 255, 0],
        [188; 4],
    ];
    let image = RgbaImage::from_raw(4, 1, texels.concat()).unwrap();
    let bytes = encode(&DynamicImage::ImageRgba8(image), ImageFormat::Png);
    let cloud = load_cloud_image("c.png", &bytes).unwrap();
    assert_eq!((cloud.width, cloud.height, cloud.bad_texels), (4, 1, 0));
    let alpha = |byte: u8| f32::from(byte) / 255.0;
    for (found, expected) in
        cloud
            .density
            .iter()
            .zip([0.2126, 0.7152 * alpha(128), 0.0, linear(188) * alpha(188)])
    {
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
    }
    // EXR: as it is, brighter than 1 too; what is no light is black.
    let bytes = exr_with(2, 1, Compression::ZIP16, |x, _| {
        if x == 0 {
            (8.0, 8.0, 8.0)
        } else {
            (f32::NAN, 1.0, -1.0)
        }
    });
    let cloud = load_cloud_image("c.exr", &bytes).unwrap();
    assert!((cloud.density[0] - 8.0).abs() < 1e-5);
    assert!((cloud.density[1] - 0.7152).abs() < 1e-6);
    assert_eq!(cloud.bad_texels, 1);
}

#[test]
fn a_cloud_of_no_picture_or_too_large_a_one_is_refused() {
    let error = load_cloud_image("c.txt", b"not a picture").unwrap_err();
    assert!(error.to_string().contains("PNG, JPEG or EXR"), "{error}");
    let error = load_cloud_image("c.png", b"\x89PNG\r\n\x1a\nbroken").unwrap_err();
    assert!(error.to_string().contains("c.png"), "{error}");
    // 4097 x 4096 is refused by its header; the rest need not be there.
    let large = DynamicImage::ImageLuma8(GrayImage::new(4097, 4096));
    let bytes = encode(&large, ImageFormat::Png);
    let error = load_cloud_image("c.png", &bytes[..100]).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("4097 x 4096 texels: expected 1 to 16777216"),
        "{error}"
    );
}
