//! Floors and a bowl under a white sky.

use crate::common::{WHITE_SKY, assert_mean, floor, mean_and_error, scene};
use shearwater_tracer::BuildOptions;

// A plane that sees the whole upper half of a white sky reflects its albedo.
#[test]
fn a_lambert_floor_under_a_white_sky_has_its_albedo() {
    let body = format!(
        "{},{WHITE_SKY}",
        floor(r#"{"type":"lambert","albedo":[0.6,0.6,0.6]}"#)
    );
    let scene = scene(
        &body,
        [0.0, 2.0, 0.0],
        [0.0, 0.0, 0.0],
        40.0,
        2,
        BuildOptions::default(),
    );
    assert_mean("lambert", &scene, 64, 0.6);
}

// The dielectric with an energy-conserving body is exactly white.
#[test]
fn a_white_ggx_floor_under_a_white_sky_is_white() {
    for roughness in [0.05, 0.4, 0.9] {
        let ggx = format!(r#"{{"type":"ggx","base_color":[1,1,1],"roughness":{roughness}}}"#);
        let body = format!("{},{WHITE_SKY}", floor(&ggx));
        for (eye, angle) in [([0.0, 3.0, 0.01], 0), ([0.0, 1.0, 6.0], 80)] {
            let scene = scene(&body, eye, [0.0; 3], 5.0, 3, BuildOptions::default());
            assert_mean(
                &format!("ggx {roughness} at {angle} degrees"),
                &scene,
                256,
                1.0,
            );
        }
    }
}

// Inside a sphere every point sees every other alike, so the radiance of the bowl
// is the same everywhere: half its light comes from the sky, half from itself,
// L = rho / 2 (1 + L). Paths are long and end by Russian roulette.
#[test]
fn a_bowl_under_a_white_sky_has_its_closed_form() {
    for rho in [0.5, 0.9, 0.99] {
        let body = format!(
            r#""materials":{{"m":{{"type":"lambert","albedo":[{rho},{rho},{rho}]}}}},
            "instances":[{{"mesh":"bowl","material":"m"}}],{WHITE_SKY}"#
        );
        let scene = scene(
            &body,
            [0.0, 0.5, 0.01],
            [0.0, -1.0, 0.0],
            20.0,
            14,
            BuildOptions::default(),
        );
        let (mean, error) = mean_and_error(&scene, 512);
        let expected = 0.5 * rho / (1.0 - 0.5 * rho);
        // The facets leave out 0.1 % of the sphere.
        assert!(
            (mean - expected).abs() < 5.0 * error + 2e-3 * expected,
            "{rho}: {mean} +- {error}, {expected}"
        );
        assert!(error < 0.01 * expected, "{rho}: {error}");
    }
}
