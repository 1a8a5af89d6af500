//! Every wrong scene has an error that names the place, the value and what was
//! expected; no input panics.

use super::{parse, schema_json};
use crate::scene::test_scene::{fails, full, with};
use crate::scene::{Material, Sky};
use proptest::prelude::*;
use serde_json::{Value, json};

#[test]
fn the_full_scene_is_read() {
    let scene = parse(full().to_string().as_bytes()).unwrap();
    assert_eq!(scene.instances.len(), 2);
    assert!(matches!(&scene.materials["livery"], Material::Ggx(m) if m.roughness == 0.3));
    assert!(matches!(&scene.sky, Some(Sky::Map(m)) if m.file == "sky.exr"));
    let files: Vec<_> = scene.files().into_iter().collect();
    assert_eq!(
        files,
        [
            "cloud.vol",
            "clouds/cumulus.png",
            "models/plane.obj",
            "sky.exr",
            "tex/clay.png",
            "tex/orm.png"
        ]
    );
    // What is written is what is read.
    let again = serde_json::to_string(&scene).unwrap();
    assert_eq!(parse(again.as_bytes()).unwrap(), scene);
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
