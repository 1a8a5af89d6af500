//! What the gallery shows.

use super::{GalleryError, error};
use std::path::Path;

/// The list of pictures, `scenes/gallery.json`.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gallery {
    /// Text above everything, Markdown.
    pub text: String,
    /// In their order on the page.
    pub groups: Vec<Group>,
}

/// Pictures that are compared with each other.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Group {
    /// Heading.
    pub title: String,
    /// What to see in them, Markdown.
    pub text: String,
    /// The pictures.
    pub pictures: Vec<Listed>,
}

/// One picture.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Listed {
    /// Name of its file.
    pub name: String,
    /// Scene file, relative to the project.
    pub scene: String,
    /// What it is.
    pub caption: String,
    /// `render`, or `water` for a height map.
    #[serde(default = "render")]
    pub command: String,
    /// Arguments after the scene: size, samples, frames.
    pub args: Vec<String>,
}

fn render() -> String {
    "render".to_owned()
}

impl Gallery {
    /// Read the list.
    ///
    /// # Errors
    /// No such file, or not of this form.
    pub fn read(path: &Path) -> Result<Self, GalleryError> {
        let bytes = std::fs::read(path).map_err(|e| error(path, e))?;
        serde_json::from_slice(&bytes).map_err(|e| error(path, e))
    }
}
