//! Moving pictures: each frame has one right answer, whatever else is rendered.

mod common;

use common::farm::{Farm, hash_of};
use common::process::{Ended, Process, command};
use common::scene;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// 4 tiles of one block for each frame.
const QUICK: [&str; 4] = ["--size", "128x128", "--spp", "128"];
/// Frames of the scene.
const FRAMES: usize = 3;

fn moving_scene(folder: &Path) -> PathBuf {
    let path = scene::write(folder);
    animate(&path);
    path
}

fn animate(scene: &Path) {
    let animation = format!("\"animation\": {{ \"fps\": 5, \"frames\": {FRAMES} }}, \"job\"");
    scene::edit(scene, "\"job\"", &animation);
}

/// `render` into `out`.
fn render(scene: &Path, out: &Path, more: &[&str]) -> Ended {
    let mut command = command(["render", "--json", "-v", "-o"]);
    command.arg(out).arg(scene).args(QUICK).args(more);
    Process::start(&mut command).end()
}

fn hashes(value: &Value) -> Vec<String> {
    let hashes = value["film_hashes"].as_array().expect("hashes");
    hashes.iter().map(hash_of).collect()
}

/// What `render` says of every frame on this machine, asked once.
fn right_answers() -> &'static [String] {
    static HASHES: OnceLock<Vec<String>> = OnceLock::new();
    HASHES.get_or_init(|| {
        let folder = tempfile::tempdir().expect("temporary folder");
        let scene = moving_scene(folder.path());
        let ended = render(&scene, &folder.path().join("out"), &["--no-video"]).ok();
        let hashes = hashes(&ended.json());
        assert_eq!(hashes.len(), FRAMES);
        assert!(hashes[0] != hashes[1] && hashes[1] != hashes[2]);
        // What all frames share is built once.
        assert_eq!(ended.stderr.matches("stage built").count(), 1);
        assert_eq!(ended.stderr.matches("frame built").count(), FRAMES);
        hashes
    })
}

fn moving_farm() -> Farm {
    let farm = Farm::start();
    animate(&farm.scene);
    farm
}

/// Wait for the end of a job; the hash of each frame's film.
fn film_hashes(farm: &Farm, id: &str) -> Vec<String> {
    hashes(&farm.client(&["watch", id, "--json"]).ok().json())
}

#[test]
fn one_worker() {
    let farm = moving_farm();
    let id = farm.submit(&QUICK);
    let _worker = farm.worker(2);
    assert_eq!(film_hashes(&farm, &id), right_answers());
    let job = farm.job(&id);
    assert_eq!((&job["frames_done"], &job["fps"]), (&3.into(), &5.0.into()));
    let text = farm.client(&["status", &id]).ok().stdout;
    assert!(text.contains("3 of 3 done (0 to 2)"), "{text}");
}

#[test]
fn three_workers_and_one_of_them_killed() {
    let farm = moving_farm();
    let id = farm.submit(&QUICK);
    let doomed = farm.worker(1);
    farm.under_way(&id, 1);
    doomed.kill();
    let _heirs = [farm.worker(1), farm.worker(1), farm.worker(2)];
    assert_eq!(film_hashes(&farm, &id), right_answers());
}

#[test]
fn a_frame_does_not_know_the_others() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let scene = moving_scene(folder.path());
    let out = folder.path().join("out");
    let value = render(&scene, &out, &["--frames", "1..3", "--no-video"])
        .ok()
        .json();
    assert_eq!(hashes(&value), right_answers()[1..]);
    assert_eq!(value["frames"][0]["frame"], 1);
    let value = render(&scene, &out, &["--frames", "2..3"]).ok().json();
    assert_eq!(hashes(&value), right_answers()[2..]);
    assert_eq!(value["video"], Value::Null, "one frame is no film");
    for name in [
        "small.0001.png",
        "small.0001.exr",
        "small.0002.png",
        "small.0002.exr",
    ] {
        assert!(out.join(name).is_file(), "{name}");
    }
    assert!(!out.join("small.0000.png").exists() && !out.join("small.png").exists());
    // Beyond the end of the animation.
    let value = render(&scene, &out, &["--frames", "7..8"]).ok().json();
    assert!(!right_answers().contains(&hashes(&value)[0]));
    assert!(out.join("small.0007.png").is_file());
}

#[test]
fn a_film_where_ffmpeg_is_and_a_word_where_it_is_not() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let scene = moving_scene(folder.path());
    let out = folder.path().join("o u%t");
    // Odd sides: the film's are even.
    let size = ["--size", "33x17", "--spp", "2"];
    let quick = |path: Option<&str>| {
        let mut command = command(["render", "--json", "-o"]);
        command.arg(&out).arg(&scene).args(size);
        if let Some(path) = path {
            command.env("PATH", path);
        }
        Process::start(&mut command).end().ok()
    };
    let without = quick(Some("/nowhere"));
    assert_eq!(without.json()["video"], Value::Null);
    assert_eq!(without.stderr.lines().count(), 1, "{}", without.stderr);
    for words in [
        "ffmpeg is not installed",
        "ffmpeg -framerate 5",
        "small.%04d.png",
    ] {
        assert!(without.stderr.contains(words), "{}", without.stderr);
    }
    let installed = std::process::Command::new("ffmpeg")
        .arg("-version")
        .output();
    if installed.is_err() {
        return;
    }
    let film = out.join("small.mp4");
    assert_eq!(quick(None).json()["video"], film.to_str().expect("UTF-8"));
    let bytes = std::fs::read(&film).expect("film");
    assert_eq!(&bytes[4..8], b"ftyp");
    assert!(!out.join("small.part.mp4").exists());
    // A part of it does not take its place.
    let part = render(&scene, &out, &["--frames", "1..3"]);
    let name = out.join("small.0001-0002.mp4");
    assert_eq!(part.ok().json()["video"], name.to_str().expect("UTF-8"));
    assert_eq!(std::fs::read(&film).expect("film"), bytes);
}

#[test]
fn frames_that_cannot_be_are_refused() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let out = folder.path().join("out");
    let still = scene::write(&folder.path().join("still"));
    let scene = moving_scene(&folder.path().join("moving"));
    for bad in ["0", "-1", "3..3", "3..1", "x", "1..", "1000001"] {
        let ended = render(&scene, &out, &[&format!("--frames={bad}")]).expect_code(2);
        assert!(ended.stderr.contains("--frames"), "{}", ended.stderr);
    }
    for frames in ["2", "1..2"] {
        let ended = render(&still, &out, &["--frames", frames]).expect_code(5);
        assert!(ended.stderr.contains("no `animation`"), "{}", ended.stderr);
    }
    render(&still, &out, &["--frames", "1"]).ok();
    assert!(out.join("small.png").is_file(), "a still has no number");
}

#[test]
fn download_of_one_frame_and_of_all() {
    let farm = moving_farm();
    let id = farm.submit(&QUICK);
    let out = farm.folder().join("pictures");
    let download = |more: &[&str]| {
        let out = out.to_str().expect("UTF-8");
        farm.client(&[&["download", &id, "--json", "-o", out], more].concat())
    };
    let none = download(&[]).expect_code(1).json();
    let text = none["error"]["message"].as_str().expect("text").to_owned();
    assert!(text.contains("--frame 0"), "{text}");
    let _worker = farm.worker(2);
    film_hashes(&farm, &id);
    download(&["--frame", "1"]).ok();
    assert!(out.join("small.0001.exr").is_file() && !out.join("small.0000.exr").exists());
    download(&["--frame", "3"]).expect_code(5);
    let value = download(&["--no-video"]).ok().json();
    assert_eq!(value["files"].as_array().map(Vec::len), Some(2 * FRAMES));
    assert_eq!(value["frames"][2]["film_hash"], *right_answers()[2]);
    for frame in 0..FRAMES {
        let png = std::fs::read(out.join(format!("small.{frame:04}.png"))).expect("picture");
        assert!(png.starts_with(b"\x89PNG"));
    }
}
