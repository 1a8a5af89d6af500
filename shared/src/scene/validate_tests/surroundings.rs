//! Values of sky, sun, water, clouds and post.

use crate::scene::test_scene::{fails, full, with};
use serde_json::json;

#[test]
fn values_out_of_range_are_named() {
    for (pointer, value, path, message) in [
        (
            "/sky/intensity",
            json!(-1),
            "sky.intensity",
            "-1: expected 0 to",
        ),
        (
            "/sky",
            json!({"type": "constant", "radiance": [0, 0, 1e9]}),
            "sky.radiance[2]",
            "0 to 67108864",
        ),
        (
            "/sky",
            json!({"type": "dome", "file": "s.exr", "centre_m": [0, 2e9, 0], "radius_m": 5}),
            "sky.centre_m[1]",
            "-1000000000 to 1000000000 m",
        ),
        (
            "/sky",
            json!({"type": "dome", "file": "s.exr", "centre_m": [0, 0, 0], "radius_m": 0}),
            "sky.radius_m",
            "0.001 to 1000000000 m",
        ),
        (
            "/sky",
            json!({"type": "dome", "file": "../..", "centre_m": [0, 0, 0], "radius_m": 1}),
            "sky.file",
            "the name of a file",
        ),
        (
            "/sky",
            json!({"type": "atmosphere", "turbidity": 0.5}),
            "sky.turbidity",
            "0.5: expected 1 to 10",
        ),
        (
            "/sky",
            json!({"type": "atmosphere", "ground_albedo": 2}),
            "sky.ground_albedo",
            "2: expected 0 to 1",
        ),
        (
            "/sky",
            json!({"type": "atmosphere", "intensity": -1}),
            "sky.intensity",
            "-1: expected 0 to",
        ),
        (
            "/sun/radiance",
            json!(null),
            "sun.radiance",
            "missing: expected linear RGB",
        ),
        (
            "/sun/elevation_deg",
            json!(91),
            "sun.elevation_deg",
            "-90 to 90 degrees",
        ),
        (
            "/sun/angular_radius_deg",
            json!(0),
            "sun.angular_radius_deg",
            "more than 0, at most 45 degrees",
        ),
        (
            "/water/grid",
            json!(100),
            "water.grid",
            "100: expected a power of two, 16 to 2048",
        ),
        ("/water/grid", json!(4096), "water.grid", "power of two"),
        ("/water/tile_m", json!(0), "water.tile_m", "m"),
        (
            "/water/wind_speed_mps",
            json!(0),
            "water.wind_speed_mps",
            "0.1 to 200 m/s",
        ),
        ("/water/cutoff_m", json!(-1), "water.cutoff_m", "0 to"),
        ("/water/ior", json!(0.5), "water.ior", "1 to 4"),
        (
            "/water/body_color",
            json!([2, 0, 0]),
            "water.body_color[0]",
            "0 to 1",
        ),
        (
            "/water/loop_s",
            json!(0),
            "water.loop_s",
            "0.001 to 1000000 s",
        ),
        ("/water/time_s", json!(1e7), "water.time_s", "1000000 s"),
        (
            "/water/shutter_fields",
            json!(0),
            "water.shutter_fields",
            "0: expected 1 to 4",
        ),
        (
            "/water/shutter_fields",
            json!(5),
            "water.shutter_fields",
            "1 to 4",
        ),
        (
            "/water/whitecaps/choppiness",
            json!(-1),
            "water.whitecaps.choppiness",
            "-1: expected 0 to 100",
        ),
        (
            "/water/whitecaps/threshold",
            json!(101),
            "water.whitecaps.threshold",
            "-100 to 100",
        ),
        (
            "/water/whitecaps/softness",
            json!(0),
            "water.whitecaps.softness",
            "0: expected 0.001 to 100",
        ),
        (
            "/water/whitecaps/albedo",
            json!([0, 2, 0]),
            "water.whitecaps.albedo[1]",
            "0 to 1",
        ),
        (
            "/water/whitecaps/roughness",
            json!(2),
            "water.whitecaps.roughness",
            "0 to 1",
        ),
        (
            "/clouds/0/count",
            json!(0),
            "clouds[0].count",
            "1 to 5000000",
        ),
        (
            "/clouds/0/formation/radii_m/1",
            json!(0),
            "clouds[0].formation.radii_m[1]",
            "m",
        ),
        (
            "/clouds/0/formation/direction",
            json!([0, 0, 0]),
            "clouds[0].formation.direction",
            "not zero",
        ),
        (
            "/clouds/0/particle_radius_m",
            json!([2, 1]),
            "clouds[0].particle_radius_m",
            "smaller value first",
        ),
        (
            "/clouds/0/opacity/1",
            json!(1.1),
            "clouds[0].opacity[1]",
            "0 to 1",
        ),
        (
            "/clouds/0/albedo",
            json!([2, 0, 0]),
            "clouds[0].albedo[0]",
            "0 to 1",
        ),
        (
            "/clouds/1/count",
            json!(0),
            "clouds[1].count",
            "0: expected 1 to 5000000",
        ),
        (
            "/clouds/1/sprite_radius_m/0",
            json!(0),
            "clouds[1].sprite_radius_m[0]",
            "0.0001 to 1000000000 m",
        ),
        (
            "/clouds/1/opacity",
            json!([0.5, 0.4]),
            "clouds[1].opacity",
            "smaller value first",
        ),
        (
            "/clouds/1/softness",
            json!(0.009),
            "clouds[1].softness",
            "0.01 to 1",
        ),
        (
            "/clouds/1/g",
            json!(1),
            "clouds[1].g",
            "1: expected -0.99 to 0.99",
        ),
        (
            "/clouds/1/albedo",
            json!([-0.1, 0, 0]),
            "clouds[1].albedo[0]",
            "0 to 1",
        ),
        (
            "/clouds/1/formation/file",
            json!("/etc/cloud.png"),
            "clouds[1].formation.file",
            "relative to scene.json",
        ),
        (
            "/clouds/1/formation/centre_m/1",
            json!(1e10),
            "clouds[1].formation.centre_m[1]",
            "m",
        ),
        (
            "/clouds/1/formation/width_m",
            json!(0),
            "clouds[1].formation.width_m",
            "0: expected",
        ),
        (
            "/clouds/1/formation/height_m",
            json!(-1),
            "clouds[1].formation.height_m",
            "-1: expected",
        ),
        (
            "/clouds/1/formation/depth_m",
            json!(-1),
            "clouds[1].formation.depth_m",
            "-1: expected 0 to 1000000000 m",
        ),
        (
            "/clouds/1/formation/rotate_deg/2",
            json!(1e7),
            "clouds[1].formation.rotate_deg[2]",
            "degrees",
        ),
        (
            "/clouds/1/formation/type",
            json!("cube"),
            "clouds[1].formation.type",
            "`radial` or `image`",
        ),
        (
            "/post/exposure_ev",
            json!(33),
            "post.exposure_ev",
            "-32 to 32 stops",
        ),
        (
            "/post/bloom/strength",
            json!(-1),
            "post.bloom.strength",
            "0 to 100",
        ),
        (
            "/post/bloom/radius",
            json!(2),
            "post.bloom.radius",
            "of the picture's height",
        ),
        (
            "/post/bloom/passes",
            json!(0),
            "post.bloom.passes",
            "1 to 3",
        ),
    ] {
        fails(&with(pointer, value), path, message);
    }
}

#[test]
fn an_atmosphere_has_its_own_sun_but_needs_its_place() {
    let mut scene = full();
    scene["sky"] = json!({"type": "atmosphere"});
    scene["sun"] = json!({"azimuth_deg": 0, "elevation_deg": -3});
    assert!(crate::scene::parse(scene.to_string().as_bytes()).is_ok());
    scene["sun"] = json!(null);
    fails(&scene.to_string(), "sky", "expected `sun`");
}
