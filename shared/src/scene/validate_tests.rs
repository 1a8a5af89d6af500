//! Every value out of its range is refused at its place.

use crate::scene::test_scene::{fails, full, with};
use serde_json::json;

#[test]
fn motion_out_of_range_is_named() {
    for (pointer, value, path, message) in [
        (
            "/animation/fps",
            json!(0),
            "animation.fps",
            "0: expected 0.1 to 1000 frames per second",
        ),
        (
            "/animation/frames",
            json!(0),
            "animation.frames",
            "0: expected 1 to 1000000",
        ),
        (
            "/animation/start_s",
            json!(1e7),
            "animation.start_s",
            "-1000000 to 1000000 s",
        ),
        (
            "/animation/fps",
            json!(24),
            "camera.shutter_s",
            "0.5: expected at most 0.041666666666666664 s, the time of one frame at 24 frames per second",
        ),
        (
            "/camera/velocity_mps/2",
            json!(1e6),
            "camera.velocity_mps[2]",
            "-100000 to 100000 m/s",
        ),
        (
            "/camera/path/0/offset_m/1",
            json!(1e10),
            "camera.path[0].offset_m[1]",
            "m",
        ),
        (
            "/camera/path/1/target_offset_m",
            json!([0, 1, 10]),
            "camera.path[1]",
            "the target is where the eye is",
        ),
        (
            "/camera/path/1/target_offset_m",
            json!([0, 9, 10]),
            "camera.path[1]",
            "the view is along `up`",
        ),
        (
            "/camera/path/1/time_s",
            json!(0),
            "camera.path[1].time_s",
            "0: expected a time after 0 s",
        ),
        (
            "/instances/0/velocity_mps/0",
            json!(-2e5),
            "instances[0].velocity_mps[0]",
            "m/s",
        ),
        (
            "/instances/0/name",
            json!(""),
            "instances[0].name",
            "1 to 200 bytes",
        ),
        (
            "/instances/1/name",
            json!("first"),
            "instances[1].name",
            "`first` is also the name of instances[0]",
        ),
        (
            "/instances/1/parent",
            json!("nobody"),
            "instances[1].parent",
            "`nobody`: no instance of that name; known: `first`, `second`",
        ),
        (
            "/instances/1/parent",
            json!("second"),
            "instances[1].parent",
            "expected no instance that is placed within this one",
        ),
        (
            "/instances/0/parent",
            json!("second"),
            "instances[0].parent",
            "expected no instance that is placed within this one",
        ),
        (
            "/instances/1/spin/axis",
            json!([0, 0, 0]),
            "instances[1].spin.axis",
            "a vector that is not zero",
        ),
        (
            "/instances/1/spin/rpm",
            json!(1e7),
            "instances[1].spin.rpm",
            "10000000: expected -1000000 to 1000000 turns per minute",
        ),
        (
            "/instances/1/spin/pivot_m/0",
            json!(1e10),
            "instances[1].spin.pivot_m[0]",
            "m",
        ),
        (
            "/instances/1/path/1/time_s",
            json!(-1),
            "instances[1].path[1].time_s",
            "-1: expected a time after 0 s",
        ),
        (
            "/instances/1/path/1/turn_deg/1",
            json!(1e7),
            "instances[1].path[1].turn_deg[1]",
            "degrees",
        ),
        (
            "/instances/1/path/0/time_s",
            json!(-1e7),
            "instances[1].path[0].time_s",
            "-1000000 to 1000000 s",
        ),
    ] {
        fails(&with(pointer, value), path, message);
    }
}

#[test]
fn long_chains_and_circles_of_parents_are_refused() {
    let chain = |count: usize| {
        let mut scene = full();
        let link = |i: usize| {
            json!({"mesh": "plane", "name": i.to_string(),
                "parent": if i == 0 { None } else { Some((i - 1).to_string()) }})
        };
        scene["instances"] = (0..count).map(link).collect();
        scene
    };
    let most = crate::limits::INSTANCE_DEPTH_MAX;
    assert!(crate::scene::parse(chain(most).to_string().as_bytes()).is_ok());
    let path = format!("instances[{most}].parent");
    fails(&chain(most + 1).to_string(), &path, "expected at most 8");
    // A circle that the first instance only leads into.
    let mut circle = chain(3);
    circle["instances"][0]["parent"] = json!("1");
    circle["instances"][1]["parent"] = json!("2");
    circle["instances"][2]["parent"] = json!("1");
    fails(&circle.to_string(), "instances[0].parent", "or a circle");
}

#[test]
fn frames_follow_each_other_from_the_start() {
    let mut scene = crate::scene::parse(full().to_string().as_bytes()).unwrap();
    assert_eq!([0, 1, 4].map(|f| scene.frame_time_s(f)), [1.0, 1.5, 3.0]);
    scene.animation = None;
    assert_eq!(scene.frame_time_s(7), 0.0);
}

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
