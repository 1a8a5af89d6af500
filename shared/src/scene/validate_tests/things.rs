//! Values of picture, camera, materials, meshes and instances.

use crate::scene::test_scene::{fails, with};
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
            "/job/error",
            json!(0),
            "job.error",
            "0: expected a relative mean squared error, 1e-9 to 10",
        ),
        (
            "/job/seconds",
            json!(0),
            "job.seconds",
            "0: expected 1 to 31622400",
        ),
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
            "/materials/chrome/metalness",
            json!(1.5),
            "materials.chrome.metalness",
            "1.5: expected 0 to 1",
        ),
        (
            "/materials/chrome/conductor/n/1",
            json!(-1),
            "materials.chrome.conductor.n[1]",
            "-1: expected 0 to 20",
        ),
        (
            "/materials/chrome/conductor/k/2",
            json!(21),
            "materials.chrome.conductor.k[2]",
            "21: expected 0 to 20",
        ),
        (
            "/materials/chrome/coat/weight",
            json!(1.5),
            "materials.chrome.coat.weight",
            "1.5: expected 0 to 1",
        ),
        (
            "/materials/chrome/coat/roughness",
            json!(-1),
            "materials.chrome.coat.roughness",
            "-1: expected 0 to 1",
        ),
        (
            "/materials/chrome/coat/ior",
            json!(0.5),
            "materials.chrome.coat.ior",
            "0.5: expected 1 to 3",
        ),
        (
            "/materials/chrome/f82",
            json!([1, 1, 1]),
            "materials.chrome.f82",
            "expected one of them",
        ),
        (
            "/materials/chrome/sampling",
            json!("lobe"),
            "materials.chrome.sampling",
            "expected `mixture`, or `model: report`",
        ),
        (
            "/materials/chrome/roughness_texture/file",
            json!("/x.png"),
            "materials.chrome.roughness_texture.file",
            "relative to scene.json",
        ),
        (
            "/materials/chrome/metalness_texture/file",
            json!(""),
            "materials.chrome.metalness_texture.file",
            "name of a file",
        ),
        (
            "/materials/tinted/f82/2",
            json!(1.5),
            "materials.tinted.f82[2]",
            "1.5: expected 0 to 1",
        ),
        (
            "/materials/livery/f82",
            json!([1, 1, 1]),
            "materials.livery.f82",
            "expected `model: corrected`",
        ),
        (
            "/materials/livery/coat",
            json!({}),
            "materials.livery.coat",
            "expected `model: corrected`",
        ),
        (
            "/materials/livery/conductor",
            json!({"n": [1, 1, 1], "k": [1, 1, 1]}),
            "materials.livery.conductor",
            "expected `model: corrected`",
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
            "known: `chrome`, `clay`, `gloss`, `livery`, `tinted`",
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
    ] {
        fails(&with(pointer, value), path, message);
    }
}
