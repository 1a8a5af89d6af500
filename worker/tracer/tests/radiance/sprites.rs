//! Sprites in the path tracer, and clouds by a picture.

use crate::common::{WHITE_SKY, assert_mean, floor, mean_and_error, scene};
use shearwater_shared::job::RenderSettings;
use shearwater_shared::scene::{SceneError, parse};
use shearwater_tracer::{Assets, BuildOptions, BuildReport, Scene, Stage};
use std::sync::Arc;

const EYE: [f64; 3] = [0.0, 0.0, 9.0];

/// `count` sprites in a ball of 2 m.
fn sprites(count: u32, opacity: f64, albedo: f64, more: &str) -> String {
    format!(
        r#""clouds":[{{"type":"sprites","formation":{{"type":"radial","centre_m":[0,0,0],"radii_m":[2,2,2],"direction":[1,0,0],"length_m":1}},"sprite_radius_m":[0.5,1.5],
        "count":{count},"opacity":[{opacity},{opacity}],"albedo":[{albedo},{albedo},{albedo}]{more}}}]"#
    )
}

// Nothing is absorbed and light comes from everywhere: the cloud is invisible,
// whichever way it scatters.
#[test]
fn white_sprites_in_a_white_furnace_are_invisible() {
    for (opacity, more) in [
        (0.1, ""),
        (0.6, r#","softness":0.3"#),
        (1.0, r#","g":0.7"#),
        (1.0, r#","softness":0.01,"g":-0.5"#),
    ] {
        let body = format!("{},{WHITE_SKY}", sprites(80, opacity, 1.0, more));
        let scene = scene(&body, EYE, [0.0; 3], 30.0, 8, BuildOptions::default());
        assert_mean(
            &format!("sprites of opacity {opacity}{more}"),
            &scene,
            256,
            1.0,
        );
    }
}

// k black sprites of one place, seen through their middle: (1 - a)^k.
#[test]
fn black_sprites_transmit_their_power() {
    for (count, opacity) in [(1u32, 0.5f64), (20, 0.1), (1000, 0.001)] {
        let cloud = format!(
            r#""clouds":[{{"type":"sprites","formation":{{"type":"radial","centre_m":[0,0,0],"radii_m":[1e-6,1e-6,1e-6],"direction":[1,0,0],"length_m":0}},"count":{count},
            "sprite_radius_m":[90,90],"opacity":[{opacity},{opacity}],"albedo":[0,0,0],"softness":0.5}}]"#
        );
        let body = format!("{cloud},{WHITE_SKY}");
        let scene = scene(&body, EYE, [0.0; 3], 4.0, 9, BuildOptions::default());
        let expected = libm::pow(1.0 - opacity, f64::from(count));
        assert_mean(
            &format!("{count} sprites of {opacity}"),
            &scene,
            1024,
            expected,
        );
    }
}

// The same for a shadow ray: the floor under sprites that face the camera above,
// the sun behind it.
#[test]
fn shadows_of_sprites_transmit_the_same() {
    let sun = r#""sun":{"azimuth_deg":0,"elevation_deg":90,"angular_radius_deg":0.1,"radiance":[1e6,1e6,1e6]}"#;
    let cloud = r#""clouds":[{"type":"sprites","formation":{"type":"radial","centre_m":[0,50,0],"radii_m":[1e-6,1e-6,1e-6],"direction":[1,0,0],"length_m":0},"count":20,
        "sprite_radius_m":[500,500],"opacity":[0.03,0.03],"albedo":[0,0,0],"softness":0.5}]"#;
    let ground = floor(r#"{"type":"lambert","albedo":[0.5,0.5,0.5]}"#);
    let eye = [3.0, 10.0, 0.0];
    let seen = |body: &str| {
        let scene = scene(body, eye, [0.0; 3], 4.0, 10, BuildOptions::default());
        mean_and_error(&scene, 16)
    };
    let (full, _) = seen(&format!("{ground},{sun}"));
    let (part, error) = seen(&format!("{ground},{sun},{cloud}"));
    let expected = full * libm::pow(0.97, 20.0);
    assert!(
        (part - expected).abs() < 5.0 * error + 1e-3 * expected,
        "{part}, expected {expected}"
    );
}

/// Build a scene with one cloud and one picture, `cloud.png`.
fn build(cloud: &str, picture: &[u8]) -> Result<(Stage, BuildReport), SceneError> {
    let json = format!(
        r#"{{"version":1,"name":"test","image":{{"width":16,"height":16}},
        "camera":{{"position_m":[0,0,9],"target_m":[0,0,0],"vertical_fov_deg":40}},
        "clouds":[{cloud}],{WHITE_SKY}}}"#
    );
    let description = parse(json.as_bytes()).expect("a valid scene");
    assert_eq!(
        description.files().len(),
        usize::from(json.contains("image\",\"file"))
    );
    let assets: Assets = [("cloud.png".to_owned(), Arc::from(picture))].into();
    Stage::build(&description, &assets, BuildOptions::default())
}

fn frame(stage: &Stage) -> Scene {
    let settings = RenderSettings {
        width: 16,
        height: 16,
        samples: 2,
        seed: 1,
        first_frame: 0,
        stop: shearwater_shared::stop::Stop::NONE,
        frames: 1,
    };
    stage.frame(&settings, 0).expect("a frame")
}

/// A PNG of grey bytes, two rows of two.
fn png(grey: [u8; 4]) -> Vec<u8> {
    let image = image::GrayImage::from_raw(2, 2, grey.to_vec()).expect("four bytes");
    let mut bytes = std::io::Cursor::new(Vec::new());
    image
        .write_to(&mut bytes, image::ImageFormat::Png)
        .expect("a PNG");
    bytes.into_inner()
}

fn by_picture(kind: &str, radius: &str) -> String {
    format!(
        r#"{{"type":"{kind}","formation":{{"type":"image","file":"cloud.png","centre_m":[0,0,0],"width_m":6,"depth_m":1}},
        "count":400,"{radius}":[0.4,0.8],"opacity":[0.5,0.9],"albedo":[0,0,0]}}"#
    )
}

// White above and to the right, black elsewhere: there, and only there, the sky is
// dimmed.
#[test]
fn a_picture_says_where_a_cloud_is() {
    for cloud in [
        by_picture("particles", "particle_radius_m"),
        by_picture("sprites", "sprite_radius_m"),
    ] {
        let (stage, report) = build(&cloud, &png([0, 255, 0, 0])).expect("builds");
        assert_eq!(report.particles + report.sprites, 400);
        let sums = crate::common::sums(&frame(&stage), 0..16);
        // Red of half A.
        let light = |x: usize, y: usize| sums.radiance[0][(y * 16 + x) * 3] as f64;
        let full = light(0, 15);
        assert!(full > 0.0);
        assert_eq!(light(3, 11), full, "below to the left");
        assert_eq!(light(3, 3), full, "above to the left");
        assert!(
            light(11, 4) < 0.05 * full,
            "above to the right: {}",
            light(11, 4)
        );
    }
}

#[test]
fn a_picture_that_is_none_is_an_error_with_its_place() {
    let cloud = by_picture("particles", "particle_radius_m");
    let fails = |picture: &[u8]| build(&cloud, picture).err().expect("refused").to_string();
    let black = fails(&png([0; 4]));
    assert!(
        black.contains("cloud.png: clouds[0].formation.file: black or transparent"),
        "{black}"
    );
    assert!(
        fails(b"GIF89a").contains("cloud.png"),
        "{}",
        fails(b"GIF89a")
    );
}

// An opaque disc on the camera's path: at each frame the camera sees it face on,
// so it covers what a circle of its apparent size covers.
#[test]
fn sprites_face_the_camera_at_each_frame() {
    let json = format!(
        r#"{{"version":1,"name":"test","image":{{"width":16,"height":16}},"animation":{{"fps":1,"frames":3}},
        "camera":{{"position_m":[0,0,9],"target_m":[0,0,0],"vertical_fov_deg":40,"path":[{{"time_s":0}},
        {{"time_s":1,"offset_m":[9,0,-9]}},{{"time_s":2,"offset_m":[5.4,7.2,-9]}}]}},
        "clouds":[{{"type":"sprites","formation":{{"type":"radial","centre_m":[0,0,0],"radii_m":[1e-6,1e-6,1e-6],"direction":[1,0,0],"length_m":0}},
        "count":1,"sprite_radius_m":[2,2],"opacity":[1,1],"softness":0.01,"albedo":[0,0,0]}}],{WHITE_SKY}}}"#
    );
    let description = parse(json.as_bytes()).expect("a valid scene");
    let (stage, _) =
        Stage::build(&description, &Assets::new(), BuildOptions::default()).expect("builds");
    // Half the picture's height is 9 tan 20 degrees where the disc stands.
    let half = 9.0 * libm::tan(20.0_f64.to_radians());
    let disc = std::f64::consts::PI * 4.0 / (4.0 * half * half);
    let expected = 1.0 - disc * (1.0 - 2.0 / 3.0 * 0.01);
    for number in 0..3 {
        let settings = RenderSettings {
            width: 16,
            height: 16,
            samples: 2,
            seed: 1,
            first_frame: 0,
            stop: shearwater_shared::stop::Stop::NONE,
            frames: 3,
        };
        let scene = stage.frame(&settings, number).expect("a frame");
        assert_mean(&format!("frame {number}"), &scene, 512, expected);
    }
}

// Under the water there is nothing to be seen: such parts are left out.
#[test]
fn parts_under_the_water_are_left_out() {
    for (kind, radius) in [
        ("particles", "particle_radius_m"),
        ("sprites", "sprite_radius_m"),
    ] {
        let cloud = |y: f64| {
            format!(
                r#"{{"type":"{kind}","formation":{{"type":"radial","centre_m":[0,{y},0],"radii_m":[0.1,0.1,0.1],"direction":[1,0,0],"length_m":0}},
                "count":50,"{radius}":[1,1],"opacity":[0.5,0.5]}}"#
            )
        };
        let json = format!(
            r#"{{"version":1,"name":"test","image":{{"width":16,"height":16}},
            "camera":{{"position_m":[0,5,9],"target_m":[0,0,0],"vertical_fov_deg":40}},
            "water":{{"type":"tessendorf","tile_m":10,"wind_speed_mps":3,"grid":16,"amplitude":0}},
            "clouds":[{},{}],{WHITE_SKY}}}"#,
            cloud(-1.2),
            cloud(-0.8)
        );
        let description = parse(json.as_bytes()).expect("a valid scene");
        let (_, report) =
            Stage::build(&description, &Assets::new(), BuildOptions::default()).expect("builds");
        assert_eq!(report.particles + report.sprites, 50, "{kind}");
    }
}
