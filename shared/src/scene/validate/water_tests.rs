//! Water that is wrong is refused at its place.

use crate::scene::test_scene::{fails, with};
use serde_json::json;

#[test]
fn waters_by_hand_are_checked() {
    let gerstner = |waves: serde_json::Value| json!({"type": "gerstner", "waves": waves});
    let wave = |amplitude_m: f64| json!({"amplitude_m": amplitude_m, "wavelength_m": 10});
    let flat = |field: &str, value: serde_json::Value| json!({"type": "flat", field: value});
    let mut sine = gerstner(json!([wave(5.0)]));
    sine["profile"] = json!("sine");
    for water in [gerstner(json!([wave(1.59)])), sine, json!({"type": "flat"})] {
        crate::scene::parse(with("/water", water).as_bytes()).unwrap();
    }
    let long = json!({"amplitude_m": 0.1, "wavelength_m": 0});
    let turned = json!({"amplitude_m": 0.1, "wavelength_m": 9, "phase_deg": 1e7});
    for (water, path, message) in [
        (gerstner(json!([])), "water.waves", "0: expected 1 to 64"),
        (
            gerstner(json!(vec![wave(0.001); 65])),
            "water.waves",
            "65: expected 1 to 64",
        ),
        (
            gerstner(json!([wave(-1.0)])),
            "water.waves[0].amplitude_m",
            "0 to 1000000 m",
        ),
        (
            gerstner(json!([wave(0.1), long])),
            "water.waves[1].wavelength_m",
            "0.00001 to 1000000 m",
        ),
        (
            gerstner(json!([turned])),
            "water.waves[0].phase_deg",
            "degrees",
        ),
        (
            gerstner(json!([wave(1.0), wave(0.6)])),
            "water.waves",
            "sums to 1.0053: expected at most 1",
        ),
        (
            flat("texture", json!("/sea.png")),
            "water.texture",
            "relative to scene.json",
        ),
        (
            flat("texture_size_m", json!(0)),
            "water.texture_size_m",
            "0: expected 0.00001 to 1000000 m",
        ),
        (flat("ior", json!(0.9)), "water.ior", "1 to 4"),
        (
            json!({"type": "deep"}),
            "water.type",
            "`deep`: expected `tessendorf` or `gerstner` or `flat`",
        ),
    ] {
        fails(&with("/water", water), path, message);
    }
}

#[test]
fn the_texture_of_the_water_is_a_file_of_the_scene() {
    let water = json!({"type": "flat", "texture": "tex/sea.png"});
    let scene = crate::scene::parse(with("/water", water).as_bytes()).unwrap();
    assert!(scene.files().contains("tex/sea.png"));
}
