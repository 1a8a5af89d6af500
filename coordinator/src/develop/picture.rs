//! The merged linear picture: what the film becomes before it is shown.

use super::error::DevelopError;

/// Widest and highest picture, in pixels: the farm's own limit (16k, the
/// largest common still); it also keeps every index of a row in 32 bits.
pub const PICTURE_SIDE_MAX: u32 = 16_384;

/// Most pixels of one picture, the farm's own limit: developing needs about
/// 60 bytes for each (4 GiB here) beside the picture itself.
pub const PICTURE_PIXELS_MAX: u64 = 1 << 26;

/// A picture in linear light with its auxiliary planes.
///
/// Every plane is row-major with the top row first and has `width * height`
/// entries. Optional planes that are absent are absent from the EXR too.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Pixels per row, 1 to [`PICTURE_SIDE_MAX`].
    pub width: u32,
    /// Rows, 1 to [`PICTURE_SIDE_MAX`].
    pub height: u32,
    /// Mean radiance, linear, primaries of Rec. 709, white D65.
    pub beauty: Vec<[f32; 3]>,
    /// Variance of the pixel mean, per channel, estimated from the two halves
    /// of the film: (A - B)^2 / 4. Unit: that of `beauty`, squared.
    pub variance: Option<Vec<[f32; 3]>>,
    /// Mean albedo of what the pixel sees first, linear, in [0, 1]; zero where
    /// nothing was hit (the convention denoisers expect).
    pub albedo: Option<Vec<[f32; 3]>>,
    /// Mean shading normal of what the pixel sees first, world space,
    /// components in [-1, 1]; zero where nothing was hit.
    pub normal: Option<Vec<[f32; 3]>>,
    /// Distance along the camera ray to what the pixel sees first, in metres.
    /// Nothing hit: any value that is no positive number (+inf by preference;
    /// 0 and NaN mean the same). Files then hold
    /// [`DEPTH_NOTHING_M`](super::DEPTH_NOTHING_M).
    pub depth: Option<Vec<f32>>,
    /// Samples per pixel; 0 for a pixel that has none yet.
    pub sample_count: Vec<u32>,
}

impl Picture {
    /// Pixels of the picture: `width * height`.
    #[must_use]
    pub fn pixel_count(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Checks the size against the limits and every plane against the size.
    ///
    /// # Errors
    /// [`DevelopError::PictureSize`] or [`DevelopError::PlaneLength`].
    pub fn check(&self) -> Result<(), DevelopError> {
        let expected = check_size(self.width, self.height)?;
        let planes = [
            ("beauty", Some(self.beauty.len())),
            ("variance", self.variance.as_ref().map(Vec::len)),
            ("albedo", self.albedo.as_ref().map(Vec::len)),
            ("normal", self.normal.as_ref().map(Vec::len)),
            ("depth", self.depth.as_ref().map(Vec::len)),
            ("sample_count", Some(self.sample_count.len())),
        ];
        for (plane, len) in planes {
            if let Some(len) = len {
                check_len(plane, len, expected)?;
            }
        }
        Ok(())
    }
}

/// The number of pixels of a picture of this size.
///
/// # Errors
/// [`DevelopError::PictureSize`] outside the limits.
pub(super) fn check_size(width: u32, height: u32) -> Result<usize, DevelopError> {
    let pixels = u64::from(width) * u64::from(height);
    let sides_ok =
        (1..=PICTURE_SIDE_MAX).contains(&width) && (1..=PICTURE_SIDE_MAX).contains(&height);
    match usize::try_from(pixels) {
        Ok(count) if sides_ok && pixels <= PICTURE_PIXELS_MAX => Ok(count),
        _ => Err(DevelopError::PictureSize { width, height }),
    }
}

/// Whether `plane` holds one value per pixel.
///
/// # Errors
/// [`DevelopError::PlaneLength`] if not.
pub(super) fn check_len(
    plane: &'static str,
    len: usize,
    expected: usize,
) -> Result<(), DevelopError> {
    if len == expected {
        Ok(())
    } else {
        Err(DevelopError::PlaneLength {
            plane,
            len,
            expected,
        })
    }
}
