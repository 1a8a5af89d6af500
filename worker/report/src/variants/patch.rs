//! Changes of a scene.

use super::Variant;
use serde_json::Value;

/// A change that cannot be made.
#[derive(Debug, thiserror::Error)]
#[error("{at}: {message}")]
pub struct PatchError {
    /// JSON path within the variant.
    pub at: String,
    /// What was found and what was expected.
    pub message: String,
}

/// The bytes of scene.json as `variant` wants them: as they are, if it changes nothing.
///
/// # Errors
/// [`PatchError`]: the scene is no JSON, a pointer reaches nothing.
pub fn patched(scene: &[u8], variant: &Variant) -> Result<Vec<u8>, PatchError> {
    if variant.scene.is_none() && variant.set.is_empty() {
        return Ok(scene.to_vec());
    }
    let fail = |at: &str, message: String| PatchError {
        at: at.to_owned(),
        message,
    };
    let mut value: Value =
        serde_json::from_slice(scene).map_err(|e| fail("scene.json", e.to_string()))?;
    if let Some(patch) = &variant.scene {
        if !patch.is_object() {
            return Err(fail("scene", "expected an object (RFC 7396)".to_owned()));
        }
        merge(&mut value, patch);
    }
    for (pointer, new) in &variant.set {
        let at = format!("set[\"{pointer}\"]");
        let Some(path) = pointer.strip_prefix('/') else {
            return Err(fail(
                &at,
                "expected a pointer that begins with `/`".to_owned(),
            ));
        };
        let parts: Vec<String> = path
            .split('/')
            .map(|part| part.replace("~1", "/").replace("~0", "~"))
            .collect();
        if set(&mut value, &parts, new) == 0 {
            return Err(fail(&at, "nothing of the scene is there".to_owned()));
        }
    }
    serde_json::to_vec(&value).map_err(|e| fail("scene", e.to_string()))
}

/// RFC 7396, section 2: objects are merged, null removes, all else replaces.
fn merge(target: &mut Value, patch: &Value) {
    let Value::Object(patch) = patch else {
        target.clone_from(patch);
        return;
    };
    if !target.is_object() {
        *target = Value::Object(serde_json::Map::new());
    }
    let Some(fields) = target.as_object_mut() else {
        return;
    };
    for (name, change) in patch {
        if change.is_null() {
            fields.remove(name);
        } else {
            merge(fields.entry(name.clone()).or_insert(Value::Null), change);
        }
    }
}

/// Set what `path` reaches; how many places that were. The last field of an object need
/// not be there yet.
fn set(target: &mut Value, path: &[String], new: &Value) -> usize {
    let Some((part, rest)) = path.split_first() else {
        target.clone_from(new);
        return 1;
    };
    match target {
        Value::Array(list) if part == "*" => list.iter_mut().map(|e| set(e, rest, new)).sum(),
        Value::Object(fields) if part == "*" => {
            fields.values_mut().map(|e| set(e, rest, new)).sum()
        }
        Value::Array(list) => part
            .parse::<usize>()
            .ok()
            .and_then(|index| list.get_mut(index))
            .map_or(0, |element| set(element, rest, new)),
        Value::Object(fields) if rest.is_empty() => {
            fields.insert(part.clone(), new.clone());
            1
        }
        Value::Object(fields) => fields
            .get_mut(part)
            .map_or(0, |field| set(field, rest, new)),
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    // The examples of RFC 7396, appendix A.
    #[test]
    fn merges_as_the_standard_says() {
        let cases = [
            (json!({"a": "b"}), json!({"a": "c"}), json!({"a": "c"})),
            (
                json!({"a": "b"}),
                json!({"b": "c"}),
                json!({"a": "b", "b": "c"}),
            ),
            (json!({"a": "b"}), json!({"a": null}), json!({})),
            (json!({"a": ["b"]}), json!({"a": "c"}), json!({"a": "c"})),
            (json!({"a": "c"}), json!({"a": ["b"]}), json!({"a": ["b"]})),
            (
                json!({"a": {"b": "c"}}),
                json!({"a": {"b": "d", "c": null}}),
                json!({"a": {"b": "d"}}),
            ),
            (json!({"a": "foo"}), json!("bar"), json!("bar")),
            (
                json!([1, 2]),
                json!({"a": "b", "c": null}),
                json!({"a": "b"}),
            ),
            (
                json!({}),
                json!({"a": {"bb": {"ccc": null}}}),
                json!({"a": {"bb": {}}}),
            ),
        ];
        for (mut target, patch, expected) in cases {
            merge(&mut target, &patch);
            assert_eq!(target, expected);
        }
    }

    #[test]
    fn pointers_reach_all_that_a_star_stands_for() {
        let scene = br#"{"clouds": [{"m": 1}, {"m": 2}], "b/c": {"x": {"y": 1}}}"#;
        let variant = |pointer: &str| Variant {
            set: [(pointer.to_owned(), json!(7))].into_iter().collect(),
            ..Variant::default()
        };
        let after = |pointer: &str| -> Value {
            let bytes = patched(scene, &variant(pointer)).expect(pointer);
            serde_json::from_slice(&bytes).expect("JSON")
        };
        assert_eq!(after("/clouds/*/m")["clouds"], json!([{"m": 7}, {"m": 7}]));
        assert_eq!(after("/clouds/1/n")["clouds"][1], json!({"m": 2, "n": 7}));
        assert_eq!(after("/b~1c/*/y")["b/c"], json!({"x": {"y": 7}}));
        for wrong in ["/nothing/*/x", "clouds", "/clouds/9/m"] {
            let text = patched(scene, &variant(wrong))
                .expect_err(wrong)
                .to_string();
            assert!(text.contains(wrong), "{text}");
        }
    }

    #[test]
    fn a_variant_without_changes_keeps_the_bytes() {
        let scene = b"{ \"a\":1 }";
        assert_eq!(
            patched(scene, &Variant::default()).ok().as_deref(),
            Some(&scene[..])
        );
    }
}
