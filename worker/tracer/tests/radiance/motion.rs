//! Blur by motion, from scene.json to pixels: black cards before a white sky.

use crate::common::{RECT, SIDE, sums};
use serde_json::{Value, json};
use shearwater_shared::film::TileFilm;
use shearwater_shared::job::RenderSettings;
use shearwater_shared::scene::parse;
use shearwater_tracer::{Assets, BuildOptions, Scene, Stage, uses};
use std::sync::Arc;

/// An L, so that no turn leaves it as it is.
const CARD: &str =
    "v -1 -1 0\nv 1 -1 0\nv 1 -0.4 0\nv -0.3 -0.4 0\nv -0.3 1 0\nv -1 1 0\nf 1 2 3 4\nf 1 4 5 6\n";

fn description(instances: &Value, camera: &Value, animation: &Value) -> Value {
    let mut seen = json!({"position_m": [0, 0, 8], "target_m": [0, 0, 0], "vertical_fov_deg": 40});
    for (key, value) in camera.as_object().unwrap() {
        seen[key] = value.clone();
    }
    json!({
        "version": 1, "name": "motion", "image": {"width": SIDE, "height": SIDE},
        "camera": seen, "animation": animation,
        "materials": {"black": {"type": "lambert", "albedo": [0, 0, 0]}},
        "meshes": {"card": {"file": "card.obj", "materials": {}}},
        "instances": instances, "sky": {"type": "constant", "radiance": [1, 1, 1]}
    })
}

fn stage(description: &Value) -> Stage {
    let assets: Assets = [("card.obj".to_owned(), Arc::from(CARD.as_bytes()))].into();
    let description = parse(description.to_string().as_bytes()).unwrap();
    Stage::build(&description, &assets, BuildOptions::default())
        .unwrap()
        .0
}

fn frame(stage: &Stage, frame: u32) -> Scene {
    let settings = RenderSettings {
        width: SIDE,
        height: SIDE,
        samples: 2,
        seed: 5,
        frames: 1,
        first_frame: 0,
        stop: shearwater_shared::stop::Stop::NONE,
    };
    stage.frame(&settings, frame).unwrap()
}

fn picture(scene: &Scene, samples: u32) -> Vec<f64> {
    let mut film = TileFilm::zero(RECT.pixels());
    film.add(&sums(scene, 0..samples)).unwrap();
    let mean = |pixel| (film.half_mean(0, pixel)[0] + film.half_mean(1, pixel)[0]) / 2.0;
    (0..RECT.pixels()).map(mean).collect()
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

/// Everything that moves, at once: a child that spins on a parent that slides and
/// follows keys.
fn moving_cards() -> Value {
    json!([
        {"mesh": "card", "material": "black", "name": "body", "translate_m": [-1, 0, 0], "velocity_mps": [4, 0, 0],
         "path": [{"time_s": 0}, {"time_s": 0.2, "offset_m": [0, 1, 0], "turn_deg": [0, 0, 40]}, {"time_s": 0.5}]},
        {"mesh": "card", "material": "black", "parent": "body", "translate_m": [1.5, 0, -1], "scale": [0.7, 0.7, 0.7],
         "spin": {"axis": [0, 0, 2], "rpm": 200, "pivot_m": [0.3, 0, 0]}}
    ])
}

#[test]
fn no_shutter_no_motion_bit_for_bit() {
    // At time 0 everything is where it is placed.
    let still = json!([
        {"mesh": "card", "material": "black", "name": "body", "translate_m": [-1, 0, 0]},
        {"mesh": "card", "material": "black", "parent": "body", "translate_m": [1.5, 0, -1], "scale": [0.7, 0.7, 0.7]}
    ]);
    let moving = frame(
        &stage(&description(
            &moving_cards(),
            &json!({"velocity_mps": [1, 0, 0], "shutter_s": 0}),
            &Value::Null,
        )),
        0,
    );
    let standing = frame(
        &stage(&description(
            &still,
            &json!({"shutter_s": 0.3}),
            &Value::Null,
        )),
        0,
    );
    assert_eq!(
        (moving.uses(), standing.uses()),
        (uses::NOTHING, uses::NOTHING)
    );
    assert_eq!(sums(&moving, 0..16), sums(&standing, 0..16));
    // And with an open shutter it does move.
    let open = frame(
        &stage(&description(
            &moving_cards(),
            &json!({"shutter_s": 0.3}),
            &Value::Null,
        )),
        0,
    );
    assert_eq!(open.uses(), uses::MOTION);
    assert_ne!(sums(&open, 0..16).radiance, sums(&standing, 0..16).radiance);
}

#[test]
fn a_camera_that_flies_along_sees_its_company_still() {
    let velocity = json!([30, -12, 5]);
    let cards = |velocity: &Value| {
        json!([
            {"mesh": "card", "material": "black", "velocity_mps": velocity, "translate_m": [-0.7, 0, 0]},
            {"mesh": "card", "material": "black", "translate_m": [7, 1, -20], "scale": [2, 2, 1]}
        ])
    };
    let animation = json!({"fps": 10, "frames": 30});
    let together = description(
        &cards(&velocity),
        &json!({"velocity_mps": velocity, "shutter_s": 0.05}),
        &animation,
    );
    let together = stage(&together);
    let still = description(
        &cards(&json!([0, 0, 0])),
        &json!({"shutter_s": 0.05}),
        &Value::Null,
    );
    let still = picture(&frame(&stage(&still), 0), 512);
    let flying = picture(&frame(&together, 0), 512);
    let (left, right): (Vec<usize>, Vec<usize>) =
        (0..RECT.pixels()).partition(|pixel| pixel % SIDE as usize <= SIDE as usize / 2);
    let pick = |of: &[f64], at: &[usize]| at.iter().map(|&i| of[i]).collect::<Vec<_>>();
    let company = largest_difference(&pick(&flying, &left), &pick(&still, &left));
    assert!(company < 4.0 / 1024.0, "{company}");
    let background = largest_difference(&pick(&flying, &right), &pick(&still, &right));
    assert!(background > 0.3, "the background blurs: {background}");
    // Two seconds later, far from where both began, and at the edge of their path.
    let later = picture(&frame(&together, 29), 512);
    let company = largest_difference(&pick(&later, &left), &pick(&still, &left));
    assert!(company < 4.0 / 1024.0, "{company}");
}

#[test]
fn a_frame_does_not_depend_on_the_frames_before_it() {
    let animation = json!({"fps": 5, "frames": 4});
    let described = description(
        &moving_cards(),
        &json!({"shutter_s": 0.1, "velocity_mps": [0, 1, 0]}),
        &animation,
    );
    let (one, other) = (stage(&described), stage(&described));
    frame(&one, 0);
    frame(&one, 1);
    assert_eq!(sums(&frame(&one, 3), 0..8), sums(&frame(&other, 3), 0..8));
    assert_ne!(
        sums(&frame(&one, 3), 0..8).radiance,
        sums(&frame(&one, 2), 0..8).radiance
    );
}
