//! Pictures of any program, as RGB.

mod exr_file;
mod png_file;

use std::path::Path;

/// Most pixels of a picture that is compared: the most that can be rendered.
const PIXELS_MAX: u64 = shearwater_shared::limits::IMAGE_PIXELS_MAX;

/// What the numbers of a picture mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// Linear radiance of any size (EXR).
    Linear,
    /// What a screen shows: sRGB, 0 to 1 (PNG).
    Display,
}

/// A picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Pixels, row by row from the top; every value is finite.
    pub rgb: Vec<[f32; 3]>,
    /// What the values mean.
    pub range: Range,
    /// What else the file tells.
    pub planes: Planes,
}

/// What an EXR file of ours tells of its pixels beside their light: as many entries as
/// pixels, in their order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Planes {
    /// Samples of each pixel: `sampleCount`.
    pub sample_count: Option<Vec<u32>>,
    /// Variance of each pixel's mean: `variance.R/G/B`; finite, not negative.
    pub variance: Option<Vec<[f32; 3]>>,
}

/// Why a picture cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The file could not be read or written.
    #[error("{file}: {source}")]
    Io {
        /// Which.
        file: String,
        /// Why.
        source: std::io::Error,
    },
    /// Its content is wrong.
    #[error("{file}: {message}")]
    Content {
        /// Which.
        file: String,
        /// What was found and what was expected.
        message: String,
    },
}

impl PictureError {
    fn content(file: &str, message: impl Into<String>) -> Self {
        Self::Content {
            file: file.to_owned(),
            message: message.into(),
        }
    }
}

impl Picture {
    /// Read an EXR or PNG file, told apart by its first bytes.
    ///
    /// # Errors
    /// [`PictureError`]: the file, and what is wrong with it.
    pub fn read(path: &Path) -> Result<Self, PictureError> {
        let file = path.display().to_string();
        let bytes = std::fs::read(path).map_err(|source| PictureError::Io {
            file: file.clone(),
            source,
        })?;
        Self::decode(&file, &bytes)
    }

    /// The same from bytes; `file` is only named in errors.
    ///
    /// # Errors
    /// [`PictureError::Content`].
    pub fn decode(file: &str, bytes: &[u8]) -> Result<Self, PictureError> {
        let picture = if bytes.starts_with(&exr_file::MAGIC) {
            exr_file::decode(file, bytes)?
        } else if bytes.starts_with(&png_file::MAGIC) {
            png_file::decode(file, bytes)?
        } else {
            let message = "neither an EXR nor a PNG file: expected one of them";
            return Err(PictureError::content(file, message));
        };
        picture.check(file)?;
        Ok(picture)
    }

    /// Columns and rows, as people write them.
    #[must_use]
    pub fn size(&self) -> String {
        format!("{}x{}", self.width, self.height)
    }

    /// Values that are no numbers would make every figure one of those.
    fn check(&self, file: &str) -> Result<(), PictureError> {
        let bad = |rgb: &[f32; 3]| !rgb.iter().all(|v| v.is_finite());
        let Some(first) = self.rgb.iter().position(bad) else {
            return Ok(());
        };
        let count = self.rgb.iter().filter(|rgb| bad(rgb)).count();
        let (x, y) = (first % self.width, first / self.width);
        let message = format!(
            "{count} pixels hold NaN or infinity, the first at column {x}, row {y}: \
             expected finite numbers"
        );
        Err(PictureError::content(file, message))
    }

    /// As a screen shows it without any tone curve: clamped to 0..1, sRGB.
    #[must_use]
    pub fn displayed(&self) -> Vec<[f32; 3]> {
        match self.range {
            Range::Display => self.rgb.clone(),
            Range::Linear => self.rgb.iter().map(|rgb| rgb.map(srgb_of_linear)).collect(),
        }
    }

    /// Linear values clamped to 0..1: what a screen emits.
    #[must_use]
    pub fn emitted(&self) -> Vec<[f32; 3]> {
        match self.range {
            Range::Display => self.rgb.iter().map(|rgb| rgb.map(linear_of_srgb)).collect(),
            Range::Linear => self
                .rgb
                .iter()
                .map(|rgb| rgb.map(|v| v.clamp(0.0, 1.0)))
                .collect(),
        }
    }
}

/// Refuse sizes before memory is taken for them.
fn check_size(file: &str, width: u64, height: u64) -> Result<(), PictureError> {
    let pixels = width.saturating_mul(height);
    if pixels == 0 || pixels > PIXELS_MAX {
        let message = format!("{width}x{height} pixels: expected 1 to {PIXELS_MAX} in all");
        return Err(PictureError::content(file, message));
    }
    Ok(())
}

/// IEC 61966-2-1, decoding; `value` 0 to 1.
pub(crate) fn linear_of_srgb(value: f32) -> f32 {
    if value <= 0.04045 {
        value / 12.92
    } else {
        libm::powf((value + 0.055) / 1.055, 2.4)
    }
}

/// IEC 61966-2-1, encoding; clamps to 0..1.
pub(crate) fn srgb_of_linear(value: f32) -> f32 {
    let value = value.clamp(0.0, 1.0);
    if value <= 0.003_130_8 {
        value * 12.92
    } else {
        1.055 * libm::powf(value, 1.0 / 2.4) - 0.055
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encoding_and_decoding_are_inverse() {
        for step in 0..=100 {
            let value = step as f32 / 100.0;
            let back = srgb_of_linear(linear_of_srgb(value));
            assert!((back - value).abs() < 1e-5, "{value} {back}");
        }
    }

    #[test]
    fn what_is_no_picture_is_said() {
        let error = Picture::decode("a.exr", b"hello").expect_err("no picture");
        assert!(error.to_string().starts_with("a.exr: neither"), "{error}");
        let cut = Picture::decode("a.exr", &[0x76, 0x2f, 0x31, 0x01, 2]).expect_err("cut");
        assert!(cut.to_string().contains("EXR"), "{cut}");
        let cut = Picture::decode("a.png", b"\x89PNG\r\n\x1a\n").expect_err("cut");
        assert!(cut.to_string().contains("PNG"), "{cut}");
    }

    #[test]
    fn nan_is_named_with_its_place() {
        let mut picture = Picture {
            width: 3,
            height: 2,
            rgb: vec![[0.5; 3]; 6],
            range: Range::Linear,
            planes: Planes::default(),
        };
        assert!(picture.check("a").is_ok());
        picture.rgb[4][1] = f32::NAN;
        let text = picture.check("a.exr").expect_err("NaN").to_string();
        assert!(text.contains("column 1, row 1"), "{text}");
    }
}
