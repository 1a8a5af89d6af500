//! Small scenes, and mean, error and variance of their pictures.

use serde_json::{Value, json};
use shearwater_shared::film::TileFilm;
use shearwater_shared::job::RenderSettings;
use shearwater_shared::plan::TileRect;
use shearwater_shared::scene::parse;
use shearwater_tracer::{Assets, BuildOptions, Scene, render_run};
use std::f64::consts::PI;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

const FLOOR: &str = "v -1e4 0 -1e4\nv -1e4 0 1e4\nv 1e4 0 1e4\nv 1e4 0 -1e4\nf 1 2 3 4\n";

/// The lower half of a sphere of radius 1, open to the sky, its faces inwards.
fn bowl() -> String {
    let (rings, sectors) = (48, 96);
    let mut text = String::from("v 0 -1 0\n");
    for ring in 1..=rings {
        let polar = PI / 2.0 * f64::from(ring) / f64::from(rings);
        for sector in 0..sectors {
            let around = 2.0 * PI * f64::from(sector) / f64::from(sectors);
            let (x, z) = (
                libm::sin(polar) * libm::cos(around),
                libm::sin(polar) * libm::sin(around),
            );
            text += &format!("v {x} {} {z}\n", -libm::cos(polar));
        }
    }
    let at = |ring: i32, sector: i32| 2 + (ring - 1) * sectors + sector % sectors;
    for sector in 0..sectors {
        text += &format!("f 1 {} {}\n", at(1, sector), at(1, sector + 1));
        for ring in 1..rings {
            let (a, b) = (at(ring, sector), at(ring, sector + 1));
            let (c, d) = (at(ring + 1, sector + 1), at(ring + 1, sector));
            text += &format!("f {a} {d} {c} {b}\n");
        }
    }
    text
}

/// A sky of 0.5 with one texel of 40, 45 degrees above the horizon at -z: uneven
/// enough to be sampled, and most of it is darker than its mean.
fn spotted() -> Vec<u8> {
    use exr::prelude::{SpecificChannels, WritableImage};
    let pixel = |at: exr::math::Vec2<usize>| {
        let v = if (at.x(), at.y()) == (8, 2) {
            40.0f32
        } else {
            0.5
        };
        (v, v, v)
    };
    let mut bytes = Vec::new();
    exr::image::Image::from_channels((16, 8), SpecificChannels::rgb(pixel))
        .write()
        .to_buffered(std::io::Cursor::new(&mut bytes))
        .expect("an EXR");
    bytes
}

/// `fields` with the parts that every scene needs; `sampling` as described.
pub(crate) fn scene(side: u32, fields: &Value, sampling: &Value, seed: u64) -> Scene {
    let mut description = json!({
        "version": 1, "name": "test", "image": {"width": side, "height": side},
        "camera": {"position_m": [0, 2, 2], "target_m": [0, 0, 0], "vertical_fov_deg": 20},
        "meshes": {"floor": {"file": "floor.obj"}, "bowl": {"file": "bowl.obj", "normals": "flat"}},
        "sampling": sampling,
    });
    for (name, value) in fields.as_object().into_iter().flatten() {
        description[name] = value.clone();
    }
    let description = parse(description.to_string().as_bytes()).expect("a valid scene");
    let assets: Assets = [
        ("floor.obj", FLOOR.as_bytes().to_vec()),
        ("bowl.obj", bowl().into_bytes()),
        ("spotted.exr", spotted()),
    ]
    .map(|(name, bytes)| (name.to_owned(), Arc::from(bytes)))
    .into();
    let settings = RenderSettings {
        width: side,
        height: side,
        samples: 2,
        seed,
        frames: 1,
        first_frame: 0,
        stop: shearwater_shared::stop::Stop::NONE,
    };
    Scene::build(&description, &assets, &settings, 0, BuildOptions::default())
        .expect("a scene that builds")
        .0
}

/// Both halves' means of the red channel, pixel by pixel.
pub(crate) fn halves(scene: &Scene, side: u32, samples: u32) -> [Vec<f64>; 2] {
    let rect = TileRect {
        x0: 0,
        y0: 0,
        width: side,
        height: side,
    };
    let sums = render_run(scene, &rect, 0..samples, &AtomicBool::new(false)).expect("a run");
    assert_eq!(sums.bad.total(), 0, "{:?}", sums.bad);
    assert_eq!(sums.depth_cap_hits, 0);
    let mut film = TileFilm::zero(rect.pixels());
    film.add(&sums).expect("fits");
    [0, 1].map(|half| {
        (0..rect.pixels())
            .map(|pixel| film.half_mean(half, pixel)[0])
            .collect()
    })
}

/// Mean of the picture, and its standard error from the halves.
pub(crate) fn mean_and_error(scene: &Scene, side: u32, samples: u32) -> (f64, f64) {
    let [a, b] = halves(scene, side, samples);
    let n = a.len() as f64;
    let mean = a.iter().zip(&b).map(|(a, b)| (a + b) / 2.0).sum::<f64>() / n;
    let squares: f64 = a.iter().zip(&b).map(|(a, b)| (a - b) * (a - b) / 4.0).sum();
    (mean, squares.sqrt() / n)
}

/// Variance of a pixel of one half, as the mean over all pixels.
pub(crate) fn variance(scene: &Scene, side: u32, samples: u32) -> f64 {
    let [a, b] = halves(scene, side, samples);
    let squares: f64 = a.iter().zip(&b).map(|(a, b)| (a - b) * (a - b) / 2.0).sum();
    squares / a.len() as f64
}

/// A floor of one material.
pub(crate) fn floor(material: &Value) -> Value {
    json!({"materials": {"m": material}, "instances": [{"mesh": "floor", "material": "m"}]})
}

/// `fields` and those of `more`.
pub(crate) fn with(fields: &Value, more: &Value) -> Value {
    let mut all = fields.clone();
    for (name, value) in more.as_object().into_iter().flatten() {
        all[name] = value.clone();
    }
    all
}
