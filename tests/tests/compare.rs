//! `shearwater compare`, held against the authors' FLIP program.

mod common;

use common::process::{Process, command, program, run};
use common::scene;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What `compare` promises.
const TOLERANCE: f64 = 1e-4;

/// Means of the authors' program: for PNG of the files as they are, for EXR with high
/// dynamic range and then of both clamped to 0..1.
const FLIP: &str = "
import sys, numpy, flip_evaluator as flip
a, r = sys.argv[1:3]
if a.endswith('.exr'):
    print(flip.evaluate(r, a, 'HDR', applyMagma=False)[1])
    a, r = numpy.clip(flip.load(a), 0, 1), numpy.clip(flip.load(r), 0, 1)
    print(flip.evaluate(r, a, 'LDR', inputsRGB=False, applyMagma=False)[1])
else:
    print(flip.evaluate(r, a, 'LDR', applyMagma=False)[1])
";

/// The interpreter that `tests/run` sets up.
fn python() -> PathBuf {
    let program = program();
    let target = program
        .ancestors()
        .nth(2)
        .expect("target/<profile>/program");
    let python = target.join("python/bin/python");
    assert!(
        python.is_file(),
        "{} is not there: `tests/run` makes it, or `python3 -m venv target/python && \
         target/python/bin/pip install flip-evaluator==1.7 numpy==2.4.6`",
        python.display()
    );
    python
}

fn flip(picture: &Path, reference: &Path) -> Vec<f64> {
    let mut command = Command::new(python());
    let output = command
        .args(["-c", FLIP])
        .args([picture, reference])
        .output()
        .expect("python runs");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    text.lines()
        .map(|line| line.trim().parse().expect("a number"))
        .collect()
}

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

    /// Render; the path of the picture without its ending.
    fn render(&self, name: &str, more: &[&str]) -> PathBuf {
        let out = self.folder.path().join(name);
        let mut command = command(["render", "--json", "-o"]);
        command.arg(&out).arg(&self.scene).args(more);
        Process::start(&mut command).end().ok();
        out.join("small")
    }
}

fn compare(picture: &Path, reference: &Path) -> Value {
    let args = [picture, reference].map(|path| path.to_str().expect("UTF-8"));
    run(["compare", args[0], args[1], "--json"]).ok().json()
}

fn assert_near(found: &Value, expected: f64, what: &str) {
    let found = found.as_f64().expect(what);
    assert!(
        (found - expected).abs() <= TOLERANCE,
        "{what}: {found} {expected}"
    );
}

#[test]
fn flip_agrees_with_the_authors_program() {
    let place = Place::new();
    let reference = place.render("reference", &["--size", "160x96", "--spp", "64"]);
    let noisy = place.render("noisy", &["--size", "160x96", "--spp", "2", "--seed", "1"]);
    // Another colour and another place: differences that are no noise.
    scene::edit(&place.scene, "0.8, 0.1, 0.05", "0.1, 0.1, 0.8");
    scene::edit(&place.scene, "[0, 0.8, 0]", "[0.1, 0.8, 0]");
    let changed = place.render("changed", &["--size", "160x96", "--spp", "64"]);
    for picture in [&noisy, &changed] {
        let (a, r) = (
            picture.with_extension("exr"),
            reference.with_extension("exr"),
        );
        let (found, expected) = (compare(&a, &r), flip(&a, &r));
        assert!(expected[0] > 0.01, "too alike to tell: {expected:?}");
        assert_near(&found["flip_hdr"], expected[0], "FLIP-HDR");
        assert_near(&found["flip_ldr"], expected[1], "FLIP-LDR");
        let (a, r) = (
            picture.with_extension("png"),
            reference.with_extension("png"),
        );
        let (found, expected) = (compare(&a, &r), flip(&a, &r));
        assert!(found["flip_hdr"].is_null() && found["rel_mse"].is_null());
        assert_near(&found["flip_ldr"], expected[0], "FLIP-LDR of PNG");
    }
}

#[test]
fn an_adaptive_picture_has_a_row_for_each_number_of_samples() {
    let place = Place::new();
    let exr = |stem: PathBuf| stem.with_extension("exr");
    let adaptive = exr(place.render("adaptive", &["--error", "0.0005", "--spp", "512"]));
    let reference = exr(place.render("reference", &["--spp", "512", "--seed", "1"]));
    let found = compare(&adaptive, &reference);
    let groups = found["groups"].as_array().expect("groups");
    assert!(groups.len() >= 2, "{found}");
    let pixels: u64 = groups.iter().filter_map(|g| g["pixels"].as_u64()).sum();
    let [width, height] = ["width", "height"].map(|side| found[side].as_u64().expect(side));
    assert_eq!(pixels, width * height);
    assert_eq!(groups[0]["samples_min"], 64);
    for group in groups {
        // Seeds are fixed: what holds once holds always.
        let z = group["relative_difference"]["z"].as_f64().expect("z");
        assert!(z.abs() < 4.0, "{group}");
        let (own, all) = (&group["reference_rel_mse"], &group["rel_mse"]);
        assert!(
            own.as_f64().expect("own") < all.as_f64().expect("all"),
            "{group}"
        );
    }
    let same = compare(&reference, &adaptive);
    assert_eq!(same["groups"].as_array().map(Vec::len), Some(0));
}

#[test]
fn limits_and_pictures_that_do_not_fit() {
    let place = Place::new();
    let small = place.render("small", &["--size", "64x32", "--spp", "2"]);
    let other = place.render("other", &["--size", "64x32", "--spp", "2", "--seed", "7"]);
    let wide = place.render("wide", &["--size", "128x32", "--spp", "2"]);
    let exr = |stem: &Path| {
        stem.with_extension("exr")
            .to_str()
            .expect("UTF-8")
            .to_owned()
    };
    let (small_exr, other_exr, wide_exr) = (exr(&small), exr(&other), exr(&wide));

    let same = run([
        "compare",
        &small_exr,
        &small_exr,
        "--max-mse",
        "0",
        "--max-flip",
        "0",
    ])
    .ok();
    assert!(same.stdout.contains("relMSE"), "{}", same.stdout);

    let out = place.folder.path().join("difference");
    let mut exceeding = command(["compare", &small_exr, &other_exr, "--json", "-o"]);
    exceeding.arg(&out).args(["--max-relmse", "1e-9"]);
    let ended = Process::start(&mut exceeding).end().expect_code(6);
    let value = ended.json();
    assert_eq!(value["exceeded"].as_array().map(Vec::len), Some(1));
    assert!(ended.stderr.contains("relMSE"), "{}", ended.stderr);
    for name in ["difference.png", "flip-ldr.png", "flip-hdr.png"] {
        let bytes = std::fs::read(out.join(name)).expect(name);
        assert!(bytes.starts_with(b"\x89PNG"), "{name}");
    }

    let png = small.with_extension("png");
    let cases = [
        ([small_exr.as_str(), &wide_exr], "64x32 and 128x32"),
        ([small_exr.as_str(), png.to_str().expect("UTF-8")], "PNG"),
        ([small_exr.as_str(), "nowhere.exr"], "nowhere.exr"),
        (
            [place.scene.to_str().expect("UTF-8"), &small_exr],
            "scene.json: neither",
        ),
    ];
    for ([a, b], expected) in cases {
        let ended = run(["compare", a, b]).expect_code(1);
        assert!(ended.stderr.contains(expected), "{}", ended.stderr);
    }
}
