//! The gallery: renders what `scenes/gallery.json` lists and writes
//! `docs/gallery.md` with every picture, its command, seconds and error.
//!
//! Results are kept beside the pictures, so that one picture can be rendered
//! again without the others.

mod list;
mod page;
mod picture;

pub use list::{Gallery, Group, Listed};

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// All pictures together, in bytes: a clone of the project should stay small.
const PICTURES_BYTES_MAX: u64 = 8 << 20;

/// Why the gallery could not be made.
#[derive(Debug)]
pub struct GalleryError(String);

impl std::fmt::Display for GalleryError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for GalleryError {}

fn error(what: &Path, why: impl std::fmt::Display) -> GalleryError {
    GalleryError(format!("{}: {why}", what.display()))
}

/// What one rendering said about itself.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Measured {
    /// Arguments of `shearwater` that made it.
    pub args: Vec<String>,
    /// Seconds from the first lease to the last result; of the whole command for
    /// what is not rendered.
    pub seconds: f64,
    /// Estimated error of the picture, from its two halves; none for what is exact.
    pub nmse: Option<f64>,
    /// Hash of the first frame's film.
    pub film_hash: String,
}

/// Render the pictures of `scenes/gallery.json` with `binary` and write the page;
/// only those whose name contains `only`, if that is given.
///
/// # Errors
/// A list that cannot be read, a render that fails, a folder that cannot be
/// written, pictures that are too large together.
pub fn make(binary: &Path, only: Option<&str>) -> Result<(), GalleryError> {
    let list = Gallery::read(Path::new("scenes/gallery.json"))?;
    let folder = PathBuf::from("docs/gallery");
    std::fs::create_dir_all(&folder).map_err(|e| error(&folder, e))?;
    let record = folder.join("measured.json");
    let mut measured: BTreeMap<String, Measured> = match std::fs::read(&record) {
        Ok(bytes) => serde_json::from_slice(&bytes).map_err(|e| error(&record, e))?,
        Err(_) => BTreeMap::new(),
    };
    for listed in list.groups.iter().flat_map(|group| &group.pictures) {
        if only.is_some_and(|only| !listed.name.contains(only)) {
            continue;
        }
        println!("{}", listed.name);
        measured.insert(
            listed.name.clone(),
            picture::render(binary, listed, &folder)?,
        );
        // Kept at once: a later failure must not cost the hours before it.
        let text = serde_json::to_string_pretty(&measured).map_err(|e| error(&record, e))?;
        std::fs::write(&record, text + "\n").map_err(|e| error(&record, e))?;
    }
    let page = Path::new("docs/gallery.md");
    std::fs::write(page, page::write(&list, &measured)).map_err(|e| error(page, e))?;
    check_size(&folder, &list)
}

fn check_size(folder: &Path, list: &Gallery) -> Result<(), GalleryError> {
    let size = |listed: &Listed| {
        std::fs::metadata(folder.join(format!("{}.png", listed.name))).map_or(0, |m| m.len())
    };
    let bytes: u64 = list.groups.iter().flat_map(|g| &g.pictures).map(size).sum();
    println!("{bytes} bytes in all pictures");
    if bytes > PICTURES_BYTES_MAX {
        let why =
            format!("{bytes} bytes of pictures: at most {PICTURES_BYTES_MAX}; make them smaller");
        return Err(error(folder, why));
    }
    Ok(())
}
