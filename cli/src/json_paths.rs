//! Where in a JSON file a text stands.

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// For each of `texts` that stands in `json`, the path of its first place
/// (`meshes.cube.file`, `clouds[0].formation.file`). A field that is named as
/// one that holds a file goes before any other.
pub(crate) fn find(json: &Value, texts: &BTreeSet<String>) -> BTreeMap<String, String> {
    let mut places = BTreeMap::new();
    walk(json, "", "", texts, &mut places);
    let path = |(text, place): (&str, Place)| (text.to_owned(), place.path);
    places.into_iter().map(path).collect()
}

struct Place {
    path: String,
    holds_file: bool,
}

// As deep as the parser goes, which is 128 levels.
fn walk<'a>(
    value: &'a Value,
    path: &str,
    field: &str,
    texts: &BTreeSet<String>,
    places: &mut BTreeMap<&'a str, Place>,
) {
    match value {
        Value::String(text) if texts.contains(text) => {
            let holds_file = ["file", "texture", "image", "map"]
                .iter()
                .any(|end| field.ends_with(end));
            let known = places.get(text.as_str());
            if known.is_none_or(|known| holds_file && !known.holds_file) {
                let path = path.to_owned();
                places.insert(text, Place { path, holds_file });
            }
        }
        Value::Array(elements) => {
            for (index, element) in elements.iter().enumerate() {
                walk(element, &format!("{path}[{index}]"), field, texts, places);
            }
        }
        Value::Object(fields) => {
            let dot = if path.is_empty() { "" } else { "." };
            for (name, inner) in fields {
                walk(inner, &format!("{path}{dot}{name}"), name, texts, places);
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn places_of_files() {
        let scene = json!({
            "name": "cube",
            "clouds": [{"a": 1}, {"formation": {"image_file": "a.png"}}],
            "instances": [{"mesh": "b.obj"}],
            "meshes": {"b.obj": {"file": "b.obj"}},
            "sky": "other"
        });
        let texts = ["a.png", "b.obj", "cube", "nowhere"].map(str::to_owned);
        let found = find(&scene, &texts.into());
        let expected = [
            ("a.png", "clouds[1].formation.image_file"),
            ("b.obj", "meshes.b.obj.file"),
            ("cube", "name"),
        ];
        let expected = expected.map(|(text, path)| (text.to_owned(), path.to_owned()));
        assert_eq!(found, expected.into());
    }
}
