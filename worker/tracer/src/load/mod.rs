//! From the bytes of assets to arrays: meshes, textures, pictures of skies and clouds.
//!
//! Everything here is a pure function of bytes that somebody else wrote: a
//! wrong file is an error that names it and the place in it, never a panic, and
//! sizes are checked before memory is taken. What was left out of a file (faces
//! without area, values that are not numbers) is counted in [`LoadNotes`].

mod cloud_image;
mod exr_file;
mod grid;
mod image_file;
mod materials;
mod mtl;
mod normals;
mod notes;
mod obj;
mod obj_reader;
mod sky;
mod texture;
mod triangulate;
mod vertices;

pub use cloud_image::{CloudImage, load_cloud_image};
pub use grid::load_grid;
pub use materials::resolve_materials;
pub use mtl::{MtlMap, MtlMaterial};
pub use notes::LoadNotes;
pub use obj::{LoadedMesh, UNNAMED_MATERIAL, load_mesh};
pub use sky::{SkyImage, load_sky};
pub use texture::{Encoding, Texture, load_texture};

use std::collections::BTreeMap;
use std::sync::Arc;

/// The files of a scene by name.
pub type Assets = BTreeMap<String, Arc<[u8]>>;
