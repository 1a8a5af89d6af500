//! The command line: exit codes, JSON and the texts of errors.

mod common;

use common::farm::{Farm, hash_of};
use common::process::{Process, command, run};
use common::{scene, until};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// A port where nobody listens: 1 needs privileges and has no server.
const NOWHERE: &str = "http://127.0.0.1:1";

struct Place {
    folder: tempfile::TempDir,
    scene: PathBuf,
}

impl Place {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("temporary folder");
        let scene = scene::write(folder.path());
        Self { folder, scene }
    }

    fn out(&self) -> PathBuf {
        self.folder.path().join("out")
    }

    /// `render --json` at a size that takes no time.
    fn quick_render(&self, more: &[&str]) -> common::process::Ended {
        let mut command = command(["render", "--size", "64x32", "--spp", "4", "--json", "-o"]);
        command.arg(self.out()).arg(&self.scene).args(more);
        Process::start(&mut command).end()
    }

    /// The text of the scene error that a render must end with.
    fn scene_error(&self) -> String {
        let ended = self.quick_render(&[]).expect_code(3);
        let error = &ended.json()["error"];
        assert_eq!(error["kind"], "scene");
        assert_eq!(error["exit_code"], 3);
        let message = error["message"].as_str().expect("text").to_owned();
        assert!(ended.stderr.contains(&message), "{}", ended.stderr);
        assert!(!self.out().join("small.png").exists());
        message
    }
}

fn is_picture(file: &Path, magic: &[u8]) {
    let bytes = std::fs::read(file).expect("picture");
    assert!(bytes.starts_with(magic), "{}", file.display());
}

const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";
const EXR: &[u8] = &[0x76, 0x2f, 0x31, 0x01];

#[test]
fn render_writes_both_pictures_and_says_what_it_did() {
    let place = Place::new();
    let value = place.quick_render(&[]).ok().json();
    hash_of(&value["film_hash"]);
    hash_of(&value["scene_hash"]);
    for field in [
        "samples_per_s",
        "seconds",
        "total_seconds",
        "nmse",
        "peak_memory_bytes",
    ] {
        let number = value[field].as_f64();
        assert!(number > Some(0.0), "{field}: {number:?}");
    }
    assert_eq!(value["samples"], 64 * 32 * 4);
    assert_eq!((&value["width"], &value["spp"]), (&64.into(), &4.into()));
    assert_eq!(value["files"].as_array().map(Vec::len), Some(2));
    is_picture(&place.out().join("small.png"), PNG);
    is_picture(&place.out().join("small.exr"), EXR);
}

#[test]
fn render_prints_the_same_as_text() {
    let place = Place::new();
    let hash = hash_of(&place.quick_render(&[]).ok().json()["film_hash"]);
    let mut command = command(["render", "--size", "64x32", "--spp", "4", "-o"]);
    let ended = Process::start(command.arg(place.out()).arg(&place.scene))
        .end()
        .ok();
    for expected in [
        hash.as_str(),
        "film hash",
        "samples/s",
        "NMSE",
        "peak memory",
        "small.png",
        "small.exr",
    ] {
        assert!(ended.stdout.contains(expected), "{expected}");
    }
}

#[test]
fn a_wrong_scene_is_named_with_its_path() {
    let cases = [
        ("\"version\": 1", "\"version\": 9", "version"),
        ("\"vertical_fov_deg\"", "\"fov\"", "camera"),
        ("\"roughness\": 0.4", "\"roughness\": 7", "materials.red"),
        ("\"mesh\": \"cube\", \"t", "\"mesh\": \"ball\", \"t", "ball"),
        ("\"job\": {", "\"job\" {", "scene.json"),
    ];
    for (from, to, expected) in cases {
        let place = Place::new();
        scene::edit(&place.scene, from, to);
        let message = place.scene_error();
        assert!(message.contains(expected), "{expected}: {message}");
        assert!(message.contains("scene.json"), "{message}");
    }
}

#[test]
fn a_missing_file_is_named_with_who_wants_it() {
    let place = Place::new();
    std::fs::remove_file(place.folder.path().join("models/cube.obj")).expect("remove");
    let message = place.scene_error();
    assert!(message.contains("meshes.cube.file"), "{message}");
    assert!(message.contains("models/cube.obj"), "{message}");

    let place = Place::new();
    std::fs::remove_file(place.folder.path().join("models/cube.mtl")).expect("remove");
    let message = place.scene_error();
    assert!(message.contains("models/cube.obj"), "{message}");
    assert!(message.contains("models/cube.mtl"), "{message}");

    let place = Place::new();
    let mtl = place.folder.path().join("models/cube.mtl");
    scene::edit(&mtl, "Kd", "map_Kd paint.png\nKd");
    let message = place.scene_error();
    assert!(message.contains("models/cube.mtl"), "{message}");
    assert!(message.contains("models/paint.png"), "{message}");

    let ended = run(["render", "no-such-folder/scene.json"]).expect_code(3);
    assert!(ended.stderr.contains("no-such-folder"), "{}", ended.stderr);
}

#[test]
fn a_wrong_asset_is_named_by_the_worker() {
    let place = Place::new();
    let obj = place.folder.path().join("models/cube.obj");
    scene::edit(&obj, "f 5 6 7 8", "f 5 6 7 88");
    let message = place.scene_error();
    assert!(message.contains("models/cube.obj"), "{message}");
}

#[test]
fn a_file_above_the_scene_is_found() {
    let place = Place::new();
    let inner = place.folder.path().join("inner");
    std::fs::create_dir(&inner).expect("folder");
    scene::edit(&place.scene, "models/cube.obj", "../models/cube.obj");
    let moved = inner.join("scene.json");
    std::fs::rename(&place.scene, &moved).expect("move");
    let mut command = command(["render", "--size", "64x32", "--spp", "4", "--json", "-o"]);
    Process::start(command.arg(place.out()).arg(&moved))
        .end()
        .ok();
}

/// Several scenes in one folder, whose files lie beside it and refer to files
/// beside them.
fn skies() -> Place {
    let place = Place::new();
    let folder = place.folder.path();
    for name in ["skies", "tex"] {
        std::fs::create_dir(folder.join(name)).expect("folder");
    }
    place.quick_render(&[]).ok();
    let out = place.out();
    std::fs::copy(out.join("small.png"), folder.join("tex/paint.png")).expect("texture");
    std::fs::copy(out.join("small.exr"), folder.join("tex/sky.exr")).expect("sky");
    std::fs::remove_dir_all(out).expect("folder");
    scene::edit(
        &folder.join("models/cube.mtl"),
        "Kd",
        "map_Kd ../tex/paint.png\nKd",
    );
    scene::edit(&place.scene, "models/cube.obj", "../models/cube.obj");
    std::fs::copy(&place.scene, folder.join("skies/noon.json")).expect("scene");
    let dusk = folder.join("skies/dusk.json");
    std::fs::rename(&place.scene, &dusk).expect("scene");
    let constant = "\"constant\", \"radiance\": [0.4, 0.55, 0.8]";
    scene::edit(&dusk, constant, "\"map\", \"file\": \"../tex/sky.exr\"");
    place
}

#[test]
fn several_scenes_of_one_folder() {
    let mut place = skies();
    let folder = place.folder.path().join("skies");
    let mut hashes = Vec::new();
    for name in ["noon.json", "dusk.json"] {
        place.scene = folder.join(name);
        let value = place.quick_render(&[]).ok().json();
        hashes.push(hash_of(&value["film_hash"]));
    }
    assert_ne!(hashes[0], hashes[1]);
    // From inside the folder, and through a farm, the files are the same.
    let mut inside = command([
        "render",
        "--size",
        "64x32",
        "--spp",
        "4",
        "--json",
        "noon.json",
    ]);
    let ended = Process::start(inside.current_dir(&folder)).end().ok();
    assert_eq!(hash_of(&ended.json()["film_hash"]), hashes[0]);
    let farm = Farm::start();
    let dusk = folder.join("dusk.json");
    let dusk = dusk.to_str().expect("UTF-8");
    let submit = ["submit", dusk, "--size", "64x32", "--spp", "4", "--json"];
    let id = farm.client(&submit).ok().json()["id"].to_string();
    let _worker = farm.worker(1);
    assert_eq!(farm.film_hash(&id), hashes[1]);
}

#[test]
fn an_error_names_the_scene_file_and_its_asset() {
    let mut place = skies();
    let folder = place.folder.path().join("skies");
    let dusk = std::fs::read_to_string(folder.join("dusk.json")).expect("scene");
    let bad = |from: &str, to: &str| {
        assert!(dusk.contains(from), "{from}");
        std::fs::write(folder.join("bad.json"), dusk.replace(from, to)).expect("scene");
    };
    std::fs::write(folder.join("noise.exr"), b"no picture").expect("file");
    place.scene = folder.join("bad.json");
    for (from, to, expected) in [
        (
            "\"version\": 1",
            "\"version\": 9",
            &["bad.json: version"][..],
        ),
        (
            "../tex/sky.exr",
            "../tex/none.exr",
            &["bad.json: sky.file", "../tex/none.exr"],
        ),
        (
            "../models/cube.obj",
            "../models",
            &["bad.json: meshes.cube.file", "not a file"],
        ),
        ("../tex/sky.exr", "noise.exr", &["noise.exr", "EXR"]),
        ("../tex/sky.exr", "dusk.json", &["dusk.json"]),
    ] {
        bad(from, to);
        let message = place.scene_error();
        // Said once: the logs of worker and coordinator are not for this user.
        let ended = place.quick_render(&[]).expect_code(3);
        assert_eq!(ended.stderr.lines().count(), 1, "{}", ended.stderr);
        for words in expected {
            assert!(message.contains(words), "{words}: {message}");
        }
    }
}

#[test]
fn wrong_usage_ends_with_2() {
    let place = Place::new();
    for more in [
        ["--size", "64"],
        ["--size", "0x4"],
        ["--spp", "5"],
        ["--threads", "0"],
        ["--no-such-flag", "1"],
    ] {
        let ended = place.quick_render(&more).expect_code(2);
        assert!(ended.stderr.contains(more[0]), "{}", ended.stderr);
    }
    run(["fly"]).expect_code(2);
}

#[test]
fn help_teaches() {
    let help = run(["--help"]).ok().stdout;
    for expected in ["Examples:", "Exit codes:", "render", "130", "--json"] {
        assert!(help.contains(expected), "{expected}");
    }
    for command in [
        "render",
        "coordinator",
        "worker",
        "submit",
        "status",
        "watch",
        "download",
        "cancel",
        "jobs",
        "water",
        "export",
        "schema",
    ] {
        assert!(help.contains(command), "{command}");
        assert!(run([command, "--help"]).ok().stdout.contains("Usage:"));
    }
}

#[test]
fn nobody_there_ends_with_4() {
    let place = Place::new();
    let scene = place.scene.to_str().expect("UTF-8");
    for args in [
        &["status", "1"][..],
        &["watch", "1"],
        &["download", "1"],
        &["cancel", "1"],
        &["jobs"],
        &["submit", scene],
    ] {
        let ended = run(args.iter().chain(&["--json", "--coordinator", NOWHERE]));
        let error = &ended.expect_code(4).json()["error"];
        assert_eq!(error["kind"], "unreachable");
        assert!(error["message"].as_str().expect("text").contains(NOWHERE));
    }
    let ended = Process::start(command(["jobs"]).env("SHEARWATER_COORDINATOR", NOWHERE)).end();
    assert!(ended.expect_code(4).stderr.contains(NOWHERE));
}

#[test]
fn an_interrupted_render_ends_with_130() {
    let place = Place::new();
    let mut command = command(["render", "--spp", "1000000", "-v", "-o"]);
    let process = Process::start(command.arg(place.out()).arg(&place.scene));
    until("the worker starts", || {
        process.stderr().contains("worker starts").then_some(())
    });
    process.signal("INT");
    process.end().expect_code(130);
    assert!(!place.out().join("small.png").exists());
}

#[test]
fn schema_is_that_of_the_types() {
    let printed = run(["schema"]).ok();
    assert_eq!(printed.stdout, shearwater_shared::scene::schema_json());
    assert!(printed.json()["properties"]["camera"].is_object());
}

#[test]
fn a_job_from_submit_to_download() {
    let farm = Farm::start();
    let quick = ["--size", "64x32", "--spp", "4"];
    let first = farm.submit(&quick);
    let named = farm.submit(&[&quick[..], &["--name", "second"]].concat());
    let job = farm.job(&first);
    assert_eq!(
        (&job["state"], &job["done"]),
        (&"queued".into(), &false.into())
    );
    let listed = farm.client(&["jobs", "--json"]).ok().json();
    let names: Vec<&Value> = listed["jobs"]
        .as_array()
        .expect("jobs")
        .iter()
        .map(|job| &job["name"])
        .collect();
    assert_eq!(names, ["second", "small"]);

    let cancelled = farm.client(&["cancel", &named, "--json"]).ok().json();
    assert_eq!(cancelled["state"], "cancelled");
    let ended = farm.client(&["watch", &named, "--json"]).expect_code(1);
    assert_eq!(ended.json()["error"]["kind"], "failure");

    let _worker = farm.worker(1);
    farm.film_hash(&first);
    let out = farm.folder().join("pictures");
    let args = [
        "download",
        &first,
        "--json",
        "-o",
        out.to_str().expect("UTF-8"),
    ];
    let value = farm.client(&args).ok().json();
    assert_eq!(value["done"], true);
    is_picture(&out.join("small.png"), PNG);
    is_picture(&out.join("small.exr"), EXR);
    let text = farm.client(&["status", &first]).ok().stdout;
    assert!(
        text.contains("done") && text.contains("film hash"),
        "{text}"
    );
}

#[test]
fn the_coordinator_says_no_with_5() {
    let farm = Farm::start();
    for args in [
        &["status", "999"][..],
        &["watch", "999"],
        &["cancel", "999"],
        &["download", "999"],
    ] {
        let ended = farm.client(&[args, &["--json"]].concat()).expect_code(5);
        let error = &ended.json()["error"];
        assert_eq!(error["kind"], "refused");
        assert!(error["message"].as_str().expect("text").contains("999"));
    }
}

#[test]
fn a_failed_scene_of_a_farm_ends_watch_with_3() {
    let farm = Farm::start();
    let obj = farm.scene.with_file_name("models").join("cube.obj");
    scene::edit(&obj, "f 5 6 7 8", "f 5 6 7 88");
    let id = farm.submit(&[]);
    let mut worker = farm.worker(1);
    let ended = farm.client(&["watch", &id]).expect_code(3);
    assert!(ended.stderr.contains("models/cube.obj"), "{}", ended.stderr);
    assert!(worker.runs(), "a wrong scene does not stop a worker");
    assert_eq!(farm.job(&id)["failure_kind"], "scene");
}
