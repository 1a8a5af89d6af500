//! Semi-opaque particles, alone and as shadows.

use crate::common::{CLOUD, WHITE_SKY, assert_mean, floor, mean_and_error, scene};
use shearwater_tracer::BuildOptions;

// Nothing is absorbed and light comes from everywhere: the cloud is invisible.
#[test]
fn a_white_cloud_in_a_white_furnace_is_invisible() {
    for opacity in [0.1, 0.5, 1.0] {
        let cloud = format!(
            r#""clouds":[{{{CLOUD},"count":60,"opacity":[{opacity},{opacity}],"albedo":[1,1,1]}}]"#
        );
        let body = format!("{cloud},{WHITE_SKY}");
        let scene = scene(
            &body,
            [0.0, 0.0, 9.0],
            [0.0; 3],
            30.0,
            8,
            BuildOptions::default(),
        );
        assert_mean(&format!("cloud of opacity {opacity}"), &scene, 256, 1.0);
    }
}

// k black particles of one place: each is crossed twice, T = (1 - a)^(2 k), and
// passing through costs no depth.
#[test]
fn black_layers_transmit_their_power() {
    for (count, opacity) in [(1u32, 0.5f64), (10, 0.1), (500, 0.002), (1000, 0.0005)] {
        let cloud = format!(
            r#""clouds":[{{"type":"particles","formation":{{"type":"radial","centre_m":[0,0,0],"radii_m":[1e-4,1e-4,1e-4],"direction":[1,0,0],"length_m":0}},"count":{count},
            "particle_radius_m":[1,1],"opacity":[{opacity},{opacity}],"albedo":[0,0,0]}}]"#
        );
        let scene = scene(
            &format!("{cloud},{WHITE_SKY}"),
            [0.0, 0.0, 9.0],
            [0.0; 3],
            4.0,
            9,
            BuildOptions::default(),
        );
        let expected = libm::pow(1.0 - opacity, 2.0 * f64::from(count));
        assert_mean(
            &format!("{count} layers of {opacity}"),
            &scene,
            1024,
            expected,
        );
    }
}

// The same transmittance, seen by a shadow ray: a floor under the particles lit
// by the sun from straight above.
#[test]
fn shadows_of_layers_transmit_the_same() {
    let sun = r#""sun":{"azimuth_deg":0,"elevation_deg":90,"angular_radius_deg":0.1,"radiance":[1e6,1e6,1e6]}"#;
    let cloud = r#""clouds":[{"type":"particles","formation":{"type":"radial","centre_m":[0,50,0],"radii_m":[1e-4,1e-4,1e-4],"direction":[1,0,0],"length_m":0},"count":20,
        "particle_radius_m":[5,5],"opacity":[0.03,0.03],"albedo":[0,0,0]}]"#;
    let ground = floor(r#"{"type":"lambert","albedo":[0.5,0.5,0.5]}"#);
    let eye = [3.0, 10.0, 0.0];
    let lit = scene(
        &format!("{ground},{sun}"),
        eye,
        [0.0; 3],
        4.0,
        10,
        BuildOptions::default(),
    );
    let dimmed = scene(
        &format!("{ground},{sun},{cloud}"),
        eye,
        [0.0; 3],
        4.0,
        10,
        BuildOptions::default(),
    );
    let ((full, _), (part, error)) = (mean_and_error(&lit, 16), mean_and_error(&dimmed, 16));
    let expected = full * libm::pow(0.97, 40.0);
    assert!(
        (part - expected).abs() < 5.0 * error + 1e-3 * expected,
        "{part}, expected {expected}"
    );
}
