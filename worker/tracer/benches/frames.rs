//! What a second frame costs: `Stage::build` against `Stage::frame`.
//!
//! `cargo bench --bench frames -- SCENE.json` (default: golden-gate and, if it is
//! there, fly-past).

use shearwater_shared::job::RenderSettings;
use shearwater_shared::scene::{parse, references};
use shearwater_tracer::{Assets, BuildOptions, Stage};
use std::path::{Path, PathBuf};
use std::time::Instant;

fn main() {
    let given: Vec<PathBuf> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with('-'))
        .map(Into::into)
        .collect();
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let default = ["golden-gate", "fly-past"].map(|s| scenes.join(s).join("scene.json"));
    let paths = if given.is_empty() {
        default.to_vec()
    } else {
        given
    };
    for path in paths.iter().filter(|p| p.exists()) {
        measure(path);
    }
}

fn measure(path: &Path) {
    let bytes = std::fs::read(path).expect("a scene");
    let description = parse(&bytes).expect("a valid scene");
    let assets = read_assets(path, description.files().into_iter().collect());
    let settings = RenderSettings {
        width: 1024,
        height: 512,
        samples: 64,
        seed: 0,
        frames: 1,
        first_frame: 0,
        stop: shearwater_shared::stop::Stop::NONE,
    };
    let start = Instant::now();
    let (stage, _) = Stage::build(&description, &assets, BuildOptions::default()).expect("builds");
    let built = start.elapsed().as_secs_f64() * 1e3;
    let mut times: Vec<f64> = (0..15)
        .map(|frame| {
            let start = Instant::now();
            stage.frame(&settings, frame).expect("a frame");
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    let median = times[times.len() / 2];
    println!(
        "{}: stage {built:.0} ms, frame {median:.2} ms (median of {}), {:.2} %",
        path.display(),
        times.len(),
        100.0 * median / built
    );
}

/// Files and the files that they name.
fn read_assets(scene: &Path, mut wanted: Vec<String>) -> Assets {
    let folder = scene.parent().expect("a folder");
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
