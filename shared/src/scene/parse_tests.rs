//! Every wrong scene has an error that names the place, the value and what was
//! expected; no input panics.

use super::{parse, schema_json};
use crate::scene::{Material, Sky};
use proptest::prelude::*;
use serde_json::{Value, json};

/// A scene that uses every part of the format.
fn full() -> Value {
    json!({
        "version": 1, "name": "all of it",
        "image": {"width": 64, "height": 32}, "job": {"samples": 16},
        "camera": {"position_m": [0, 2, 10], "target_m": [0, 1, 0], "up": [0, 1, 0],
            "vertical_fov_deg": 40, "shutter_s": 0.5, "lens_radius_m": 0.01, "focus_distance_m": 9},
        "materials": {
            "clay": {"type": "lambert", "albedo": [0.5, 0.5, 0.5], "albedo_texture": "tex/clay.png"},
            "gloss": {"type": "phong", "kd": [0.9, 0.5, 0.5], "ks": [0.1, 0.1, 0.1], "exponent": 50},
            "livery": {"roughness": 0.3, "type": "ggx", "metalness": 0.5, "model": "report"}
        },
        "meshes": {"plane": {"file": "models/plane.obj", "normals": "flat", "crease_angle_deg": 30,
            "materials": {"Body 1": "livery"}}},
        "instances": [{"mesh": "plane"}, {"mesh": "plane", "translate_m": [1, 2, 3],
            "rotate_deg": [0, 90, 0], "scale": [1, -1, 2], "material": "clay"}],
        "sky": {"type": "map", "file": "sky.exr", "rotation_deg": 10, "intensity": 2},
        "sun": {"azimuth_deg": 10, "elevation_deg": 3, "radiance": [9, 8, 7]},
        "water": {"type": "tessendorf", "tile_m": 50, "wind_speed_mps": 8},
        "clouds": [{"centre_m": [0, 0, 0], "radii_m": [1, 1, 1], "direction": [0, 0, 1],
            "length_m": 5, "count": 10, "particle_radius_m": [0.1, 0.2], "opacity": [0.1, 0.9]}],
        "post": {"exposure_ev": 1, "bloom": {"strength": 0.2, "radius": 0.05}, "view": "standard"}
    })
}

/// Set a place of [`full`] (a JSON pointer); `null` as value removes it.
fn with(pointer: &str, value: Value) -> String {
    let mut scene = full();
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    match scene.pointer_mut(parent).unwrap() {
        Value::Object(map) if value.is_null() => {
            map.remove(key);
        }
        Value::Object(map) => {
            map.insert(key.to_owned(), value);
        }
        Value::Array(list) => list[key.parse::<usize>().unwrap()] = value,
        _ => panic!("{pointer}"),
    }
    scene.to_string()
}

fn fails(text: &str, path: &str, message: &str) {
    let error = parse(text.as_bytes()).unwrap_err();
    assert_eq!(
        (error.file.as_str(), error.path.as_str()),
        ("scene.json", path),
        "{error}"
    );
    assert!(
        error.message.contains(message),
        "{error} should say {message}"
    );
}

#[test]
fn the_full_scene_is_read() {
    let scene = parse(full().to_string().as_bytes()).unwrap();
    assert_eq!(scene.instances.len(), 2);
    assert!(matches!(&scene.materials["livery"], Material::Ggx(m) if m.roughness == 0.3));
    assert!(matches!(&scene.sky, Some(Sky::Map(m)) if m.file == "sky.exr"));
    let files: Vec<_> = scene.files().into_iter().collect();
    assert_eq!(files, ["models/plane.obj", "sky.exr", "tex/clay.png"]);
    // What is written is what is read.
    let again = serde_json::to_string(&scene).unwrap();
    assert_eq!(parse(again.as_bytes()).unwrap(), scene);
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
        ("/clouds/0/radii_m/1", json!(0), "clouds[0].radii_m[1]", "m"),
        (
            "/clouds/0/direction",
            json!([0, 0, 0]),
            "clouds[0].direction",
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
            "1 to 16",
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

#[test]
fn fields_and_types_are_named_at_any_depth() {
    for (pointer, value, path, message) in [
        (
            "/imag",
            json!(1),
            "imag",
            "unknown field `imag`, expected one of `version`",
        ),
        (
            "/camera/fov",
            json!(1),
            "camera.fov",
            "unknown field `fov`, expected one of",
        ),
        (
            "/materials/livery/rough",
            json!(1),
            "materials.livery.rough",
            "expected one of `base_color`",
        ),
        (
            "/materials/livery/roughness",
            json!("x"),
            "materials.livery.roughness",
            "expected f32",
        ),
        (
            "/materials/livery/model",
            json!("x"),
            "materials.livery.model",
            "expected `corrected` or `report`",
        ),
        (
            "/materials/livery/type",
            json!("ggg"),
            "materials.livery.type",
            "`ggg`: expected `lambert` or `phong` or `ggx`",
        ),
        (
            "/materials/livery/type",
            json!(7),
            "materials.livery.type",
            "expected a string",
        ),
        (
            "/materials/livery/type",
            json!(null),
            "materials.livery",
            "missing field `type`",
        ),
        (
            "/materials/gloss/ks",
            json!(null),
            "materials.gloss",
            "missing field `ks`",
        ),
        (
            "/materials/clay/albedo",
            json!([1, 1]),
            "materials.clay.albedo",
            "array of length 3",
        ),
        ("/sky/rotate", json!(1), "sky.rotate", "unknown field"),
        ("/water/wind", json!(1), "water.wind", "unknown field"),
        (
            "/clouds/0/radius",
            json!(1),
            "clouds[0].radius",
            "unknown field",
        ),
        (
            "/post/bloom/size",
            json!(1),
            "post.bloom.size",
            "unknown field",
        ),
        (
            "/instances/0/mesh",
            json!(null),
            "instances[0]",
            "missing field `mesh`",
        ),
        ("/camera", json!(null), ".", "missing field `camera`"),
    ] {
        fails(&with(pointer, value), path, message);
    }
}

#[test]
fn equal_keys_are_refused() {
    let twice = |what: &str| {
        full()
            .to_string()
            .replacen(what, &format!("{what}{what}"), 1)
    };
    let error = |text: &str| parse(text.as_bytes()).unwrap_err().to_string();
    let text = twice(r#""metalness":0.5,"#);
    assert!(error(&text).contains("materials.livery: `metalness` stands here twice"));
    let text = twice(r#""shutter_s":0.5,"#);
    assert!(
        error(&text).contains("duplicate field `shutter_s`"),
        "{}",
        error(&text)
    );
    let text = twice(r#""plane":{"crease_angle_deg":30,"file":"models/plane.obj","materials":{"Body 1":"livery"},"normals":"flat"}"#)
        .replace(r#"}"plane""#, r#"},"plane""#);
    assert!(
        error(&text).contains("meshes: `plane` stands here twice"),
        "{}",
        error(&text)
    );
}

#[test]
fn hostile_texts_are_errors() {
    for text in [
        "",
        "null",
        "[]",
        "{",
        "\u{feff}{}",
        "{}{}",
        "1e999",
        "\"\\ud800\"",
    ] {
        assert!(parse(text.as_bytes()).is_err(), "{text}");
    }
    assert!(parse(b"\xff\xfe{}").is_err());
    let deep = format!("{{\"sky\":{{\"a\":{}", "[".repeat(100_000));
    assert!(
        parse(deep.as_bytes())
            .unwrap_err()
            .message
            .contains("recursion limit")
    );
    let huge = with("/camera/vertical_fov_deg", json!("F")).replace("\"F\"", "1e999");
    fails(&huge, "camera.vertical_fov_deg", "number out of range");
    let nan = with("/camera/vertical_fov_deg", json!("F")).replace("\"F\"", "NaN");
    assert!(parse(nan.as_bytes()).is_err());
    let more = format!("{} {{}}", full());
    fails(&more, ".", "trailing characters");
}

#[test]
fn the_committed_schema_is_the_types() {
    let committed = include_str!("../../../scenes/scene.schema.json");
    assert!(
        committed == schema_json(),
        "scenes/scene.schema.json is not what the types say: \
         run `shearwater schema > scenes/scene.schema.json`"
    );
}

#[test]
fn the_schema_refuses_unknown_fields_and_knows_the_tags() {
    let schema: Value = serde_json::from_str(&schema_json()).unwrap();
    let ggx = &schema["$defs"]["Material"]["oneOf"][2];
    assert_eq!(ggx["properties"]["type"]["const"], "ggx");
    assert_eq!(ggx["additionalProperties"], false);
    assert_eq!(ggx["properties"]["roughness"]["maximum"], 1.0);
    assert_eq!(schema["additionalProperties"], false);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, rng_seed: proptest::test_runner::RngSeed::Fixed(7), failure_persistence: None, ..ProptestConfig::default() })]

    /// Any bytes changed, removed or doubled in a scene: an answer, not a panic.
    #[test]
    fn broken_scenes_never_panic(edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0_u8..4), 1..6)) {
        let mut bytes = full().to_string().into_bytes();
        for (place, byte, kind) in edits {
            let i = place.index(bytes.len());
            match kind {
                0 => bytes[i] = byte,
                1 => { bytes.remove(i); }
                2 => bytes.insert(i, bytes[i]),
                _ => bytes[i] = b"0123456789-e.\"{}[],:"[usize::from(byte) % 20],
            }
        }
        if let Err(error) = parse(&bytes) {
            prop_assert!(!error.message.is_empty() && !error.path.is_empty());
        }
    }

    /// Any number anywhere: accepted scenes hold only finite numbers.
    #[test]
    fn any_number_is_answered(value in any::<f64>(), place in any::<prop::sample::Index>()) {
        let mut scene = full();
        let mut numbers = Vec::new();
        collect(&scene, String::new(), &mut numbers);
        let pointer = &numbers[place.index(numbers.len())];
        *scene.pointer_mut(pointer).unwrap() = json!(value);
        if let Ok(read) = parse(scene.to_string().as_bytes()) {
            // serde_json writes a number that is not finite as null.
            let written = serde_json::to_value(&read).unwrap();
            if let Some(number) = written.pointer(pointer) {
                prop_assert!(number.is_number(), "{pointer} = {value}");
            }
        }
    }
}

fn collect(value: &Value, pointer: String, numbers: &mut Vec<String>) {
    match value {
        Value::Number(_) => numbers.push(pointer),
        Value::Array(list) => {
            for (i, item) in list.iter().enumerate() {
                collect(item, format!("{pointer}/{i}"), numbers);
            }
        }
        Value::Object(map) => {
            for (key, item) in map {
                collect(item, format!("{pointer}/{key}"), numbers);
            }
        }
        _ => {}
    }
}
