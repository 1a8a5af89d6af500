//! The scenes, each as a file and changes to it.

use exr::prelude::{SpecificChannels, WritableImage};
use serde_json::{Value, json};
use shearwater_shared::scene::{parse, references};
use shearwater_tracer::{Assets, BuildOptions, Stage};
use std::path::{Path, PathBuf};

/// A scene to measure.
pub(crate) struct Case {
    /// For people and for `--scenes`.
    pub(crate) name: &'static str,
    file: PathBuf,
    patch: Value,
}

/// A file that this program makes: see [`lamp_sky`].
const LAMP_SKY: &str = "lamp-sky.exr";

/// All of them.
pub(crate) fn all() -> Vec<Case> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let case = |name, file: &str, patch| Case {
        name,
        file: folder.join(file),
        patch,
    };
    let clay = json!({"type": "lambert", "albedo": [0.6, 0.6, 0.6]});
    // The bridge and its headland, all diffuse.
    let bridge = json!({"materials": {"clay": clay}, "water": null,
        "meshes": {"bridge": {"materials": {"paint": "clay"}}},
        "instances": [{"mesh": "bridge", "material": "clay", "translate_m": [230, 0, -1000], "rotate_deg": [0, 35, 0]},
            {"mesh": "headland", "material": "clay"}]});
    let with = |more: Value| {
        let mut all = bridge.clone();
        merge(&mut all, &more);
        all
    };
    vec![
        case("golden-gate", "golden-gate/scene.json", Value::Null),
        case("metal", "metal/scene.json", Value::Null),
        case("volume", "clouds/volume.json", Value::Null),
        case(
            "map",
            "sun/environment.json",
            json!({"sun": null, "sky": {"file": LAMP_SKY}}),
        ),
        case("diffuse", "sun/environment.json", bridge.clone()),
        case(
            "diffuse-map",
            "sun/environment.json",
            with(json!({"sun": null, "sky": {"file": LAMP_SKY}})),
        ),
        case(
            "diffuse-overcast",
            "sun/environment.json",
            with(json!({"sun": null, "sky": {"file": "../skies/assets/overcast.exr"}})),
        ),
    ]
}

/// The case with a further merge patch, built.
pub(crate) fn stage(case: &Case, patch: &Value) -> Result<Stage, String> {
    let text = std::fs::read(&case.file).map_err(|e| format!("{}: {e}", case.file.display()))?;
    let mut scene: Value = serde_json::from_slice(&text).map_err(|e| e.to_string())?;
    merge(&mut scene, &case.patch);
    merge(&mut scene, patch);
    let description = parse(scene.to_string().as_bytes()).map_err(|e| e.to_string())?;
    let mut assets = read_assets(&case.file, description.files().into_iter().collect());
    assets.insert(LAMP_SKY.to_owned(), lamp_sky()?.into());
    Stage::build(&description, &assets, BuildOptions::default())
        .map(|(stage, _)| stage)
        .map_err(|e| e.to_string())
}

// JSON merge patch, RFC 7396.
fn merge(target: &mut Value, patch: &Value) {
    let Value::Object(fields) = patch else {
        return;
    };
    for (name, value) in fields {
        match value {
            Value::Null => {
                target.as_object_mut().map(|t| t.remove(name));
            }
            Value::Object(_) if target[name].is_object() => merge(&mut target[name], value),
            _ => target[name] = value.clone(),
        }
    }
}

/// A blue sky that brightens to the horizon, over dark ground, with a hazy sun of
/// some 3 degrees that gives two thirds of the light: a map with a contrast of 200.
fn lamp_sky() -> Result<Vec<u8>, String> {
    let (width, height) = (512usize, 256usize);
    let pixel = |at: exr::math::Vec2<usize>| {
        let elevation = 90.0 - (at.y() as f64 + 0.5) * 180.0 / height as f64;
        let azimuth = (at.x() as f64 + 0.5) * 360.0 / width as f64 - 180.0;
        if elevation < 0.0 {
            return (0.05f32, 0.05, 0.05);
        }
        let (up, across) = (
            elevation - 40.0,
            (azimuth - 50.0) * libm::cos(elevation.to_radians()),
        );
        let glow = 600.0 * libm::exp(-(up * up + across * across) / (2.0 * 1.5 * 1.5));
        let haze = libm::exp(-elevation / 15.0);
        let value = |blue: f64| (0.3 * blue + 0.8 * haze + glow) as f32;
        (value(0.5), value(0.8), value(1.5))
    };
    let mut bytes = Vec::new();
    exr::image::Image::from_channels((width, height), SpecificChannels::rgb(pixel))
        .write()
        .to_buffered(std::io::Cursor::new(&mut bytes))
        .map_err(|e| e.to_string())?;
    Ok(bytes)
}

// Files and the files that they name.
fn read_assets(scene: &Path, mut wanted: Vec<String>) -> Assets {
    let folder = scene.parent().unwrap_or(Path::new("."));
    let mut assets = Assets::new();
    while let Some(name) = wanted.pop() {
        if assets.contains_key(&name) {
            continue;
        }
        let Ok(bytes) = std::fs::read(folder.join(&name)) else {
            continue;
        };
        let named = match Path::new(&name).extension().and_then(|e| e.to_str()) {
            Some("obj") => references::obj_libraries(&bytes),
            Some("mtl") => references::mtl_textures(&bytes),
            _ => Vec::new(),
        };
        let named = named.iter().map(|inner| references::resolve(&name, inner));
        wanted.extend(named);
        assets.insert(name, bytes.into());
    }
    assets
}
