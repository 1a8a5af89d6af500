//! Water: a plane to the horizon whose normals come from waves.
//!
//! What all frames share is a [`SeaStage`]; [`SeaStage::at`] makes the [`Sea`] of
//! one frame, which answers [`Sea::at`] for every ray.

mod fft;
mod phillips;
mod picture;
mod slopes;
mod spectrum;

pub use picture::{HeightPictureError, HeightPictures, height_pictures};
pub use slopes::{SlopeMap, Slopes};
pub use spectrum::{HeightField, Spectrum};
