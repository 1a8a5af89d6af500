//! The same light under every choice.

use crate::common::{floor, mean_and_error, scene, with};
use serde_json::{Value, json};

const SIDE: u32 = 16;

fn variants() -> Vec<Value> {
    vec![
        json!({"sampler": "independent"}),
        json!({"sobol_scatterings": 0}),
        json!({"sobol_scatterings": 8}),
        json!({"mis": "balance"}),
        json!({"mis": "lights_only"}),
        json!({"mis": "scattering_only"}),
        json!({"map_compensation": false}),
        json!({"map_compensation": false, "mis": "balance"}),
        json!({"map_compensation": false, "mis": "lights_only"}),
        json!({"sky_sampling": "rough"}),
        json!({"sky_sampling": "any_sky"}),
        json!({"sky_sampling": "always", "map_compensation": false}),
        json!({"sky_sampling": "always"}),
        json!({"sky_sampling": "always", "mis": "lights_only"}),
        json!({"sky_sampling": "never"}),
        json!({"faint_share": 0}),
        json!({"faint_share": 1}),
        json!({"roulette": {"rule": "none"}}),
        json!({"roulette": {"rule": "albedo", "from": 0}}),
        json!({"roulette": {"rule": "throughput_root", "from": 1}}),
        json!({"roulette": {"from": 0, "survival_min": 0.5}}),
    ]
}

fn spotted() -> Value {
    json!({"sky": {"type": "map", "file": "spotted.exr"},
        "sun": {"azimuth_deg": 120, "elevation_deg": 50, "angular_radius_deg": 20, "radiance": [3, 3, 3]}})
}

fn bowl(albedo: f64) -> Value {
    json!({"materials": {"m": {"type": "lambert", "albedo": [albedo, albedo, albedo]}},
        "instances": [{"mesh": "bowl", "material": "m"}],
        "camera": {"position_m": [0, 3, 0], "target_m": [0, -1, 0], "up": [0, 0, -1], "vertical_fov_deg": 12}})
}

// Against the same scene with nothing chosen. Twenty variants of each, five standard
// errors: one false alarm in 10^4 runs over all, were the seeds not fixed.
fn agree(what: &str, fields: &Value, samples: u32) {
    let built = scene(SIDE, fields, &json!({}), 100);
    let (expected, expected_error) = mean_and_error(&built, SIDE, 2 * samples);
    for (sampling, seed) in variants().into_iter().zip(200..) {
        let built = scene(SIDE, fields, &sampling, seed);
        let (mean, error) = mean_and_error(&built, SIDE, samples);
        let both = (error * error + expected_error * expected_error).sqrt();
        assert!(
            (mean - expected).abs() < 5.0 * both,
            "{what}, {sampling}: {mean} +- {error}, expected {expected} +- {expected_error}"
        );
        assert!(
            both < 0.04 * expected,
            "{what}, {sampling}: too noisy to tell, {both} of {expected}"
        );
    }
}

#[test]
fn a_diffuse_floor() {
    let ground = floor(&json!({"type": "lambert", "albedo": [0.5, 0.5, 0.5]}));
    agree("diffuse", &with(&ground, &spotted()), 128);
}

#[test]
fn shiny_floors() {
    for roughness in [0.2, 0.6] {
        let ground = floor(&json!({"type": "ggx", "metalness": 1, "roughness": roughness}));
        agree(
            &format!("metal {roughness}"),
            &with(&ground, &spotted()),
            256,
        );
    }
}

// A perfect mirror over a diffuse body: the mirror's light no light sample finds.
#[test]
fn a_varnished_floor() {
    let ground = floor(
        &json!({"type": "ggx", "roughness": 0, "specular_f0": 0.4, "base_color": [0.5, 0.5, 0.5]}),
    );
    agree("varnish", &with(&ground, &spotted()), 256);
}

#[test]
fn many_scatterings() {
    agree("bowl", &with(&bowl(0.9), &spotted()), 128);
}

#[test]
fn a_cloud() {
    let cloud = json!({"clouds": [{"type": "volume", "sigma_t_per_m": 2, "g": 0.7,
        "shape": {"type": "ellipsoid", "centre_m": [0, 0, 0], "radii_m": [1, 1, 1], "resolution": 16}}],
        "camera": {"position_m": [0, 1, 5], "target_m": [0, 0, 0], "vertical_fov_deg": 15}});
    agree("cloud", &with(&cloud, &spotted()), 128);
}

#[test]
fn under_a_dome() {
    let ground = floor(&json!({"type": "lambert", "albedo": [0.5, 0.5, 0.5]}));
    let dome = json!({"sky": {"type": "dome", "file": "spotted.exr", "centre_m": [3, 1, -2], "radius_m": 20}});
    agree("dome", &with(&with(&ground, &spotted()), &dome), 128);
}

// Every point of a hemisphere sees itself for one half (areas over the sphere's):
// L = rho / 2 (1 + L) under a sky of 1, so L = rho / (2 - rho).
#[test]
fn a_bowl_has_its_analytic_radiance_under_every_choice() {
    let white = json!({"sky": {"type": "constant", "radiance": [1, 1, 1]}});
    let expected = 0.8 / (2.0 - 0.8);
    for (sampling, seed) in variants().into_iter().zip(300..) {
        let built = scene(SIDE, &with(&bowl(0.8), &white), &sampling, seed);
        let (mean, error) = mean_and_error(&built, SIDE, 256);
        // 1e-3 of it for facets instead of a sphere.
        assert!(
            (mean - expected).abs() < 4.0 * error + 1e-3 * expected && error < 3e-3,
            "{sampling}: {mean} +- {error}, expected {expected}"
        );
    }
}

// The sun's irradiance is pi L sin^2(r) sin(elevation), however it is found.
#[test]
fn the_sun_gives_its_irradiance_under_every_choice() {
    let ground = floor(&json!({"type": "lambert", "albedo": [0.5, 0.5, 0.5]}));
    let sun = json!({"sun": {"azimuth_deg": 10, "elevation_deg": 50, "angular_radius_deg": 30, "radiance": [1, 1, 1]}});
    let expected = 0.5 * 0.25 * libm::sin(50f64.to_radians());
    for (sampling, seed) in variants().into_iter().zip(400..) {
        let built = scene(SIDE, &with(&ground, &sun), &sampling, seed);
        let (mean, error) = mean_and_error(&built, SIDE, 128);
        assert!(
            (mean - expected).abs() < 4.0 * error + 1e-5 * expected && error < 1e-2 * expected,
            "{sampling}: {mean} +- {error}, expected {expected}"
        );
    }
}
