//! Pictures of textures, skies and clouds, and grids of voxels.

use super::pixel;
use shearwater_shared::scene;
use shearwater_tracer::load::{Encoding, load_cloud_image, load_grid, load_sky, load_texture};

/// Most pixels that a file of an input may announce: large ones are for the tests
/// of the limits, here they would only take time.
const PIXELS_MAX: u64 = 1 << 16;
/// Most pixels of a picture that a scene is built of.
const BUILT_MAX: u32 = 1 << 10;

/// Something to put a texture on.
const MESH: &[u8] =
    b"v -1 0 -1\nv 1 0 -1\nv 1 0 1\nvt 0 0\nvt 3 0\nvt -2 4\nusemtl m\nf 3/1 2/2 1/3\n";

/// A file of any kind.
pub fn images(data: &[u8]) {
    let _ = load_grid("a.vol", "clouds[0]", data);
    if announced(data) > PIXELS_MAX {
        return;
    }
    for encoding in [Encoding::Srgb, Encoding::Linear] {
        if let Ok(texture) = load_texture("a.png", data, encoding) {
            for (u, v) in [(0.0, 0.0), (1.0, 1.0), (-7.3, 0.5), (1e9, f32::NAN)] {
                let rgb = texture.rgb(u, v);
                assert!(rgb.iter().all(|x| (0.0..=1.0).contains(x)), "{rgb:?}");
            }
        }
    }
    if let Ok(cloud) = load_cloud_image("a.png", data) {
        let pixels = cloud.width as usize * cloud.height as usize;
        assert_eq!(cloud.density.len(), pixels);
        assert!(cloud.density.iter().all(|x| x.is_finite() && *x >= 0.0));
    }
    if let Ok(sky) = load_sky("a.png", data) {
        let pixels = sky.width as usize * sky.height as usize;
        assert_eq!(sky.rgb.len(), pixels);
        let mut values = sky.rgb.as_flattened().iter();
        assert!(values.all(|x| x.is_finite() && *x >= 0.0));
        if sky.width * sky.height <= BUILT_MAX {
            build(data);
        }
    }
}

/// The picture as everything that a picture can be.
fn build(data: &[u8]) {
    let scene = br#"{
        "version": 1, "name": "pictures", "image": { "width": 8, "height": 8 },
        "camera": { "position_m": [0, 0.5, 2], "target_m": [0, 0, 0], "vertical_fov_deg": 60 },
        "sky": { "type": "map", "file": "a" },
        "materials": { "m": { "type": "lambert", "albedo": [1, 1, 1], "albedo_texture": "a" } },
        "meshes": { "m": { "file": "m.obj" } }, "instances": [{ "mesh": "m" }],
        "clouds": [{
            "type": "sprites", "count": 20, "sprite_radius_m": [0.1, 0.2], "opacity": [0.2, 0.6],
            "formation": { "type": "image", "file": "a", "centre_m": [0, 1, 0], "width_m": 2, "depth_m": 0.3 }
        }]
    }"#;
    let scene = scene::parse(scene).expect("ours");
    let _ = pixel::render(&scene, &pixel::assets(&[("a", data), ("m.obj", MESH)]), 0);
}

/// How many pixels a file says it has, as far as its head is in its usual place.
fn announced(data: &[u8]) -> u64 {
    let number = |bytes: &[u8]| bytes.iter().fold(0u64, |n, &b| n << 8 | u64::from(b));
    if data.starts_with(b"\x89PNG") {
        let side = |at: usize| data.get(at..at + 4).map_or(0, number);
        return side(16).saturating_mul(side(20));
    }
    if data.starts_with(b"\xff\xd8") {
        // Every marker that may begin a frame, wherever it stands.
        let frames = data.windows(9).filter(|w| {
            w[0] == 0xff && matches!(w[1], 0xc0..=0xcf) && !matches!(w[1], 0xc4 | 0xc8 | 0xcc)
        });
        let pixels = frames.map(|w| number(&w[5..7]) * number(&w[7..9]));
        return pixels.max().unwrap_or(0);
    }
    let window = b"dataWindow\0box2i\0\x10\0\0\0";
    let windows = data
        .windows(window.len() + 16)
        .filter(|w| w.starts_with(window));
    let pixels = windows.map(|w| {
        let numbers: Vec<i64> = w[window.len()..]
            .chunks_exact(4)
            .map(|b| i32::from_le_bytes([b[0], b[1], b[2], b[3]]).into())
            .collect();
        let side = |low: i64, high: i64| (high - low + 1).unsigned_abs();
        side(numbers[0], numbers[2]).saturating_mul(side(numbers[1], numbers[3]))
    });
    pixels.max().unwrap_or(0)
}
