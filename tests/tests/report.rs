//! `shearwater report`: its files, its exit codes, and that it goes on where it was.

mod common;

use common::process::{Ended, Process, command};
use common::{scene, until};
use std::path::{Path, PathBuf};

const VARIANTS: &str = r#"[
  {"name": "independent", "scene": {"sampling": {"sampler": "independent"}}},
  {"name": "wrong", "scene": {"camera": {"vertical_fov_deg": 500}}}
]"#;

struct Place {
    folder: tempfile::TempDir,
    scene: PathBuf,
}

impl Place {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("temporary folder");
        let scene = scene::write(folder.path());
        std::fs::write(folder.path().join("list.json"), VARIANTS).expect("list");
        Self { folder, scene }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn start(&self, more: &[&str]) -> Process {
        let mut command = command(["report", "--size", "48x32", "--json", "-o"]);
        command.arg(self.path("out")).arg(&self.scene).args(more);
        Process::start(&mut command)
    }

    fn report(&self) -> Ended {
        let list = self.path("list.json");
        let list = list.to_str().expect("UTF-8");
        let more = ["--spp", "8,4", "--reference-spp", "64", "--against", list];
        self.start(&more).end()
    }
}

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).expect("report")
}

#[test]
fn a_wrong_variant_is_named_and_the_rest_reported() {
    let place = Place::new();
    let first = place.report().expect_code(3);
    assert!(
        first.stderr.contains("camera.vertical_fov_deg"),
        "{}",
        first.stderr
    );
    let value = first.json();
    let study = &value["study"];
    // Reference, and two variants of 8 samples.
    assert_eq!(study["rendered_samples"], 48 * 32 * (64 + 8 + 8));
    let variants = study["scenes"][0]["variants"].as_array().expect("variants");
    let names: Vec<_> = variants
        .iter()
        .map(|v| v["variant"]["name"].as_str())
        .collect();
    assert_eq!(
        names,
        [Some("as it is"), Some("independent"), Some("wrong")]
    );
    let counts: Vec<_> = variants[1]["points"]
        .as_array()
        .expect("points")
        .iter()
        .collect();
    assert_eq!(
        (&counts[0]["spp"], &counts[1]["spp"]),
        (&4.into(), &8.into())
    );
    assert!(counts[1]["core_s"].as_f64() > Some(0.0));

    let page = text(&place.path("out/report.html"));
    assert!(
        page.starts_with("<!doctype html>") && page.contains("<svg"),
        "page"
    );
    for reference in ["<link", "<script", "src=\"http", "url("] {
        assert!(
            !page.contains(reference),
            "{reference}: the page needs another file"
        );
    }
    assert_eq!(
        text(&place.path("out/report.csv")).lines().count(),
        1 + 2 + 2 + 1
    );
    assert!(text(&place.path("out/report.md")).contains("| independent |"));

    let again = place.report().expect_code(3).json();
    assert_eq!(again["study"]["rendered_samples"], 0);
    assert_eq!(again["study"]["scenes"], study["scenes"]);
}

#[test]
fn an_interrupted_report_ends_with_a_word() {
    let place = Place::new();
    let process = place.start(&["--spp", "4,16777216", "--reference-spp", "8"]);
    until("the first point", || {
        process.stderr().contains("4 spp").then_some(())
    });
    process.signal("INT");
    let ended = process.end().expect_code(130);
    assert!(
        ended.stderr.contains("goes on from there"),
        "{}",
        ended.stderr
    );
    let kept = std::fs::read_dir(place.path("out/data"))
        .expect("data")
        .count();
    assert!(kept >= 2, "reference and first point");
}

#[test]
fn wrong_lists_are_named() {
    let place = Place::new();
    std::fs::write(place.path("list.json"), r#"[{"name": "a", "tile": 0}]"#).expect("list");
    let ended = place.report().expect_code(3);
    assert!(ended.stderr.contains("[0].tile"), "{}", ended.stderr);
}
