//! One scene for each effect, for counting instructions: `tests/cost` runs this
//! under callgrind and makes the table in docs/cost.md.
//!
//! `cost` alone lists the scenes; `cost NAME` renders one of them, always the same
//! samples, and says how many.

use serde_json::{Value, json};
use shearwater_shared::job::RenderSettings;
use shearwater_shared::plan::TileRect;
use shearwater_shared::scene::parse;
use shearwater_tracer::{Assets, BuildOptions, Scene, render_run};
use std::f64::consts::TAU;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

const WIDTH: u32 = 64;
const HEIGHT: u32 = 32;
/// Samples of each half: enough for every kind of path, few enough for callgrind.
const SAMPLES: u32 = 8;

fn main() {
    // `cargo bench` passes --bench.
    let name = std::env::args().skip(1).find(|arg| !arg.starts_with("--"));
    let Some(name) = name else {
        for (name, _) in effects() {
            println!("{name}");
        }
        return;
    };
    match effects().into_iter().find(|(known, _)| *known == name) {
        Some((_, scene)) => match render(&scene) {
            Ok(()) => println!("samples {}", WIDTH * HEIGHT * 2 * SAMPLES),
            Err(why) => fail(&why),
        },
        None => fail(&format!("no scene `{name}`")),
    }
}

fn fail(why: &str) {
    eprintln!("error: {why}");
    std::process::exit(1);
}

fn render(scene: &Value) -> Result<(), String> {
    let description = parse(scene.to_string().as_bytes()).map_err(|e| e.to_string())?;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut assets = Assets::new();
    for name in description.files() {
        let path = folder.join(&name);
        let bytes = if name == BALL {
            ball().into_bytes()
        } else {
            std::fs::read(&path).map_err(|e| format!("{}: {e}", path.display()))?
        };
        assets.insert(name, Arc::from(bytes));
    }
    let settings = RenderSettings {
        width: WIDTH,
        height: HEIGHT,
        samples: 2 * SAMPLES,
        seed: 0,
        frames: 1,
        first_frame: 0,
        stop: shearwater_shared::stop::Stop::NONE,
    };
    let options = BuildOptions::default();
    let (scene, _) =
        Scene::build(&description, &assets, &settings, 0, options).map_err(|e| e.to_string())?;
    let rect = TileRect {
        x0: 0,
        y0: 0,
        width: WIDTH,
        height: HEIGHT,
    };
    render_run(&scene, &rect, 0..SAMPLES, &AtomicBool::new(false))
        .map(|_| ())
        .ok_or_else(|| "this build has no effects".to_owned())
}

/// A textured mesh under a constant sky, and that with one effect more each.
fn effects() -> Vec<(&'static str, Value)> {
    let with = |changes: Value| {
        let mut scene = plain();
        for (field, value) in changes.as_object().into_iter().flatten() {
            scene[field] = value.clone();
        }
        scene
    };
    let material = |skin: Value| with(json!({"materials": {"skin": skin}}));
    let instance = |more: Value| {
        let mut instance = json!({"mesh": "ball", "material": "skin"});
        for (field, value) in more.as_object().into_iter().flatten() {
            instance[field] = value.clone();
        }
        with(json!({"camera": shutter(&json!({})), "instances": [instance]}))
    };
    let core = json!({"type": "radial", "centre_m": [0, 0, 0], "radii_m": [6, 3, 6],
        "direction": [1, 0, 0], "length_m": 1});
    let volume = |method: Value| {
        with(
            json!({"clouds": [{"type": "volume", "sigma_t_per_m": 0.3, "method": method,
            "shape": {"type": "ellipsoid", "centre_m": [0, 0, 0], "radii_m": [6, 3, 6],
                "resolution": 64, "edge": 0.3, "noise": {"scale_m": 3}}}]}),
        )
    };
    vec![
        ("plain", plain()),
        ("sun", with(json!({"sun": sun()}))),
        (
            "sky map",
            with(json!({"sky": {"type": "map", "file": SKY}})),
        ),
        (
            "dome",
            with(
                json!({"sky": {"type": "dome", "file": SKY, "centre_m": [0, 0, 0],
            "radius_m": 100}}),
            ),
        ),
        (
            "atmosphere and its sun",
            with(json!({"sky": {"type": "atmosphere"},
            "sun": {"azimuth_deg": 30, "elevation_deg": 20}})),
        ),
        (
            "lens",
            with(json!({"camera": shutter(&json!({"lens_radius_m": 0.1}))})),
        ),
        (
            "phong",
            material(
                json!({"type": "phong", "kd": [0.5, 0.5, 0.5], "ks": [0.4, 0.4, 0.4],
            "exponent": 50, "kd_texture": LIVERY}),
            ),
        ),
        (
            "metal by complex index",
            material(json!({"type": "ggx", "roughness": 0.3,
            "base_color_texture": LIVERY, "conductor": {"n": [1.3, 1, 0.6], "k": [7.5, 6.5, 5.3]}})),
        ),
        (
            "metal under a coat",
            material(json!({"type": "ggx", "roughness": 0.3,
            "base_color_texture": LIVERY, "metalness": 0.9, "coat": {}})),
        ),
        (
            "flat water",
            with(json!({"water": {"type": "flat", "height_m": -3}})),
        ),
        (
            "Gerstner water",
            with(
                json!({"water": {"type": "gerstner", "height_m": -3, "waves": [
            {"amplitude_m": 0.2, "wavelength_m": 9, "direction_deg": 20},
            {"amplitude_m": 0.1, "wavelength_m": 5, "direction_deg": 60},
            {"amplitude_m": 0.05, "wavelength_m": 3, "direction_deg": 100},
            {"amplitude_m": 0.03, "wavelength_m": 2, "direction_deg": 0},
            {"amplitude_m": 0.02, "wavelength_m": 1, "direction_deg": 40}]}}),
            ),
        ),
        (
            "Tessendorf water",
            with(json!({"water": {"type": "tessendorf", "height_m": -3,
            "tile_m": 50, "wind_speed_mps": 6}})),
        ),
        (
            "particles, 1000",
            with(
                json!({"clouds": [{"type": "particles", "formation": core.clone(),
            "count": 1000, "particle_radius_m": [0.3, 0.6], "opacity": [0.1, 0.3]}]}),
            ),
        ),
        (
            "sprites, 1000",
            with(json!({"clouds": [{"type": "sprites", "formation": core,
            "count": 1000, "sprite_radius_m": [0.3, 0.6], "opacity": [0.1, 0.3]}]})),
        ),
        ("volume, tracking", volume(json!({"type": "tracking"}))),
        (
            "volume, steps of 0.2 m",
            volume(json!({"type": "march", "step_m": 0.2})),
        ),
        (
            "moving camera",
            with(json!({"camera": shutter(&json!({"velocity_mps": [5, 0, 0]}))})),
        ),
        (
            "moving instance",
            instance(json!({"velocity_mps": [5, 0, 0]})),
        ),
        (
            "spinning instance",
            instance(json!({"spin": {"axis": [0, 0, 1], "rpm": 600}})),
        ),
    ]
}

const BALL: &str = "ball.obj";

/// A ball of radius 4 m with texture coordinates: some 4000 triangles.
fn ball() -> String {
    const ROWS: u32 = 32;
    const COLUMNS: u32 = 64;
    let turn = |share: f64| (libm::sin(share * TAU), libm::cos(share * TAU));
    let mut text = String::from("usemtl skin\n");
    for row in 0..=ROWS {
        let v = f64::from(row) / f64::from(ROWS);
        let (ring, y) = turn(v / 2.0);
        for column in 0..=COLUMNS {
            let u = f64::from(column) / f64::from(COLUMNS);
            let (x, z) = turn(u);
            let (x, y, z) = (4.0 * ring * x, 4.0 * y, 4.0 * ring * z);
            text += &format!("v {x:.5} {y:.5} {z:.5}\nvt {u:.5} {v:.5}\n");
        }
    }
    for row in 0..ROWS {
        for column in 0..COLUMNS {
            let a = row * (COLUMNS + 1) + column + 1;
            let (b, c, d) = (a + 1, a + COLUMNS + 2, a + COLUMNS + 1);
            text += &format!("f {a}/{a} {d}/{d} {c}/{c} {b}/{b}\n");
        }
    }
    text
}

const SKY: &str = "golden-gate/assets/sky.exr";
const LIVERY: &str = "golden-gate/assets/livery.png";

fn sun() -> Value {
    json!({"azimuth_deg": 30, "elevation_deg": 20, "radiance": [20000, 15000, 10000]})
}

/// The camera, its shutter open for a hundredth of a second, with something more.
fn shutter(more: &Value) -> Value {
    let mut camera = plain()["camera"].clone();
    camera["shutter_s"] = json!(0.01);
    for (field, value) in more.as_object().into_iter().flatten() {
        camera[field] = value.clone();
    }
    camera
}

fn plain() -> Value {
    json!({
        "version": 1, "name": "plain", "image": {"width": WIDTH, "height": HEIGHT},
        "camera": {"position_m": [9, 3, -16], "target_m": [0, 0, 0], "vertical_fov_deg": 30},
        "materials": {"skin": {"type": "ggx", "roughness": 0.3, "metalness": 0.3,
            "base_color_texture": LIVERY}},
        "meshes": {"ball": {"file": BALL}},
        "instances": [{"mesh": "ball", "material": "skin"}],
        "sky": {"type": "constant", "radiance": [0.6, 0.8, 1.0]}
    })
}
