//! From the bytes of scene.json to a checked description.

use super::at::SCENE_FILE;
use super::tagged::split_error;
use super::{SCENE_VERSION, SceneDescription, validate};
use crate::limits::SCENE_BYTES_MAX;

/// Why a scene cannot be used: file, JSON path, and what was expected.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{file}: {path}: {message}")]
pub struct SceneError {
    /// File name: scene.json, or the asset at fault.
    pub file: String,
    /// Path inside the file (`materials.livery.roughness`, `line 12`), or `.`.
    pub path: String,
    /// What is wrong and what was expected.
    pub message: String,
}

impl SceneError {
    /// An error at `path` of `file`.
    pub fn new(
        file: impl Into<String>,
        path: impl Into<String>,
        message: impl Into<String>,
    ) -> Self {
        Self {
            file: file.into(),
            path: path.into(),
            message: message.into(),
        }
    }
}

/// Read and check a scene.
///
/// # Errors
/// Not JSON, another version, an unknown field, a value out of range, a name
/// that is not defined.
pub fn parse(bytes: &[u8]) -> Result<SceneDescription, SceneError> {
    let error = |path: &str, message: String| SceneError::new(SCENE_FILE, path, message);
    if bytes.len() > SCENE_BYTES_MAX {
        return Err(error(
            ".",
            format!("{} bytes: at most {SCENE_BYTES_MAX}", bytes.len()),
        ));
    }
    let mut json = serde_json::Deserializer::from_slice(bytes);
    let scene: SceneDescription = serde_path_to_error::deserialize(&mut json).map_err(|e| {
        let (path, message) = split_error(&e.path().to_string(), &e.inner().to_string());
        error(&path, message)
    })?;
    json.end().map_err(|e| error(".", e.to_string()))?;
    if scene.version != SCENE_VERSION {
        return Err(error(
            "version",
            format!(
                "{}: this build reads version {SCENE_VERSION}",
                scene.version
            ),
        ));
    }
    validate::validate(&scene)?;
    Ok(scene)
}

/// The JSON Schema of scene.json, generated from the types.
#[must_use]
pub fn schema_json() -> String {
    let schema = schemars::schema_for!(SceneDescription);
    let mut text = serde_json::to_string_pretty(&schema).unwrap_or_default();
    text.push('\n');
    text
}

#[cfg(test)]
#[path = "parse_tests.rs"]
mod tests;
