//! Clouds, all together and as volumes.

use crate::scene::test_scene::{fails, full, with};
use serde_json::json;

#[test]
fn all_clouds_count_together() {
    let mut scene = full();
    let mut cloud = scene["clouds"][0].clone();
    cloud["count"] = json!(3_000_000);
    scene["clouds"] = json!([cloud, cloud]);
    fails(
        &scene.to_string(),
        "clouds[1].count",
        "6000000 particles and sprites in all clouds",
    );
}

#[test]
fn volumes_keep_their_ranges() {
    for (field, value, path, message) in [
        (
            "shape/centre_m/1",
            json!(2e9),
            "shape.centre_m[1]",
            "1000000000 m",
        ),
        ("shape/radii_m/0", json!(0), "shape.radii_m[0]", "m"),
        ("shape/edge", json!(1.5), "shape.edge", "0 to 1"),
        (
            "shape/resolution",
            json!(257),
            "shape.resolution",
            "4 to 256",
        ),
        ("shape/noise/scale_m", json!(0), "shape.noise.scale_m", "m"),
        (
            "shape/noise/amplitude",
            json!(2),
            "shape.noise.amplitude",
            "0 to 1",
        ),
        (
            "shape/noise/coverage",
            json!(-1),
            "shape.noise.coverage",
            "0 to 1",
        ),
        (
            "shape/noise/octaves",
            json!(11),
            "shape.noise.octaves",
            "1 to 10",
        ),
        (
            "shape/noise/lacunarity",
            json!(5),
            "shape.noise.lacunarity",
            "1 to 4",
        ),
        ("shape/noise/gain", json!(1.1), "shape.noise.gain", "0 to 1"),
        (
            "shape/noise/colour",
            json!(1),
            "shape.noise.colour",
            "unknown field",
        ),
        (
            "shape/type",
            json!("ball"),
            "shape.type",
            "`ball`: expected `ellipsoid` or `grid`",
        ),
        (
            "sigma_t_per_m",
            json!(-1),
            "sigma_t_per_m",
            "0 to 1000000 per m",
        ),
        (
            "sigma_t_per_m",
            json!(2e4),
            "sigma_t_per_m",
            "120000 mean free paths thick",
        ),
        ("albedo/2", json!(1.01), "albedo[2]", "0 to 1"),
        ("g", json!(1), "g", "-0.99 to 0.99"),
        (
            "method/type",
            json!("walk"),
            "method.type",
            "`tracking` or `march`",
        ),
        ("method/step_m", json!(0), "method.step_m", "m"),
        (
            "method/step_m",
            json!(1e-5),
            "method.step_m",
            "100000 steps",
        ),
        (
            "method",
            json!({"type": "tracking", "step_m": 1}),
            "method.step_m",
            "unknown field",
        ),
    ] {
        let text = with(&format!("/clouds/2/{field}"), value);
        fails(&text, &format!("clouds[2].{path}"), message);
    }
    for (field, value, path, message) in [
        (
            "file",
            json!("/etc/x.vol"),
            "file",
            "relative to scene.json",
        ),
        ("size_m/2", json!(0), "size_m[2]", "m"),
        ("centre_m/0", json!(-2e9), "centre_m[0]", "m"),
        ("rotate_y_deg", json!(2e6), "rotate_y_deg", "degrees"),
    ] {
        let text = with(&format!("/clouds/3/shape/{field}"), value);
        fails(&text, &format!("clouds[3].shape.{path}"), message);
    }
    let mut scene = full();
    let cloud = scene["clouds"][2].clone();
    scene["clouds"] = json!(vec![cloud; 65]);
    fails(&scene.to_string(), "clouds[64]", "65 volumes");
}
