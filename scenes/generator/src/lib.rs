//! Generates the models, textures and skies of the example scenes, bit for
//! bit: no platform mathematics, no threads, no order that could change.

pub mod airfoil;
pub mod assets;
pub mod bridge;
pub mod cloud_scenes;
pub mod composition;
pub mod cumulus;
pub mod curve;
pub mod gallery;
pub mod image_files;
pub mod land;
pub mod livery;
pub mod loft;
pub mod mesh;
pub mod noise;
pub mod obj;
pub mod plane;
pub mod puffs;
pub mod sky;
pub mod vec3;
mod volume_scenes;
