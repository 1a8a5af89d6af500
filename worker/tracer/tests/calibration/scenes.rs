//! Small scenes of every kind of noise.

use crate::common::{CLOUD, FLOOR, bowl, lamp};
use shearwater_shared::plan::TileRect;
use shearwater_shared::scene::{SceneDescription, parse, references};
use shearwater_tracer::{Assets, BuildOptions, Stage};
use std::path::Path;
use std::sync::Arc;

/// Side of the pictures in pixels.
pub(crate) const SIDE: u32 = 24;

/// A square of a picture of a scene.
pub(crate) struct View {
    pub(crate) stage: Stage,
    /// Of the whole picture.
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// The square, of [`SIDE`] pixels.
    pub(crate) rect: TileRect,
}

/// Every scene with its name.
pub(crate) fn all() -> Vec<(&'static str, View)> {
    vec![
        ("golden-gate", golden_gate()),
        ("glossy", glossy()),
        ("volume", volume()),
        ("particles", particles()),
        ("diffuse", diffuse("")),
    ]
}

/// The bowl that only chance hits light: fireflies.
pub(crate) fn chance_hits() -> View {
    diffuse(r#""sampling":{"mis":"scattering_only"},"#)
}

/// A bowl under a sky with a small lamp, light from its other side included.
fn diffuse(more: &str) -> View {
    let body = format!(
        r#"{more}"materials":{{"m":{{"type":"lambert","albedo":[0.7,0.5,0.3]}}}},
        "instances":[{{"mesh":"bowl","material":"m"}}],"sky":{{"type":"map","file":"lamp.exr"}}"#
    );
    small(&body, [0.0, 2.5, 0.3], [0.0, -0.5, 0.0], 40.0)
}

/// A polished dome on a smooth floor, sky with a lamp, sun.
fn glossy() -> View {
    let body = format!(
        r#""materials":{{"m":{{"type":"ggx","base_color":[0.6,0.3,0.1],"roughness":0.3}},
        "f":{{"type":"ggx","base_color":[0.4,0.4,0.4],"metalness":0.3,"roughness":0.4}}}},
        "instances":[{{"mesh":"bowl","material":"m","rotate_deg":[180,0,0]}},{{"mesh":"floor","material":"f"}}],
        "sky":{{"type":"map","file":"lamp.exr"}},{SUN}"#
    );
    small(&body, [0.0, 2.5, 4.0], [0.0, 0.4, 0.0], 35.0)
}

const SUN: &str = r#""sun":{"azimuth_deg":60,"elevation_deg":30,"radiance":[20000,16000,12000]}"#;
const EVEN_SKY: &str = r#""sky":{"type":"constant","radiance":[0.4,0.6,1]}"#;

/// A cloud of many scatterings over a floor.
fn volume() -> View {
    let body = format!(
        r#""clouds":[{{"type":"volume","shape":{{"type":"ellipsoid","centre_m":[0,0,0],"radii_m":[2,1,1.5],
        "edge":0.5,"resolution":32,"noise":{{"scale_m":1.3,"seed":4}}}},"sigma_t_per_m":4,"g":0.5,
        "albedo":[0.99,0.98,0.97]}}],{EVEN_SKY},{SUN},
        "materials":{{"m":{{"type":"lambert","albedo":[0.5,0.5,0.5]}}}},
        "instances":[{{"mesh":"floor","material":"m","translate_m":[0,-2,0]}}]"#
    );
    small(&body, [0.0, 2.0, 6.0], [0.0, -0.3, 0.0], 40.0)
}

/// A cloud of semi-opaque particles.
fn particles() -> View {
    let body =
        format!(r#""clouds":[{{{CLOUD},"count":300,"opacity":[0.1,0.4]}}],{EVEN_SKY},{SUN}"#);
    small(&body, [0.0, 1.0, 7.0], [0.0; 3], 40.0)
}

fn small(body: &str, eye: [f64; 3], target: [f64; 3], fov: f64) -> View {
    let json = format!(
        r#"{{"version":1,"name":"test","image":{{"width":{SIDE},"height":{SIDE}}},
        "camera":{{"position_m":{eye:?},"target_m":{target:?},"vertical_fov_deg":{fov:?}}},
        "meshes":{{"floor":{{"file":"floor.obj"}},"bowl":{{"file":"bowl.obj","normals":"flat"}}}},{body}}}"#
    );
    let description = parse(json.as_bytes()).expect("a valid scene");
    let files = [
        ("floor.obj", FLOOR.as_bytes().to_vec()),
        ("bowl.obj", bowl()),
        ("lamp.exr", lamp()),
    ];
    let assets = files.map(|(name, bytes)| (name.to_owned(), Arc::from(bytes)));
    view(build(&description, &assets.into()), (SIDE, SIDE), (0, 0))
}

fn view(stage: Stage, (width, height): (u32, u32), (x0, y0): (u32, u32)) -> View {
    let rect = TileRect {
        x0,
        y0,
        width: SIDE,
        height: SIDE,
    };
    View {
        stage,
        width,
        height,
        rect,
    }
}

/// An aircraft before water, clouds and sky. Not the sun: a pixel that it is in holds
/// all the light and all the error, and one pixel says nothing about calibration.
fn golden_gate() -> View {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/golden-gate");
    let read = |name: &str| std::fs::read(folder.join(name)).expect("a file of the scene");
    let description = parse(&read("scene.json")).expect("a valid scene");
    let mut assets = Assets::new();
    let mut wanted: Vec<String> = description.files().into_iter().collect();
    while let Some(name) = wanted.pop() {
        let bytes = read(&name);
        if name.ends_with(".obj") {
            let libraries = references::obj_libraries(&bytes);
            wanted.extend(libraries.iter().map(|m| references::resolve(&name, m)));
        } else if name.ends_with(".mtl") {
            let textures = references::mtl_textures(&bytes);
            wanted.extend(textures.iter().map(|t| references::resolve(&name, t)));
        }
        assets.insert(name, Arc::from(bytes));
    }
    view(build(&description, &assets), (256, 128), (172, 60))
}

fn build(description: &SceneDescription, assets: &Assets) -> Stage {
    let built = Stage::build(description, assets, BuildOptions::default());
    built.expect("a scene that builds").0
}
