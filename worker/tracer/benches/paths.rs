//! Camera paths per second of one thread on a scene's own picture, with and
//! without its clouds: `cargo bench -p shearwater-tracer --bench paths`.
//! SCENE names another scene.json, SAMPLES the samples per half.

use shearwater_shared::film::{TileFilm, estimate_error, film_hash};
use shearwater_shared::job::RenderSettings;
use shearwater_shared::plan::Plan;
use shearwater_shared::scene::{SceneDescription, parse, references};
use shearwater_tracer::{Assets, BuildOptions, Scene, render_run};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

fn main() {
    let default = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/golden-gate/scene.json");
    let path = std::env::var_os("SCENE").map_or(default, PathBuf::from);
    let samples: u32 = std::env::var("SAMPLES")
        .ok()
        .and_then(|s| s.parse().ok())
        .unwrap_or(8);
    let Ok(bytes) = std::fs::read(&path) else {
        println!("{} is not there: nothing to measure", path.display());
        return;
    };
    let full = match parse(&bytes) {
        Ok(scene) => scene,
        Err(error) => return println!("{error}"),
    };
    let assets = read_assets(&full, path.parent().unwrap_or(Path::new(".")));
    let bare = SceneDescription {
        clouds: Vec::new(),
        ..full.clone()
    };
    let rounds = std::env::var("ROUNDS")
        .ok()
        .and_then(|r| r.parse().ok())
        .unwrap_or(2);
    for round in 0..rounds {
        for (name, scene) in [("with clouds", &full), ("without clouds", &bare)] {
            measure(name, scene, &assets, samples, round);
        }
    }
}

fn measure(name: &str, description: &SceneDescription, assets: &Assets, samples: u32, round: u32) {
    let (width, height) = (description.image.width, description.image.height);
    let settings = RenderSettings {
        width,
        height,
        samples: 2 * samples,
        seed: 0,
        frames: 1,
        first_frame: 0,
        stop: shearwater_shared::stop::Stop::NONE,
    };
    let start = Instant::now();
    let scene = match Scene::build(description, assets, &settings, 0, BuildOptions::default()) {
        Ok((scene, _)) => scene,
        Err(error) => return println!("{error}"),
    };
    let build_s = start.elapsed().as_secs_f64();
    let plan = Plan::new(&settings);
    let cancel = AtomicBool::new(false);
    let start = thread_cpu_s();
    let mut films = Vec::new();
    for rect in (0..plan.tiles()).filter_map(|tile| plan.tile_rect(tile)) {
        if let Some(sums) = render_run(&scene, &rect, 0..samples, &cancel) {
            let mut film = TileFilm::zero(rect.pixels());
            film.add(&sums).expect("one size");
            films.push(film);
        }
    }
    let paths = f64::from(width) * f64::from(height) * f64::from(2 * samples);
    let seconds = thread_cpu_s() - start;
    let rate = paths / seconds / 1e6;
    let nmse = estimate_error((0..).zip(&films)).map_or(0.0, |e| e.nmse);
    let hash = film_hash(&plan, |tile| &films[tile as usize]).expect("whole");
    println!(
        "round {round}, {name}: {rate:.3} M paths/s, NMSE {nmse:.4e}, efficiency {:.3} (build {build_s:.2} s, film {hash:.8})",
        1.0 / (nmse * seconds)
    );
}

// Seconds that this thread has run on a core: other programs on the machine cost
// less this way than by the wall clock (Linux: first number of schedstat, in ns).
fn thread_cpu_s() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split(' ')
        .next()
        .and_then(|ns| ns.parse::<f64>().ok())
        .unwrap_or(0.0)
        / 1e9
}

fn read_assets(scene: &SceneDescription, folder: &Path) -> Assets {
    let mut assets = Assets::new();
    let mut wanted: Vec<String> = scene.files().into_iter().collect();
    while let Some(name) = wanted.pop() {
        if assets.contains_key(&name) {
            continue;
        }
        let Ok(bytes) = std::fs::read(folder.join(&name)) else {
            continue;
        };
        if name.ends_with(".obj") {
            wanted.extend(
                references::obj_libraries(&bytes)
                    .iter()
                    .map(|m| references::resolve(&name, m)),
            );
        } else if name.ends_with(".mtl") {
            wanted.extend(
                references::mtl_textures(&bytes)
                    .iter()
                    .map(|m| references::resolve(&name, m)),
            );
        }
        assets.insert(name, Arc::from(bytes));
    }
    assets
}
