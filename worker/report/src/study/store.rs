//! What is finished, as files: a second run goes on where the first ended.

use crate::measure::FrameSums;
use serde::{Serialize, de::DeserializeOwned};
use std::path::{Path, PathBuf};

/// A file could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{file}: {source}")]
pub struct StoreError {
    /// Which.
    pub file: String,
    /// Why.
    pub source: std::io::Error,
}

/// A folder of finished work. Names hold a key of everything that the content depends
/// on, so that what is found is what is wanted.
#[derive(Clone, Debug)]
pub struct Store {
    folder: PathBuf,
}

impl Store {
    /// In `folder`, made if need be.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn open(folder: &Path) -> Result<Self, StoreError> {
        std::fs::create_dir_all(folder).map_err(|source| StoreError {
            file: folder.display().to_string(),
            source,
        })?;
        Ok(Self {
            folder: folder.to_owned(),
        })
    }

    /// Bytes under a name; `None` when they are not there.
    #[must_use]
    pub fn read(&self, name: &str) -> Option<Vec<u8>> {
        std::fs::read(self.folder.join(name)).ok()
    }

    /// Write bytes under a name, whole or not at all.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), StoreError> {
        let path = self.folder.join(name);
        let partial = path.with_extension("part");
        std::fs::write(&partial, bytes)
            .and_then(|()| std::fs::rename(&partial, &path))
            .map_err(|source| StoreError {
                file: path.display().to_string(),
                source,
            })
    }

    /// A JSON value; `None` when it is not there or of another form.
    pub(super) fn read_json<T: DeserializeOwned>(&self, name: &str) -> Option<T> {
        serde_json::from_slice(&self.read(name)?).ok()
    }

    /// Write a JSON value.
    pub(super) fn write_json<T: Serialize>(&self, name: &str, value: &T) -> Result<(), StoreError> {
        let bytes = serde_json::to_vec_pretty(value).map_err(|e| StoreError {
            file: name.to_owned(),
            source: e.into(),
        })?;
        self.write(name, &bytes)
    }

    /// Sums; `None` when they are not there, damaged, or of another size.
    pub(super) fn read_sums(&self, name: &str, (width, height): (u32, u32)) -> Option<FrameSums> {
        let sums = FrameSums::decode(&self.read(name)?)?;
        ((sums.width, sums.height) == (width, height)).then_some(sums)
    }
}

/// A name that every file system takes: letters, digits and dashes.
pub(super) fn slug(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
    name.chars().map(plain).take(40).collect()
}

/// A short hash of everything that a result depends on.
pub(super) fn key(parts: &[&[u8]]) -> String {
    let mut hasher = blake3::Hasher::new();
    for part in parts {
        hasher.update(&(part.len() as u64).to_le_bytes());
        hasher.update(part);
    }
    hasher.finalize().to_hex()[..16].to_owned()
}
