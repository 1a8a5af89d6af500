//! A place inside scene.json, written out only when something is wrong there.

use super::SceneError;
use std::fmt;

/// The scene's own file in errors.
pub(super) const SCENE_FILE: &str = "scene.json";

/// A JSON path as a chain of borrowed steps: a scene of a million instances is
/// checked without making a string.
#[derive(Clone, Copy)]
pub(super) struct At<'a> {
    parent: Option<&'a At<'a>>,
    step: Step<'a>,
}

#[derive(Clone, Copy)]
enum Step<'a> {
    Root,
    Field(&'a str),
    Index(usize),
}

impl<'a> At<'a> {
    /// The whole file.
    pub(super) const fn root() -> Self {
        Self {
            parent: None,
            step: Step::Root,
        }
    }

    /// A field, or an entry of a map, of this place.
    pub(super) const fn field(&'a self, name: &'a str) -> At<'a> {
        At {
            parent: Some(self),
            step: Step::Field(name),
        }
    }

    /// An element of this array.
    pub(super) const fn index(&'a self, index: usize) -> At<'a> {
        At {
            parent: Some(self),
            step: Step::Index(index),
        }
    }

    /// An error at this place.
    pub(super) fn error(&self, message: impl Into<String>) -> SceneError {
        SceneError::new(SCENE_FILE, self.to_string(), message)
    }
}

impl fmt::Display for At<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let nested = match self.parent {
            Some(parent) if !matches!(parent.step, Step::Root) => {
                write!(f, "{parent}")?;
                true
            }
            _ => false,
        };
        match self.step {
            Step::Root => f.write_str("."),
            Step::Field(name) if nested => write!(f, ".{name}"),
            Step::Field(name) => f.write_str(name),
            Step::Index(index) => write!(f, "[{index}]"),
        }
    }
}
