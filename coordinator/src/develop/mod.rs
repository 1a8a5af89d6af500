//! From the merged linear picture to pixels and files.
//!
//! The order is fixed: bloom on linear light, exposure, view, quantisation.
//! Each acts once, on the whole picture, after all samples are summed; a tile
//! never sees any of them (bloom adds energy and reaches over tile borders).
//!
//! Everything here is pure: a [`Picture`] in, pixels or file bytes out, no
//! input or output, no clock. The same input gives the same bytes on every
//! machine and for every number of threads: transcendental functions come from
//! `libm`, and no sum crosses a thread. The work is a fraction of a second of
//! pure computing (rayon inside), so a server calls it on a blocking thread.

mod agx;
mod bloom;
mod box_filter;
mod encode_exr;
mod encode_png;
mod error;
mod exr_header;
mod octave_table;
mod picture;
mod settings;
mod view;

pub use bloom::{Bloomed, apply_bloom};
pub use encode_exr::{DEPTH_NOTHING_M, EXR_TEXT_BYTES_MAX, ExrAttributes, encode_exr};
pub use encode_png::{PngDepth, encode_png};
pub use error::DevelopError;
pub use picture::{PICTURE_PIXELS_MAX, PICTURE_SIDE_MAX, Picture};
pub use settings::{
    BLOOM_PASSES_MAX, BLOOM_STRENGTH_MAX, Bloom, EXPOSURE_EV_MAX, PostSettings, View,
};
pub use view::apply_view;

/// A picture as a display shows it.
#[derive(Clone, Debug, PartialEq)]
pub struct DevelopedImage {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Display code values (already encoded: what a PNG holds, divided by its
    /// largest integer), each in [0, 1]; row-major, top row first.
    pub rgb: Vec<[f32; 3]>,
    /// Values of the linear picture that were NaN or infinite: kept out of the
    /// bloom, shown as black (NaN, -inf) or white (+inf). Zero for a film of
    /// ours; anything else deserves a line in the report.
    pub non_finite_values: u64,
}

/// Bloom, exposure and view of `picture`, in this order.
///
/// # Errors
/// [`DevelopError::PictureSize`], [`DevelopError::PlaneLength`] and
/// [`DevelopError::Setting`], before any work is done.
pub fn develop(picture: &Picture, post: &PostSettings) -> Result<DevelopedImage, DevelopError> {
    picture.check()?;
    post.check()?;
    let bloomed = apply_bloom(
        &picture.beauty,
        picture.width,
        picture.height,
        post.bloom.as_ref(),
    )?;
    Ok(DevelopedImage {
        width: picture.width,
        height: picture.height,
        rgb: apply_view(&bloomed.rgb, post.exposure_ev, post.view),
        non_finite_values: bloomed.non_finite_values,
    })
}

/// The PNG file of `picture`: [`develop`], then [`encode_png()`].
///
/// # Errors
/// Those of the two.
pub fn develop_png(
    picture: &Picture,
    post: &PostSettings,
    depth: PngDepth,
) -> Result<Vec<u8>, DevelopError> {
    encode_png(&develop(picture, post)?, depth)
}
