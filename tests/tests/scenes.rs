//! Every scene that the project ships: it renders, and one worker and three give
//! the same film.

mod common;

use common::farm::{Farm, hash_of};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Small, but of several tiles, so that workers share it.
const QUICK: [&str; 4] = ["--size", "192x128", "--spp", "4"];

/// Scene files below `folder`, in the order of their names.
fn scenes(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.ends_with("generator") {
            continue;
        }
        if path.is_dir() {
            found.extend(scenes(&path));
        } else if path.extension().is_some_and(|end| end == "json") {
            let text = std::fs::read(&path).expect("a file");
            let json: Value = serde_json::from_slice(&text).expect("JSON");
            if json["version"].is_u64() && json["camera"].is_object() {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// Hashes of every frame of every scene, rendered by `workers` workers.
fn films(scenes: &[PathBuf], workers: usize) -> Vec<(PathBuf, Vec<String>)> {
    let farm = Farm::start();
    let _workers: Vec<_> = (0..workers).map(|_| farm.worker(1)).collect();
    let submit = |scene: &PathBuf| {
        let mut args = vec!["submit", scene.to_str().expect("UTF-8"), "--json"];
        args.extend(QUICK);
        let json: Value =
            serde_json::from_slice(&std::fs::read(scene).expect("a file")).expect("JSON");
        if json["animation"].is_object() {
            args.extend(["--frames", "0..2"]);
        }
        farm.client(&args).ok().json()["id"].to_string()
    };
    let ids: Vec<String> = scenes.iter().map(submit).collect();
    let hashes = |id: &String| {
        let job = farm.client(&["watch", id, "--json"]).ok().json();
        assert_eq!(job["bad_samples"], 0, "{job}");
        let list = job["film_hashes"].as_array().expect("hashes");
        assert!(!list.is_empty(), "{job}");
        list.iter().map(hash_of).collect()
    };
    scenes.iter().cloned().zip(ids.iter().map(hashes)).collect()
}

#[test]
fn every_scene_is_the_same_film_for_one_worker_and_three() {
    let scenes = scenes(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes"));
    assert!(!scenes.is_empty(), "no scenes");
    let (one, three) = (films(&scenes, 1), films(&scenes, 3));
    for (one, three) in one.iter().zip(&three) {
        assert_eq!(one, three);
    }
    // A few ship twice for two comparisons, or differ in nothing but bloom.
    let mut hashes: Vec<&String> = one.iter().flat_map(|(_, hashes)| hashes).collect();
    let frames = hashes.len();
    hashes.sort();
    hashes.dedup();
    assert!(
        hashes.len() * 10 >= frames * 8,
        "{} different films of {frames}",
        hashes.len()
    );
}
