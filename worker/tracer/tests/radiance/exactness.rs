//! The same integers, however the work is cut.

use crate::common::{CLOUD, RECT, WHITE_SKY, floor, scene, sums};
use shearwater_shared::film::TileFilm;
use shearwater_tracer::{BuildOptions, render_run};
use std::sync::atomic::AtomicBool;

fn everything() -> String {
    let water = r#""water":{"type":"tessendorf","height_m":-1,"tile_m":50,"wind_speed_mps":8,"velocity_mps":[0,40]}"#;
    let sun = r#""sun":{"azimuth_deg":20,"elevation_deg":8,"radiance":[6e4,4e4,2e4]}"#;
    let cloud = format!(r#""clouds":[{{{CLOUD},"count":80,"opacity":[0.2,0.6]}}]"#);
    let ground = floor(r#"{"type":"ggx","base_color":[0.8,0.3,0.2],"roughness":0.3}"#).replace(
        "\"floor\",",
        "\"floor\",\"scale\":[1e-4,1,1e-4],\"rotate_deg\":[80,0,5],",
    );
    format!("{water},{sun},{cloud},{ground},{WHITE_SKY}")
}

// Any cut of the samples, and the machine without AVX2, give the same integers.
#[test]
fn sums_do_not_depend_on_cuts_or_instructions() {
    let eye = [0.0, 3.0, 12.0];
    let one = scene(
        &everything(),
        eye,
        [0.0; 3],
        50.0,
        12,
        BuildOptions::default(),
    );
    let portable = scene(
        &everything(),
        eye,
        [0.0; 3],
        50.0,
        12,
        BuildOptions {
            portable_simd: true,
        },
    );
    let whole = sums(&one, 0..24);
    assert_eq!(sums(&portable, 0..24), whole);
    let mut film = TileFilm::zero(RECT.pixels());
    for range in [13..24, 0..1, 4..13, 1..4] {
        film.add(&sums(&one, range)).expect("fits");
    }
    let mut expected = TileFilm::zero(RECT.pixels());
    expected.add(&whole).expect("fits");
    assert_eq!(film, expected);
    assert!(whole.radiance[0].iter().any(|&v| v > 0) && whole.radiance[0] != whole.radiance[1]);
}

#[test]
fn another_seed_is_another_picture() {
    let eye = [0.0, 3.0, 12.0];
    let one = scene(
        &everything(),
        eye,
        [0.0; 3],
        50.0,
        12,
        BuildOptions::default(),
    );
    let two = scene(
        &everything(),
        eye,
        [0.0; 3],
        50.0,
        13,
        BuildOptions::default(),
    );
    assert_ne!(sums(&one, 0..2).radiance, sums(&two, 0..2).radiance);
}

#[test]
fn a_cancelled_run_gives_nothing() {
    let scene = scene(
        WHITE_SKY,
        [0.0, 3.0, 12.0],
        [0.0; 3],
        50.0,
        12,
        BuildOptions::default(),
    );
    assert!(render_run(&scene, &RECT, 0..8, &AtomicBool::new(true)).is_none());
}
