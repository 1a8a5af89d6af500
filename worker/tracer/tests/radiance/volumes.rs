//! Volumes in whole scenes: what they scatter, dim and leave visible.

use crate::common::{
    CLOUD, LAMP_RADIANCE, LAMP_SIZE, LAMP_TEXEL, RECT, WHITE_SKY, assert_mean, floor,
    mean_and_error, scene, sums,
};
use shearwater_shared::film::TileFilm;
use shearwater_tracer::{BuildOptions, Scene};
use std::f64::consts::PI;

const NOISE: &str = r#""edge":0.5,"resolution":32,"noise":{"scale_m":1.3,"seed":4}"#;

/// An ellipsoid, `more` inside its shape, `last` after it.
fn ellipsoid(centre: [f64; 3], radii: [f64; 3], more: &str, last: &str) -> String {
    let comma = if more.is_empty() { "" } else { "," };
    format!(
        r#"{{"type":"volume","shape":{{"type":"ellipsoid","centre_m":{centre:?},"radii_m":{radii:?}{comma}{more}}},{last}}}"#
    )
}

fn sun(elevation: f64, radiance: f64) -> String {
    format!(
        r#""sun":{{"azimuth_deg":90,"elevation_deg":{elevation},"angular_radius_deg":0.1,"radiance":[{radiance},{radiance},{radiance}]}}"#
    )
}

/// Irradiance of [`sun`] on a surface that faces it.
fn irradiance(radiance: f64) -> f64 {
    let sin = libm::sin(0.1f64.to_radians());
    PI * radiance * sin * sin
}

fn seen(body: &str, eye: [f64; 3], target: [f64; 3], fov: f64) -> Scene {
    scene(body, eye, target, fov, 21, BuildOptions::default())
}

// Nothing is absorbed and light comes from everywhere: every path ends in the sky with
// all its weight, so the picture is 1 without any noise, whatever the density, the
// lobe, the method.
#[test]
fn a_white_volume_in_a_white_furnace_is_invisible() {
    let [front, back] = ["0.7", "-0.4"].map(|g| {
        let last = format!(r#""sigma_t_per_m":6,"g":{g}"#);
        ellipsoid([0.0; 3], [2.0, 1.0, 1.5], NOISE, &last)
    });
    let march = r#""sigma_t_per_m":2,"method":{"type":"march","step_m":0.3}"#;
    let marched = ellipsoid([1.0, 0.0, 0.0], [1.0; 3], NOISE, march);
    let body = format!(r#""clouds":[{front},{back},{marched}],{WHITE_SKY}"#);
    let scene = seen(&body, [0.0, 0.0, 6.0], [0.0; 3], 30.0);
    let (mean, _) = mean_and_error(&scene, 64);
    assert!((mean - 1.0).abs() < 1e-5, "{mean}");
    let sums = sums(&scene, 0..8);
    assert_eq!(sums.depth_cap_hits, 0);
    // Half of the albedo: darker, by something between single and no scattering.
    let grey = body.replace(
        "\"sigma_t_per_m\"",
        "\"albedo\":[0.5,0.5,0.5],\"sigma_t_per_m\"",
    );
    let (mean, _) = mean_and_error(&seen(&grey, [0.0, 0.0, 6.0], [0.0; 3], 30.0), 64);
    assert!(mean < 0.9, "{mean}");
}

// A black volume over a floor, away from the sun's way to it: T times the floor.
#[test]
fn what_is_behind_a_volume_shines_through() {
    let ground = floor(r#"{"type":"lambert","albedo":[0.5,0.5,0.5]}"#);
    let lit = irradiance(1e6) * 0.5 * 0.5 / PI;
    for sigma in [0.01, 0.1, 0.3] {
        let last = format!(r#""sigma_t_per_m":{sigma},"albedo":[0,0,0]"#);
        let ball = ellipsoid([0.0, 20.0, 0.0], [5.0; 3], "", &last);
        let body = format!(r#""clouds":[{ball}],{},{ground}"#, sun(30.0, 1e6));
        let scene = seen(&body, [0.0, 50.0, 0.0], [0.0; 3], 0.2);
        let passed = libm::exp(-10.0 * sigma);
        assert_mean(&format!("through {sigma}"), &scene, 1024, lit * passed);
    }
}

// The sun through a volume onto a floor: the shadow has the same transmittance. An
// even volume's shadow is free of noise.
#[test]
fn a_volume_casts_a_shadow_as_thick_as_it_is() {
    let ground = floor(r#"{"type":"lambert","albedo":[0.5,0.5,0.5]}"#);
    let lit = irradiance(1e6) * 0.5 / PI;
    for sigma in [0.01, 0.1, 0.3] {
        let last = format!(r#""sigma_t_per_m":{sigma},"albedo":[0,0,0]"#);
        let ball = ellipsoid([0.0, 50.0, 0.0], [5.0; 3], "", &last);
        let body = format!(r#""clouds":[{ball}],{},{ground}"#, sun(90.0, 1e6));
        let scene = seen(&body, [0.0, 10.0, 0.0], [0.0; 3], 0.5);
        let passed = libm::exp(-10.0 * sigma);
        let (mean, error) = mean_and_error(&scene, 16);
        assert!(
            (mean / (lit * passed) - 1.0).abs() < 2e-3,
            "{sigma}: {mean}"
        );
        assert!(error < 1e-4 * mean, "{sigma}: {error}");
    }
}

#[test]
fn a_camera_may_stand_inside() {
    let ball = ellipsoid(
        [1.0, 2.0, 3.0],
        [4.0; 3],
        "",
        r#""sigma_t_per_m":0.2,"albedo":[0,0,0]"#,
    );
    let body = format!(r#""clouds":[{ball}],{WHITE_SKY}"#);
    let scene = seen(&body, [1.0, 2.0, 3.0], [5.0, 6.0, 3.0], 40.0);
    assert_mean("inside", &scene, 512, libm::exp(-0.8));
}

/// A slab of optical thickness 1 about y = 1 that scatters a thousandth of the light.
fn slab(g: f64) -> String {
    let last = format!(r#""sigma_t_per_m":1,"albedo":[1e-3,1e-3,1e-3],"g":{g}"#);
    ellipsoid([0.0, 1.0, 0.0], [9e3, 0.5, 9e3], "", &last)
}

fn henyey_greenstein(g: f64, cos: f64) -> f64 {
    let base = 1.0 + g * g - 2.0 * g * cos;
    (1.0 - g * g) / (4.0 * PI * base * base.sqrt())
}

// What a slab sends straight up when light falls on it at `mu`, per irradiance across
// the light: single scattering, for more of it is a thousandth of that.
fn slab_reflects(g: f64, mu: f64) -> f64 {
    1e-3 * henyey_greenstein(g, -mu) * mu / (1.0 + mu) * (1.0 - libm::exp(-1.0 - 1.0 / mu))
}

fn assert_slab(what: &str, scene: &Scene, expected: f64) {
    let (mean, error) = mean_and_error(scene, 2048);
    assert!(
        (mean - expected).abs() < 5.0 * error + 2e-3 * expected,
        "{what}: {mean} +- {error}, expected {expected}"
    );
    assert!(
        error < 0.01 * expected,
        "{what}: too noisy to tell, {error}"
    );
}

#[test]
fn a_slab_under_the_sun_scatters_as_its_closed_form_says() {
    for (g, elevation) in [(0.0, 90.0), (0.6, 90.0), (-0.5, 30.0)] {
        let body = format!(r#""clouds":[{}],{}"#, slab(g), sun(elevation, 6e7));
        let scene = seen(&body, [0.0, 9.0, 0.0], [0.0; 3], 1.0);
        let mu = libm::sin(elevation.to_radians());
        let expected = irradiance(6e7) * slab_reflects(g, mu);
        assert_slab(&format!("g {g} at {elevation}"), &scene, expected);
    }
}

// The same slab over a black floor under an uneven sky: the sky is sampled, and so is
// the phase function, with weights that must add up.
#[test]
fn a_slab_under_an_uneven_sky_scatters_as_its_integral_says() {
    let sky = r#""sky":{"type":"map","file":"lamp.exr"}"#;
    let ground = floor(r#"{"type":"lambert","albedo":[0,0,0]}"#);
    let [width, height] = LAMP_SIZE.map(|n| n as f64);
    for g in [0.0, 0.6, -0.8] {
        let rings = 16 * 200;
        let mut expected = 0.0;
        for j in 0..rings {
            let v = (f64::from(j) + 0.5) / f64::from(rings) / 2.0;
            let theta = PI * v;
            let hat = (1.0 - (v * height - LAMP_TEXEL[1] as f64 - 0.5).abs()).max(0.0);
            let lamp = (f64::from(LAMP_RADIANCE) - 0.1) * hat / width;
            let ring = PI * PI / f64::from(rings) * libm::sin(theta);
            expected += (0.1 + lamp) * ring * slab_reflects(g, libm::cos(theta));
        }
        let body = format!(r#""clouds":[{}],{sky},{ground}"#, slab(g));
        let scene = seen(&body, [0.0, 9.0, 0.0], [0.0; 3], 1.0);
        assert_slab(&format!("g {g}"), &scene, expected);
    }
}

fn crowd() -> String {
    let water = r#""water":{"type":"tessendorf","height_m":-1,"tile_m":50,"wind_speed_mps":8,"velocity_mps":[0,40]}"#;
    let particles = format!(r#"{{{CLOUD},"count":40,"opacity":[0.2,0.6]}}"#);
    let noisy = ellipsoid(
        [0.0, 0.5, 0.0],
        [3.0, 2.0, 4.0],
        NOISE,
        r#""sigma_t_per_m":2,"g":0.6"#,
    );
    let march = r#""sigma_t_per_m":1,"method":{"type":"march","step_m":0.2}"#;
    let marched = ellipsoid([1.0, 0.0, 2.0], [2.0; 3], NOISE, march);
    let ground = floor(r#"{"type":"ggx","base_color":[0.8,0.3,0.2],"roughness":0.3}"#).replace(
        "\"floor\",",
        "\"floor\",\"scale\":[1e-4,1,1e-4],\"rotate_deg\":[80,0,5],",
    );
    format!(
        r#"{water},{},"clouds":[{noisy},{particles},{marched}],{ground},{WHITE_SKY}"#,
        sun(8.0, 6e4)
    )
}

// Any cut of the samples, and the machine without AVX2, give the same integers.
#[test]
fn sums_with_volumes_do_not_depend_on_cuts_or_instructions() {
    let eye = [0.0, 2.0, 9.0];
    let one = seen(&crowd(), eye, [0.0; 3], 50.0);
    let options = BuildOptions {
        portable_simd: true,
    };
    let portable = scene(&crowd(), eye, [0.0; 3], 50.0, 21, options);
    let whole = sums(&one, 0..16);
    assert_eq!(sums(&portable, 0..16), whole);
    let mut film = TileFilm::zero(RECT.pixels());
    for range in [9..16, 0..1, 4..9, 1..4] {
        film.add(&sums(&one, range)).expect("fits");
    }
    let mut expected = TileFilm::zero(RECT.pixels());
    expected.add(&whole).expect("fits");
    assert_eq!(film, expected);
    assert!(whole.radiance[0].iter().any(|&v| v > 0) && whole.radiance[0] != whole.radiance[1]);
}

// A volume that holds nothing leaves no trace, not even in the last bit.
#[test]
fn an_empty_volume_is_none() {
    let ground = floor(r#"{"type":"lambert","albedo":[0.5,0.5,0.5]}"#);
    let none = format!("{ground},{WHITE_SKY},{}", sun(40.0, 1e3));
    let nothing = ellipsoid([0.0; 3], [5.0; 3], "", r#""sigma_t_per_m":0"#);
    let empty = format!(r#"{none},"clouds":[{nothing}]"#);
    let [none, empty] = [none, empty].map(|body| seen(&body, [0.0, 3.0, 9.0], [0.0; 3], 40.0));
    assert_eq!(none.uses(), empty.uses());
    assert_eq!(sums(&none, 0..8), sums(&empty, 0..8));
}
