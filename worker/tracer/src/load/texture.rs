//! Textures of reflectance.

use super::exr_file::{LinearImage, read_exr};
use super::image_file::{ByteImage, Format, format_of, read_image};
use shearwater_shared::scene::SceneError;

/// What the bytes of a PNG or JPEG mean. An EXR holds plain numbers anyway.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Encoding {
    /// Colours, encoded by the sRGB curve.
    Srgb,
    /// Plain numbers: 255 is 1.
    Linear,
}

/// A picture that is looked up by texture coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// Texels outside 0..1, or not finite, in an EXR: clamped.
    pub bad_texels: u64,
    texels: Texels,
}

/// Rows from the top.
#[derive(Clone, Debug, PartialEq)]
enum Texels {
    /// 4 bytes each and what each byte means.
    Bytes {
        rgba: Vec<[u8; 4]>,
        linear: Box<[f32; 256]>,
    },
    Linear(Vec<[f32; 3]>),
}

/// Read a PNG or JPEG (by its encoding) or an EXR (linear) as reflectance or
/// other shares, each channel 0 to 1.
///
/// # Errors
/// Another format, a damaged file, more texels than allowed, DWAA or DWAB.
pub fn load_texture(file: &str, bytes: &[u8], encoding: Encoding) -> Result<Texture, SceneError> {
    match format_of(file, bytes)? {
        Format::Exr => Ok(Texture::from_linear(read_exr(file, bytes)?)),
        format => Ok(Texture::from_bytes(
            read_image(file, bytes, format)?,
            match encoding {
                Encoding::Srgb => srgb_table(),
                Encoding::Linear => linear_table(),
            },
        )),
    }
}

/// Linear light of an 8-bit sRGB value (IEC 61966-2-1).
pub(super) fn srgb_table() -> Box<[f32; 256]> {
    let mut table = Box::new([0.0; 256]);
    for (byte, linear) in (0_u8..=255).zip(table.iter_mut()) {
        let value = f64::from(byte) / 255.0;
        *linear = if value <= 0.040_45 {
            value / 12.92
        } else {
            libm::pow((value + 0.055) / 1.055, 2.4)
        } as f32;
    }
    table
}

/// Shares of 255.
fn linear_table() -> Box<[f32; 256]> {
    Box::new(std::array::from_fn(|byte| byte as f32 / 255.0))
}

impl Texture {
    fn from_bytes(image: ByteImage, meaning: Box<[f32; 256]>) -> Self {
        Self {
            width: image.width,
            height: image.height,
            bad_texels: 0,
            texels: Texels::Bytes {
                rgba: image.rgba,
                linear: meaning,
            },
        }
    }

    fn from_linear(mut image: LinearImage) -> Self {
        for texel in &mut image.rgb {
            if texel.iter().any(|&x| x > 1.0) {
                image.bad_texels += 1;
                *texel = texel.map(|x| x.min(1.0));
            }
        }
        Self {
            width: image.width,
            height: image.height,
            bad_texels: image.bad_texels,
            texels: Texels::Linear(image.rgb),
        }
    }

    /// Linear RGB at texture coordinates, u to the right and v upwards, each
    /// repeating with period 1; texel centres at half-integers, bilinear
    /// between them. Coordinates that are not finite count as 0.
    #[inline]
    #[must_use]
    pub fn rgb(&self, u: f32, v: f32) -> [f32; 3] {
        let (x0, x1, fx) = neighbours(wrap(u), self.width);
        let (y0, y1, fy) = neighbours(1.0 - wrap(v), self.height);
        let [a, b, c, d] = [(x0, y0), (x1, y0), (x0, y1), (x1, y1)].map(|(x, y)| self.texel(x, y));
        std::array::from_fn(|i| {
            let top = a[i] + fx * (b[i] - a[i]);
            let bottom = c[i] + fx * (d[i] - c[i]);
            top + fy * (bottom - top)
        })
    }

    /// Linear RGB of a texel; column and row are below width and height.
    #[inline]
    fn texel(&self, column: u32, row: u32) -> [f32; 3] {
        let index = row as usize * self.width as usize + column as usize;
        match &self.texels {
            Texels::Bytes { rgba, linear } => {
                let [r, g, b, _] = rgba[index];
                [r, g, b].map(|byte| linear[usize::from(byte)])
            }
            Texels::Linear(rgb) => rgb[index],
        }
    }

    /// Memory of the texels in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        match &self.texels {
            Texels::Bytes { rgba, .. } => rgba.len() * 4,
            Texels::Linear(rgb) => rgb.len() * 12,
        }
    }
}

/// The part after the point, 0 to 1, also of negative coordinates: -0.25 is
/// 0.75. Truncation instead of `floor`, which is a call on plain x86-64.
#[inline]
fn wrap(coordinate: f32) -> f32 {
    let part = coordinate - coordinate as i32 as f32;
    let part = if part < 0.0 { part + 1.0 } else { part };
    // Beyond 2^31 the cast saturates; such a number has no part anyway.
    if (0.0..=1.0).contains(&part) {
        part
    } else {
        0.0
    }
}

/// The two texels around a coordinate in 0..=1 and the share of the second.
#[inline]
fn neighbours(coordinate: f32, size: u32) -> (u32, u32, f32) {
    // Half a texel to the right, so that truncation gives the right one.
    let x = coordinate * size as f32 + 0.5;
    let right = x as u32;
    let share = x - right as f32;
    let left = if right == 0 { size - 1 } else { right - 1 };
    // At 1 the right neighbour is the first texel again; rounding may give one more.
    let wrapped = if right >= size { right - size } else { right };
    (left.min(size - 1), wrapped.min(size - 1), share)
}
