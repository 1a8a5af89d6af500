//! Scenes inside and outside a finite dome.

use crate::common::{LAMP_RADIANCE, LAMP_SIZE, LAMP_TEXEL, assert_mean, floor, scene};
use glam::DVec3;
use shearwater_tracer::{BuildOptions, Scene};
use std::f64::consts::PI;

const CENTRE: DVec3 = DVec3::new(12.0, -5.0, 30.0);
const RADIUS: f64 = 60.0;
const DOME: &str = r#""sky":{"type":"dome","file":"lamp.exr","centre_m":[12,-5,30],"radius_m":60}"#;

fn seen(body: &str, eye: [f64; 3], target: [f64; 3], fov: f64) -> Scene {
    scene(body, eye, target, fov, 21, BuildOptions::default())
}

// Radiance of the lamp's map at (u, v) in texels.
fn lamp(x: f64, y: f64) -> f64 {
    let hat = |x: f64, centre: usize| (1.0 - (x - centre as f64 - 0.5).abs()).max(0.0);
    0.1 + (f64::from(LAMP_RADIANCE) - 0.1) * hat(x, LAMP_TEXEL[0]) * hat(y, LAMP_TEXEL[1])
}

// E = sum over the wall of L A cos cos / d^2, for a floor far from the centre.
#[test]
fn a_dome_lights_a_floor_by_inverse_squares() {
    let at = DVec3::new(-4.0, 0.0, 3.0);
    let [width, height] = LAMP_SIZE;
    let (fine, mut irradiance) = (16, 0.0);
    let step = |k: usize| (k as f64 + 0.5) / fine as f64;
    for j in 0..height * fine {
        let theta = PI * step(j) / height as f64;
        let area = RADIUS * RADIUS * libm::sin(theta) * 2.0 * PI * PI
            / (width * height * fine * fine) as f64;
        for i in 0..width * fine {
            let phi = 2.0 * PI * (step(i) / width as f64 - 0.5);
            let n = DVec3::new(
                libm::sin(theta) * libm::sin(phi),
                libm::cos(theta),
                -libm::sin(theta) * libm::cos(phi),
            );
            let d = CENTRE + n * RADIUS - at;
            let squared = d.length_squared();
            irradiance +=
                lamp(step(i), step(j)) * area * d.y.max(0.0) * d.dot(n) / (squared * squared);
        }
    }
    let ground = floor(r#"{"type":"lambert","albedo":[0.5,0.5,0.5]}"#);
    let scene = seen(
        &format!("{ground},{DOME}"),
        [at.x, 2.0, at.z + 1e-3],
        at.to_array(),
        0.2,
    );
    assert_mean("floor", &scene, 512, 0.5 / PI * irradiance);
}

// The floor goes on for kilometres, the dome ends after metres: its wall hides
// what lies beyond, for the eye and for light alike.
#[test]
fn what_lies_beyond_the_dome_is_hidden() {
    let ground = floor(r#"{"type":"lambert","albedo":[0,0,0]}"#);
    let body = format!("{ground},{DOME}");
    let (eye, low) = ([12.0, 2.0, 30.0], [112.0, -0.5, 30.0]);
    assert_mean("wall before the floor", &seen(&body, eye, low, 0.1), 4, 0.1);
    let near = [32.0, 0.0, 30.0];
    assert_mean(
        "floor before the wall",
        &seen(&body, eye, near, 0.1),
        4,
        0.0,
    );
    // From outside: through the near wall to the far one, or past it to nothing.
    let outside = [12.0, 20.0, 230.0];
    let up = [12.0, 25.0, 0.0];
    assert_mean("far wall", &seen(&body, outside, up, 0.1), 4, 0.1);
    let away = [12.0, 90.0, 500.0];
    assert_mean("nothing", &seen(&body, outside, away, 0.1), 4, 0.0);
}

// The sun shines through the wall, whether it is sampled or met by chance; a sun
// over a mirror is met only by chance.
#[test]
fn the_sun_shines_through_the_dome() {
    let sun =
        r#""sun":{"azimuth_deg":90,"elevation_deg":45,"angular_radius_deg":10,"radiance":[3,3,3]}"#;
    let (eye, target) = ([7.0, 5.0, 30.0], [12.0, 0.0, 30.0]);
    let with = |material: &str, sky: &str| {
        seen(&format!("{},{sun}{sky}", floor(material)), eye, target, 0.2)
    };
    let mirror = r#"{"type":"ggx","base_color":[1,1,1],"metalness":1,"roughness":0}"#;
    // The wall where the mirrored ray meets it.
    assert_mean("mirror", &with(mirror, &format!(",{DOME}")), 64, 3.1);
    let matt = r#"{"type":"lambert","albedo":[1,1,1]}"#;
    let alone = crate::common::mean_and_error(&with(matt, ""), 256).0;
    let half_angle = 10f64.to_radians();
    let expected = 3.0 * libm::sin(half_angle) * libm::sin(half_angle) * libm::sin(PI / 4.0);
    assert!(
        (alone / expected - 1.0).abs() < 0.01,
        "{alone} against {expected}"
    );
    let (both, error) = crate::common::mean_and_error(&with(matt, &format!(",{DOME}")), 1024);
    let dome = seen(&format!("{},{DOME}", floor(matt)), eye, target, 0.2);
    let (without, other) = crate::common::mean_and_error(&dome, 1024);
    assert!(
        (both - without - expected).abs() < 5.0 * (error + other) + 1e-3 * expected,
        "{both} - {without} against {expected}"
    );
}
