//! Small scenes and what is measured of them.
#![allow(dead_code, reason = "each test binary uses its own part")]

use shearwater_shared::film::{TileFilm, TileSums};
use shearwater_shared::job::RenderSettings;
use shearwater_shared::plan::TileRect;
use shearwater_shared::scene::parse;
use shearwater_tracer::{Assets, BuildOptions, Scene, render_run};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

pub(crate) const SIDE: u32 = 16;
pub(crate) const RECT: TileRect = TileRect {
    x0: 0,
    y0: 0,
    width: SIDE,
    height: SIDE,
};
pub(crate) const FLOOR: &str =
    "v -1e4 0 -1e4\nv -1e4 0 1e4\nv 1e4 0 1e4\nv 1e4 0 -1e4\nf 1 2 3 4\n";

/// The same square, its shading normals 45 degrees towards +x.
pub(crate) const LEANING: &str =
    "v -1e4 0 -1e4\nv -1e4 0 1e4\nv 1e4 0 1e4\nv 1e4 0 -1e4\nvn 1 1 0\nf 1//1 2//1 3//1 4//1\n";

/// The lower half of a sphere of radius 1, open to the sky, its faces inwards.
pub(crate) fn bowl() -> Vec<u8> {
    let (rings, sectors) = (48, 96);
    let mut text = String::from("v 0 -1 0\n");
    for ring in 1..=rings {
        let polar = std::f64::consts::FRAC_PI_2 * f64::from(ring) / f64::from(rings);
        for sector in 0..sectors {
            let around = 2.0 * std::f64::consts::PI * f64::from(sector) / f64::from(sectors);
            let (x, z) = (
                libm::sin(polar) * libm::cos(around),
                libm::sin(polar) * libm::sin(around),
            );
            text.push_str(&format!("v {x} {} {z}\n", -libm::cos(polar)));
        }
    }
    let at = |ring: i32, sector: i32| 2 + (ring - 1) * sectors + sector % sectors;
    for sector in 0..sectors {
        text.push_str(&format!("f 1 {} {}\n", at(1, sector), at(1, sector + 1)));
        for ring in 1..rings {
            let (a, b) = (at(ring, sector), at(ring, sector + 1));
            let (c, d) = (at(ring + 1, sector + 1), at(ring + 1, sector));
            text.push_str(&format!("f {a} {d} {c} {b}\n"));
        }
    }
    text.into_bytes()
}

/// A dim sky with one bright texel 45 degrees above the horizon at -z.
pub(crate) fn lamp() -> Vec<u8> {
    use exr::prelude::{SpecificChannels, WritableImage};
    let (width, height) = (LAMP_SIZE[0], LAMP_SIZE[1]);
    let pixel = |at: exr::math::Vec2<usize>| {
        let v = if [at.x(), at.y()] == LAMP_TEXEL {
            LAMP_RADIANCE
        } else {
            0.1
        };
        (v, v, v)
    };
    let mut bytes = Vec::new();
    let channels = SpecificChannels::rgb(pixel);
    let image = exr::image::Image::from_channels((width, height), channels);
    image
        .write()
        .to_buffered(std::io::Cursor::new(&mut bytes))
        .expect("an EXR");
    bytes
}

pub(crate) const LAMP_SIZE: [usize; 2] = [64, 32];
pub(crate) const LAMP_TEXEL: [usize; 2] = [32, 7];
pub(crate) const LAMP_RADIANCE: f32 = 2000.0;

/// A scene of `body` (JSON members) seen by a camera of `fov` degrees at `eye`
/// that looks at `target`; `floor.obj` is a square of 20 km at y = 0.
pub(crate) fn scene(
    body: &str,
    eye: [f64; 3],
    target: [f64; 3],
    fov: f64,
    seed: u64,
    options: BuildOptions,
) -> Scene {
    let up = if eye[0] == target[0] && eye[2] == target[2] {
        "[0,0,-1]"
    } else {
        "[0,1,0]"
    };
    let json = format!(
        r#"{{"version":1,"name":"test","image":{{"width":{SIDE},"height":{SIDE}}},
        "camera":{{"position_m":{eye:?},"target_m":{target:?},"up":{up},"vertical_fov_deg":{fov:?},"shutter_s":0.01}},
        "meshes":{{"floor":{{"file":"floor.obj"}},"bowl":{{"file":"bowl.obj","normals":"flat"}},
        "leaning":{{"file":"leaning.obj"}}}},{body}}}"#
    );
    let description = parse(json.as_bytes()).expect("a valid scene");
    let files = [
        ("floor.obj", FLOOR.as_bytes().to_vec()),
        ("leaning.obj", LEANING.as_bytes().to_vec()),
        ("bowl.obj", bowl()),
        ("lamp.exr", lamp()),
    ];
    let assets: Assets = files
        .map(|(name, bytes)| (name.to_owned(), Arc::from(bytes)))
        .into();
    let settings = RenderSettings {
        width: SIDE,
        height: SIDE,
        samples: 2,
        seed,
        frames: 1,
        first_frame: 0,
        stop: shearwater_shared::stop::Stop::NONE,
    };
    Scene::build(&description, &assets, &settings, 0, options)
        .expect("a scene that builds")
        .0
}

pub(crate) fn sums(scene: &Scene, samples: std::ops::Range<u32>) -> TileSums {
    let sums =
        render_run(scene, &RECT, samples.clone(), &AtomicBool::new(false)).expect("not cancelled");
    sums.check(&RECT, &samples)
        .expect("sums of the right shape");
    assert_eq!(sums.bad.total(), 0, "{:?}", sums.bad);
    sums
}

/// Mean of the red channel and its standard error, the latter from the halves.
pub(crate) fn mean_and_error(scene: &Scene, samples: u32) -> (f64, f64) {
    let mut film = TileFilm::zero(RECT.pixels());
    film.add(&sums(scene, 0..samples)).expect("fits");
    let pixels = RECT.pixels();
    let (mut mean, mut variance) = (0.0, 0.0);
    for pixel in 0..pixels {
        let (a, b) = (film.half_mean(0, pixel)[0], film.half_mean(1, pixel)[0]);
        mean += (a + b) / 2.0;
        variance += (a - b) * (a - b) / 4.0;
    }
    (mean / pixels as f64, variance.sqrt() / pixels as f64)
}

// Five standard errors: one false alarm in 2 million; seeds are fixed besides.
pub(crate) fn assert_mean(what: &str, scene: &Scene, samples: u32, expected: f64) {
    let (mean, error) = mean_and_error(scene, samples);
    let tolerance = 5.0 * error + 1e-4 * expected;
    assert!(
        (mean - expected).abs() <= tolerance,
        "{what}: {mean} +- {error}, expected {expected}"
    );
    assert!(
        error < 0.02 * expected.max(0.05),
        "{what}: too noisy to tell, {error}"
    );
}

pub(crate) const WHITE_SKY: &str = r#""sky":{"type":"constant","radiance":[1,1,1]}"#;

pub(crate) fn floor(material: &str) -> String {
    format!(r#""materials":{{"m":{material}}},"instances":[{{"mesh":"floor","material":"m"}}]"#)
}

/// A ball of particles, without count, opacity and albedo.
pub(crate) const CLOUD: &str = r#""type":"particles","formation":{"type":"radial","centre_m":[0,0,0],"radii_m":[2,2,2],"direction":[1,0,0],"length_m":1},"particle_radius_m":[0.5,1.5]"#;
