//! Whole studies of a small scene without files.

use super::*;
use crate::output::{Heading, csv, html, markdown};
use crate::variants::parse_variants;
use serde_json::Value;
use shearwater_shared::scene;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// A grey cloud of noise before an even sky: what it lets through depends on how its
/// density is walked.
const SCENE: &str = r#"{
  "version": 1, "name": "cloud", "image": {"width": 32, "height": 16}, "job": {"samples": 16},
  "camera": {"position_m": [0, 0, 6], "target_m": [0, 0, 0], "up": [0, 1, 0],
    "vertical_fov_deg": 20, "shutter_s": 0},
  "sky": {"type": "constant", "radiance": [1, 1, 1]},
  "clouds": [{"type": "volume", "shape": {"type": "ellipsoid", "centre_m": [0, 0, 0],
    "radii_m": [3, 2, 2], "edge": 0.5, "resolution": 32, "noise": {"scale_m": 1.0, "seed": 4}},
    "sigma_t_per_m": 1.5, "albedo": [0.2, 0.2, 0.2]}]
}"#;

fn options(variants: &str) -> Options {
    Options {
        scenes: vec![SceneFile {
            file: "cloud.json".to_owned(),
            bytes: SCENE.into(),
        }],
        variants: parse_variants("list.json", variants.as_bytes()).expect("variants"),
        baseline: "tracking".to_owned(),
        size: None,
        counts: vec![16, 64],
        seeds: 1,
        threads: 2,
        reference_spp: 1024,
        reference: None,
    }
}

fn load(_: usize, bytes: &[u8]) -> Result<Loaded, String> {
    let description = scene::parse(bytes).map_err(|e| e.to_string())?;
    let assets = shearwater_tracer::Assets::new();
    Ok(Loaded {
        description,
        assets,
    })
}

fn study(options: &Options, folder: &Path) -> Study {
    let store = Store::open(folder).expect("store");
    let cancel = AtomicBool::new(false);
    run_study(options, &load, &store, &cancel, &mut |_| {}).expect("study")
}

/// Without what the run itself did, and without times.
fn found(study: &Study) -> Value {
    let mut value = serde_json::to_value(study).expect("JSON");
    value["rendered_samples"] = 0.into();
    for variant in value["scenes"][0]["variants"].as_array_mut().expect("list") {
        for point in variant["points"].as_array_mut().expect("list") {
            (point["core_s"], point["wall_s"]) = (0.into(), 0.into());
        }
    }
    value
}

const MARCHING: &str = r#"[
  {"name": "tracking"},
  {"name": "one step", "set": {"/clouds/*/method": {"type": "march", "step_m": 100}}}
]"#;

#[test]
fn a_march_of_one_step_is_called_biased_and_tracking_is_not() {
    let folder = tempfile::tempdir().expect("folder");
    let study = study(&options(MARCHING), folder.path());
    let [tracking, march] = &study.scenes[0].variants[..] else {
        panic!("two variants");
    };
    let (tracking, march) = (tracking.bias.expect("test"), march.bias.expect("test"));
    assert!(tracking.passed, "{tracking:?}");
    // Jensen: the mean of exp(-x) is above exp of the mean, so the march is too bright.
    assert!(!march.passed && march.t > 10.0, "{march:?}");
}

#[test]
fn errors_fall_with_samples_and_the_reference_says_how_wrong_it_is() {
    let folder = tempfile::tempdir().expect("folder");
    let study = study(&options(r#"[{"name": "tracking"}]"#), folder.path());
    let scene = &study.scenes[0];
    let [few, many] = scene.variants[0].points[..] else {
        panic!("two points");
    };
    assert!(many.rel_mse < 0.6 * few.rel_mse, "{few:?} {many:?}");
    assert!(many.flip_hdr < few.flip_hdr);
    assert!(
        many.core_s > few.core_s && few.core_s > 0.0,
        "{few:?} {many:?}"
    );
    // The halves estimate what the reference measures; 512 pixels of three equal channels.
    assert!((0.5..2.0).contains(&(many.own_mse / many.mse)), "{many:?}");
    let own = scene.reference.as_ref().and_then(|r| r.mse).expect("error");
    assert!(own > 0.0 && own < many.mse, "{own} {many:?}");
}

#[test]
fn a_second_run_renders_nothing_and_finds_the_same() {
    let folder = tempfile::tempdir().expect("folder");
    let options = options(MARCHING);
    let first = study(&options, folder.path());
    let again = study(&options, folder.path());
    // 512 pixels: 1024 samples of the reference, 64 of each variant.
    assert_eq!(first.rendered_samples, 512 * (1024 + 2 * 64));
    assert_eq!(again.rendered_samples, 0);
    let with_times = |study: &Study| serde_json::to_value(&study.scenes).expect("JSON");
    assert_eq!(with_times(&first), with_times(&again));
    assert!(again.scenes[0].variants[1].pictures.is_some());

    // More samples cost the difference only.
    let mut more = options.clone();
    more.counts.push(96);
    let third = study(&more, folder.path());
    assert_eq!(third.rendered_samples, 512 * 2 * 32);
    let elsewhere = tempfile::tempdir().expect("folder");
    assert_eq!(found(&third), found(&study(&more, elsewhere.path())));
}

#[test]
fn what_a_result_depends_on_is_in_its_key() {
    let folder = tempfile::tempdir().expect("folder");
    let base = options(r#"[{"name": "tracking"}]"#);
    study(&base, folder.path());
    let mut scene = base.clone();
    scene.scenes[0].bytes = SCENE.replace("[1, 1, 1]", "[1, 1, 2]").into_bytes();
    let mut size = base.clone();
    size.size = Some((16, 16));
    let mut seeds = base.clone();
    seeds.seeds = 2;
    let mut block = base.clone();
    block.variants[0].block = Some(3);
    for (options, least) in [
        (scene, 512 * 1024),
        (size, 256 * 1024),
        (seeds, 512 * 64),
        (block, 512 * 64),
    ] {
        let rendered = study(&options, folder.path()).rendered_samples;
        assert!(rendered >= least, "{rendered} {least}");
    }
    // A damaged file is rendered again.
    for entry in std::fs::read_dir(folder.path()).expect("folder").flatten() {
        if entry
            .path()
            .extension()
            .is_some_and(|ending| ending == "json")
        {
            std::fs::write(entry.path(), "{").expect("damage");
        }
    }
    assert!(study(&base, folder.path()).rendered_samples >= 512 * 64);
}

#[test]
fn an_interrupted_study_goes_on_where_it_was() {
    let folder = tempfile::tempdir().expect("folder");
    let store = Store::open(folder.path()).expect("store");
    let options = options(MARCHING);
    let cancel = AtomicBool::new(false);
    let mut milestones = 0;
    let mut tell = |told: &Told<'_>| {
        milestones += u32::from(told.milestone);
        // After the reference and the first point.
        cancel.store(milestones >= 2, Ordering::Relaxed);
    };
    let ended = run_study(&options, &load, &store, &cancel, &mut tell);
    assert!(matches!(ended, Err(StudyError::Cancelled)));
    let rest = study(&options, folder.path());
    assert_eq!(rest.rendered_samples, 512 * (2 * 64 - 16));
    let elsewhere = tempfile::tempdir().expect("folder");
    assert_eq!(found(&rest), found(&study(&options, elsewhere.path())));
}

#[test]
fn cuts_and_threads_change_no_sample() {
    let folder = tempfile::tempdir().expect("folder");
    let list = r#"[
      {"name": "tracking"},
      {"name": "other", "threads": 1, "tile": 7, "block": 5}
    ]"#;
    let study = study(&options(list), folder.path());
    let [one, other] = &study.scenes[0].variants[..] else {
        panic!("two variants");
    };
    for (a, b) in one.points.iter().zip(&other.points) {
        assert_eq!(
            (a.mse, a.own_mse, a.flip_hdr),
            (b.mse, b.own_mse, b.flip_hdr)
        );
    }
}

#[test]
fn a_variant_that_fails_says_where_and_stops_no_other() {
    let folder = tempfile::tempdir().expect("folder");
    let list = r#"[
      {"name": "thick", "scene": {"camera": {"vertical_fov_deg": 500}}},
      {"name": "nowhere", "set": {"/sun/radiance": 3}},
      {"name": "tracking"}
    ]"#;
    let study = study(&options(list), folder.path());
    let variants = &study.scenes[0].variants;
    let failure = |number: usize| variants[number].failure.clone().unwrap_or_default();
    assert!(
        failure(0).contains("camera.vertical_fov_deg"),
        "{}",
        failure(0)
    );
    assert!(failure(1).contains("/sun/radiance"), "{}", failure(1));
    assert_eq!(variants[2].points.len(), 2);

    let heading = Heading {
        title: "A <title>".to_owned(),
        ..Heading::default()
    };
    let page = html(&study, &heading);
    assert!(
        page.contains("A &lt;title&gt;") && page.contains("<svg"),
        "page"
    );
    assert!(page.contains("failed: ") && page.contains("data:image/png;base64,"));
    assert!(!page.contains("NaN") && !page.contains("http://localhost"));
    let lines = csv(&study);
    assert_eq!(lines.lines().count(), 1 + 1 + 1 + 2, "{lines}");
    let columns: Vec<usize> = lines
        .lines()
        .take(1)
        .map(|l| l.split(',').count())
        .collect();
    assert!(
        lines
            .lines()
            .skip(3)
            .all(|l| l.split(',').count() == columns[0]),
        "{lines}"
    );
    let text = markdown(&study, &heading);
    assert!(
        text.contains("| tracking |") && text.contains("failed"),
        "{text}"
    );
}

#[test]
fn a_given_reference_is_held_against() {
    let folder = tempfile::tempdir().expect("folder");
    let mut options = options(r#"[{"name": "tracking"}]"#);
    let white = |width| Picture {
        width,
        height: 16,
        rgb: vec![[1.0; 3]; width * 16],
        range: crate::picture::Range::Linear,
        planes: crate::picture::Planes::default(),
    };
    options.reference = Some(("white.exr".to_owned(), white(32)));
    let study = study(&options, folder.path());
    let last = study.scenes[0].variants[0].points[1];
    assert!(last.mean_difference < -0.1, "{last:?}");
    assert_eq!(study.rendered_samples, 512 * 64);
    options.reference = Some(("white.exr".to_owned(), white(16)));
    let store = Store::open(folder.path()).expect("store");
    let error = run_study(
        &options,
        &load,
        &store,
        &AtomicBool::new(false),
        &mut |_| {},
    )
    .expect_err("size")
    .to_string();
    assert!(
        error.contains("16x16") && error.contains("32x16"),
        "{error}"
    );
}
