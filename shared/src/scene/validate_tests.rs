//! Every value out of its range is refused at its place.

use crate::scene::test_scene::{fails, full, with};
use serde_json::json;

#[test]
fn values_out_of_range_are_named() {
    for (pointer, value, path, message) in [
        (
            "/version",
            json!(2),
            "version",
            "2: this build reads version 1",
        ),
        ("/name", json!(""), "name", "1 to 200"),
        ("/name", json!("../x"), "name", "without `/`"),
        (
            "/image/width",
            json!(0),
            "image.width",
            "0: expected 1 to 16384",
        ),
        ("/image/height", json!(16385), "image.height", "1 to 16384"),
        (
            "/job/samples",
            json!(15),
            "job.samples",
            "15: expected an even number",
        ),
        ("/job/samples", json!(0), "job.samples", "2 to 16777216"),
        (
            "/camera/position_m/1",
            json!(1e10),
            "camera.position_m[1]",
            "-1000000000 to 1000000000 m",
        ),
        (
            "/camera/target_m",
            json!([0, 2, 10]),
            "camera.target_m",
            "another point",
        ),
        ("/camera/up", json!([0, 0, 0]), "camera.up", "not zero"),
        (
            "/camera/up",
            json!([0, -1, -10]),
            "camera.up",
            "not along the view",
        ),
        (
            "/camera/vertical_fov_deg",
            json!(0),
            "camera.vertical_fov_deg",
            "more than 0, less than 179 degrees",
        ),
        (
            "/camera/vertical_fov_deg",
            json!(179),
            "camera.vertical_fov_deg",
            "179: expected",
        ),
        (
            "/camera/shutter_s",
            json!(-1),
            "camera.shutter_s",
            "-1: expected 0 to 3600 s",
        ),
        (
            "/camera/lens_radius_m",
            json!(-1),
            "camera.lens_radius_m",
            "m",
        ),
        (
            "/camera/focus_distance_m",
            json!(0),
            "camera.focus_distance_m",
            "m",
        ),
        (
            "/materials/clay/albedo/2",
            json!(1.5),
            "materials.clay.albedo[2]",
            "1.5: expected 0 to 1",
        ),
        (
            "/materials/clay/albedo/2",
            json!(1e39),
            "materials.clay.albedo[2]",
            "inf: expected 0 to 1",
        ),
        (
            "/materials/clay/albedo_texture",
            json!("/x.png"),
            "materials.clay.albedo_texture",
            "relative to scene.json",
        ),
        (
            "/materials/clay/albedo_texture",
            json!("a/../x.png"),
            "materials.clay.albedo_texture",
            "expected `x.png`",
        ),
        (
            "/materials/clay/albedo_texture",
            json!("a\\x.png"),
            "materials.clay.albedo_texture",
            "expected `a/x.png`",
        ),
        (
            "/materials/gloss/ks",
            json!([0, 0.6, 0]),
            "materials.gloss",
            "in green: expected at most 1",
        ),
        (
            "/materials/gloss/exponent",
            json!(1e8),
            "materials.gloss.exponent",
            "0 to 10000000",
        ),
        (
            "/materials/livery/roughness",
            json!(-0.1),
            "materials.livery.roughness",
            "-0.1",
        ),
        (
            "/materials/livery/metalness",
            json!(2),
            "materials.livery.metalness",
            "2: expected 0 to 1",
        ),
        (
            "/materials/livery/specular_f0",
            json!(2),
            "materials.livery.specular_f0",
            "0 to 1",
        ),
        (
            "/meshes/plane/file",
            json!(""),
            "meshes.plane.file",
            "name of a file",
        ),
        (
            "/meshes/plane/file",
            json!(".."),
            "meshes.plane.file",
            "name of a file",
        ),
        (
            "/meshes/plane/crease_angle_deg",
            json!(181),
            "meshes.plane.crease_angle_deg",
            "0 to 180 degrees",
        ),
        (
            "/meshes/plane/materials/Body 1",
            json!("nix"),
            "meshes.plane.materials.Body 1",
            "known: `clay`, `gloss`, `livery`",
        ),
        (
            "/instances/1/mesh",
            json!("car"),
            "instances[1].mesh",
            "`car`: no mesh of that name; known: `plane`",
        ),
        (
            "/instances/1/material",
            json!("mud"),
            "instances[1].material",
            "no material of that name",
        ),
        (
            "/instances/1/scale/2",
            json!(0),
            "instances[1].scale[2]",
            "0: expected 1e-6 to 1e6",
        ),
        (
            "/instances/1/rotate_deg/0",
            json!(1e7),
            "instances[1].rotate_deg[0]",
            "degrees",
        ),
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
fn all_clouds_count_together() {
    let mut scene = full();
    let mut cloud = scene["clouds"][0].clone();
    cloud["count"] = json!(3_000_000);
    scene["clouds"] = json!([cloud, cloud]);
    fails(
        &scene.to_string(),
        "clouds[1].count",
        "6000000 particles in all clouds",
    );
}
