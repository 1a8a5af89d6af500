//! The scenes of scenes/checks, which carry the radiance that must come out.

use crate::table::{Case, Form, Row, Section};
use serde_json::Value;
use shearwater_shared::film::TileFilm;
use shearwater_shared::job::RenderSettings;
use shearwater_shared::plan::TileRect;
use shearwater_shared::scene::{SceneDescription, parse, references};
use shearwater_tracer::{Assets, BuildOptions, Scene, render_run};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

static SECTION: Section = Section::new(
    "Scenes that carry their radiance",
    &[Case {
        name: "scenes/checks",
        note: "Rendered from their files as any scene is; `expected.json` beside each says where each value comes from. Places \
               are pixels: left, top, right, bottom. `shearwater render scenes/checks/NAME` shows them.",
        broken_by: "each in its own scene: the ball's box instead of the ball (absorbing sphere), 1e-6 added to a map's radiance (black map, \
                    dome), the discriminant as b^2 - 4 a c (far sphere), one particle less (furnace), the sine left out of the samples' \
                    density (hot texel), the test of the geometric normal left out of the value (light below), times of 0.9 of the \
                    shutter (moving edge), corners that move straight (propeller), collisions at the middle of a free path (slab), \
                    the sun's cone twice as wide (sun), walks that end after 64 walls (thousand layers)",
        rows: all,
    }],
);

#[test]
fn checks() {
    SECTION.check();
}

/// What a part of a picture must show.
struct Expected {
    /// Left, top, right, bottom in pixels; the last two are beyond.
    region: [u32; 4],
    radiance: [f64; 3],
    /// How far the value may lie off beside what noise does.
    tolerance: f64,
}

impl Expected {
    fn read(value: &Value) -> Self {
        let number = |v: &Value| v.as_f64().expect("a number");
        let radiance = match &value["radiance"] {
            Value::Array(rgb) => [0, 1, 2].map(|i| number(&rgb[i])),
            grey => [number(grey); 3],
        };
        assert!(
            value["reason"]
                .as_str()
                .is_some_and(|text| !text.is_empty())
        );
        Self {
            region: [0, 1, 2, 3].map(|i| number(&value["region"][i]) as u32),
            radiance,
            tolerance: number(&value["tolerance"]),
        }
    }
}

fn all(form: Form) -> Vec<Row> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/checks");
    let mut folders: Vec<PathBuf> = std::fs::read_dir(&root)
        .expect("scenes/checks")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.join("scene.json").exists())
        .collect();
    folders.sort();
    assert!(folders.len() >= 12, "{folders:?}");
    folders
        .iter()
        .flat_map(|folder| check(folder, form))
        .collect()
}

fn check(folder: &Path, form: Form) -> Vec<Row> {
    let read = |name: &str| std::fs::read(folder.join(name)).expect(name);
    let description = parse(&read("scene.json")).expect("a valid scene");
    let expected: Value = serde_json::from_slice(&read("expected.json")).expect("JSON");
    let expected = expected.as_array().expect("a list");
    let (film, width) = render(&description, folder, form.pick(1, 8));
    expected
        .iter()
        .flat_map(|e| rows(&description.name, &Expected::read(e), &film, width))
        .collect()
}

// One row if all channels must be equal.
fn rows(name: &str, expected: &Expected, film: &TileFilm, width: u32) -> Vec<Row> {
    let place = format!("{name} {:?}", expected.region);
    let values = expected.radiance;
    let grey = values == [values[0]; 3];
    let row = |channel: usize| {
        let (mean, error) = measure(film, width, expected.region, channel);
        let noise_max = 0.02 * values[channel].max(0.1);
        assert!(error <= noise_max, "{place}: too noisy to tell, {error}");
        let at = if grey {
            place.clone()
        } else {
            format!("{place} {}", ["red", "green", "blue"][channel])
        };
        Row::sampled(at, values[channel], mean, 5.0, error, expected.tolerance)
    };
    (0..if grey { 1 } else { 3 }).map(row).collect()
}

/// Mean of a channel over a region and its standard error, from the halves.
fn measure(film: &TileFilm, width: u32, region: [u32; 4], channel: usize) -> (f64, f64) {
    let [left, top, right, bottom] = region;
    let (mut mean, mut variance, mut count) = (0.0, 0.0, 0.0);
    for (x, y) in (top..bottom).flat_map(|y| (left..right).map(move |x| (x, y))) {
        let pixel = (y * width + x) as usize;
        let [a, b] = [0, 1].map(|half| film.half_mean(half, pixel)[channel]);
        mean += (a + b) / 2.0;
        variance += (a - b) * (a - b) / 4.0;
        count += 1.0;
    }
    (mean / count, variance.sqrt() / count)
}

/// The whole picture as one tile, with `times` its samples.
fn render(description: &SceneDescription, folder: &Path, times: u32) -> (TileFilm, u32) {
    let (width, height) = (description.image.width, description.image.height);
    let settings = RenderSettings {
        width,
        height,
        samples: description.job.samples,
        seed: 0,
        frames: 1,
        first_frame: 0,
        stop: shearwater_shared::stop::Stop::NONE,
    };
    let assets = read_assets(description, folder);
    let options = BuildOptions::default();
    let (scene, _) = Scene::build(description, &assets, &settings, 0, options).expect("a scene");
    let rect = TileRect {
        x0: 0,
        y0: 0,
        width,
        height,
    };
    let samples = 0..times * description.job.samples / 2;
    let cancel = AtomicBool::new(false);
    let sums = render_run(&scene, &rect, samples, &cancel).expect("not cancelled");
    assert_eq!((sums.bad.total(), sums.depth_cap_hits), (0, 0));
    let mut film = TileFilm::zero(rect.pixels());
    film.add(&sums).expect("one size");
    (film, width)
}

fn read_assets(description: &SceneDescription, folder: &Path) -> Assets {
    let read = |name: String| {
        let bytes = std::fs::read(folder.join(&name)).expect(&name);
        assert!(
            references::obj_libraries(&bytes).is_empty(),
            "{name}: no MTL"
        );
        (name, Arc::from(bytes))
    };
    description.files().into_iter().map(read).collect()
}
