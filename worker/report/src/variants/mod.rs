//! Variants of a scene: what is measured against what.

#[cfg(test)]
mod lists_tests;
mod patch;

pub use patch::{PatchError, patched};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use shearwater_shared::limits::RUN_SAMPLES_PER_HALF_MAX;

/// Most variants in one list: each is rendered for every scene.
pub const VARIANTS_MAX: usize = 100;
/// Longest name of a variant, in bytes: it stands in tables.
pub const VARIANT_NAME_BYTES_MAX: usize = 60;
/// Largest side of a tile in pixels; sums of a tile take 48 bytes for each pixel.
pub const TILE_SIDE_MAX: u32 = 1024;
/// Most threads of a variant.
pub const THREADS_MAX: u16 = 1024;

/// One way to render a scene. Without any field but the name: the scene as it is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Variant {
    /// What it is called in tables and plots.
    pub name: String,
    /// Changes of scene.json, as a merge patch (RFC 7396).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene: Option<Value>,
    /// Further changes: a JSON pointer (RFC 6901) to a new value. `*` stands for every
    /// element of a list or object, so that one entry reaches all clouds.
    #[serde(default, skip_serializing_if = "Map::is_empty")]
    pub set: Map<String, Value>,
    /// Render threads [default: those of the command line].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub threads: Option<u16>,
    /// Side of a tile in pixels [default: 64].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tile: Option<u32>,
    /// Sample indices per half that a thread renders of a tile at once [default: 64].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub block: Option<u32>,
    /// The variant shows another picture on purpose (another reflectance model): it is
    /// measured against a reference of its own.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub own_reference: bool,
}

/// What is wrong with a list of variants.
#[derive(Debug, thiserror::Error)]
#[error("{file}: {at}: {message}")]
pub struct VariantsError {
    /// Which file.
    pub file: String,
    /// JSON path.
    pub at: String,
    /// What was found and what was expected.
    pub message: String,
}

/// Read a JSON list of variants; `file` is named in errors.
///
/// # Errors
/// [`VariantsError`] with the JSON path of the first mistake.
pub fn parse_variants(file: &str, json: &[u8]) -> Result<Vec<Variant>, VariantsError> {
    let fail = |at: String, message: String| VariantsError {
        file: file.to_owned(),
        at,
        message,
    };
    let mut reader = serde_json::Deserializer::from_slice(json);
    let list: Vec<Variant> = serde_path_to_error::deserialize(&mut reader)
        .map_err(|e| fail(e.path().to_string(), e.inner().to_string()))?;
    reader
        .end()
        .map_err(|e| fail(".".to_owned(), e.to_string()))?;
    if list.is_empty() || list.len() > VARIANTS_MAX {
        let message = format!("{} variants: expected 1 to {VARIANTS_MAX}", list.len());
        return Err(fail(".".to_owned(), message));
    }
    for (number, variant) in list.iter().enumerate() {
        check(variant).map_err(|(field, m)| fail(format!("[{number}].{field}"), m))?;
        if list[..number]
            .iter()
            .any(|other| other.name == variant.name)
        {
            let message = format!("another variant is called `{}` already", variant.name);
            return Err(fail(format!("[{number}].name"), message));
        }
    }
    Ok(list)
}

fn check(variant: &Variant) -> Result<(), (&'static str, String)> {
    let name = variant.name.trim();
    if name.is_empty() || name.len() > VARIANT_NAME_BYTES_MAX {
        let message = format!("expected a name of 1 to {VARIANT_NAME_BYTES_MAX} bytes");
        return Err(("name", message));
    }
    let range = |field, value: Option<u32>, least: u32, most: u32| match value {
        Some(value) if !(least..=most).contains(&value) => {
            Err((field, format!("{value}: expected {least} to {most}")))
        }
        _ => Ok(()),
    };
    range(
        "threads",
        variant.threads.map(u32::from),
        1,
        THREADS_MAX.into(),
    )?;
    range("tile", variant.tile, 1, TILE_SIDE_MAX)?;
    range("block", variant.block, 1, RUN_SAMPLES_PER_HALF_MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mistakes_are_named_with_their_place() {
        let cases = [
            ("[]", "1 to 100"),
            ("{}", "list.json"),
            (r#"[{"name": "a"}, {"name": "a"}]"#, "[1].name"),
            (r#"[{"name": ""}]"#, "[0].name"),
            (r#"[{"name": "a", "tile": 0}]"#, "[0].tile"),
            (r#"[{"name": "a", "block": 5000}]"#, "[0].block"),
            (r#"[{"name": "a", "threads": 0}]"#, "[0].threads"),
            (r#"[{"name": "a", "tiles": 3}]"#, "[0]"),
            (r#"[{"name": "a", "block": "x"}]"#, "[0].block"),
            (r#"[{"name": "a"}] x"#, "trailing"),
        ];
        for (json, expected) in cases {
            let text = parse_variants("list.json", json.as_bytes())
                .expect_err(json)
                .to_string();
            assert!(
                text.starts_with("list.json: ") && text.contains(expected),
                "{text}"
            );
        }
    }
}
