//! What can be wrong with a request to develop a picture.

use super::picture::{PICTURE_PIXELS_MAX, PICTURE_SIDE_MAX};

/// Why a picture was not developed. Nothing was written in any case.
#[derive(Debug, thiserror::Error)]
pub enum DevelopError {
    /// The picture is empty or larger than the limits.
    #[error(
        "picture of {width} x {height} pixels: each side must be 1 to {PICTURE_SIDE_MAX} and \
         there may be at most {PICTURE_PIXELS_MAX} pixels; choose a smaller size"
    )]
    PictureSize {
        /// Pixels per row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// A plane does not hold one value per pixel.
    #[error("plane `{plane}` holds {len} values, expected {expected} (width x height)")]
    PlaneLength {
        /// Field of the picture.
        plane: &'static str,
        /// Values found.
        len: usize,
        /// Values expected.
        expected: usize,
    },
    /// A post setting is out of range.
    #[error("post setting `{name}` is {value}; expected {expected}")]
    Setting {
        /// Path of the setting, such as `bloom.radius`.
        name: &'static str,
        /// The value given.
        value: f64,
        /// The range, in words.
        expected: String,
    },
    /// A text attribute cannot stand in an EXR header.
    #[error(
        "EXR attribute `{name}` must be at most {bytes_max} bytes of printable ASCII; shorten it \
         or replace the other characters"
    )]
    AttributeText {
        /// Name of the attribute in the file.
        name: &'static str,
        /// The limit.
        bytes_max: usize,
    },
    /// The PNG encoder refused.
    #[error("PNG encoding failed: {0}")]
    Png(#[from] image::ImageError),
    /// The EXR encoder refused.
    #[error("EXR encoding failed: {0}")]
    Exr(#[from] exr::error::Error),
    /// The encoder made a file whose layout is not the one we know.
    #[error(
        "{format} encoder wrote an unexpected layout ({detail}); this is a fault of the program, \
         please report it with its version"
    )]
    Layout {
        /// `PNG` or `EXR`.
        format: &'static str,
        /// What was found.
        detail: &'static str,
    },
}
