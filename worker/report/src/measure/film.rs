//! Exact sums of one frame.

use shearwater_shared::film::{FIXED_ONE, TileSums};
use shearwater_shared::plan::TileRect;

/// Sums of both halves of a frame, in fixed point; samples are added at the end of the
/// range that is there already.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FrameSums {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Samples per pixel in each half.
    pub samples_per_half: u32,
    /// Samples that were no light.
    pub bad: u64,
    radiance: [Vec<i128>; 2],
}

/// First bytes of a file of sums; the number is its version.
const MAGIC: &[u8; 18] = b"shearwater sums 1\n";

impl FrameSums {
    /// No samples yet.
    #[must_use]
    pub fn zero(width: u32, height: u32) -> Self {
        let values = 3 * width as usize * height as usize;
        Self {
            width,
            height,
            samples_per_half: 0,
            bad: 0,
            radiance: [vec![0; values], vec![0; values]],
        }
    }

    /// Add the sums of a tile. Whoever has added all tiles sets `samples_per_half`.
    pub(super) fn add(&mut self, rect: &TileRect, part: &TileSums) {
        for (sums, add) in self.radiance.iter_mut().zip(&part.radiance) {
            for row in 0..rect.height {
                let at = 3 * ((rect.y0 + row) * self.width + rect.x0) as usize;
                let from = 3 * (row * rect.width) as usize;
                let values = 3 * rect.width as usize;
                let (Some(sums), Some(add)) =
                    (sums.get_mut(at..at + values), add.get(from..from + values))
                else {
                    continue;
                };
                for (sum, &value) in sums.iter_mut().zip(add) {
                    *sum += i128::from(value);
                }
            }
        }
        let bad = &part.bad;
        self.bad += bad.not_a_number + bad.infinite + bad.negative + bad.overflow;
    }

    fn scale(&self) -> f64 {
        1.0 / (f64::from(self.samples_per_half.max(1)) * FIXED_ONE)
    }

    /// The mean picture.
    #[must_use]
    pub fn mean(&self) -> Vec<[f32; 3]> {
        let (scale, [a, b]) = (0.5 * self.scale(), &self.radiance);
        let pixel =
            |i: usize| [0, 1, 2].map(|c| ((a[3 * i + c] + b[3 * i + c]) as f64 * scale) as f32);
        (0..a.len() / 3).map(pixel).collect()
    }

    /// The mean picture of one half, 0 or 1.
    #[must_use]
    pub fn half_mean(&self, half: usize) -> Vec<[f64; 3]> {
        let (scale, sums) = (self.scale(), &self.radiance[half.min(1)]);
        let pixel = |i: usize| [0, 1, 2].map(|c| sums[3 * i + c] as f64 * scale);
        (0..sums.len() / 3).map(pixel).collect()
    }

    /// Half the difference of the halves, per pixel and channel: as large as the error
    /// of the mean, and with the mean 0.
    #[must_use]
    pub fn half_difference(&self) -> Vec<[f64; 3]> {
        let (scale, [a, b]) = (0.5 * self.scale(), &self.radiance);
        let pixel = |i: usize| [0, 1, 2].map(|c| (a[3 * i + c] - b[3 * i + c]) as f64 * scale);
        (0..a.len() / 3).map(pixel).collect()
    }

    /// As bytes, little endian, with a checksum at the end.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let mut out = MAGIC.to_vec();
        for value in [self.width, self.height, self.samples_per_half] {
            out.extend(value.to_le_bytes());
        }
        out.extend(self.bad.to_le_bytes());
        for value in self.radiance.iter().flatten() {
            out.extend(value.to_le_bytes());
        }
        let hash = blake3::hash(&out);
        out.extend(hash.as_bytes());
        out
    }

    /// The reverse; `None` for bytes that were cut or changed.
    #[must_use]
    pub fn decode(bytes: &[u8]) -> Option<Self> {
        let (content, hash) = bytes.split_at_checked(bytes.len().checked_sub(32)?)?;
        if blake3::hash(content).as_bytes() != hash {
            return None;
        }
        let rest = content.strip_prefix(MAGIC)?;
        let (head, values) = rest.split_at_checked(20)?;
        let word = |at: usize| Some(u32::from_le_bytes(head.get(at..at + 4)?.try_into().ok()?));
        let (width, height) = (word(0)?, word(4)?);
        let mut sums = Self::zero(width, height);
        sums.samples_per_half = word(8)?;
        sums.bad = u64::from_le_bytes(head.get(12..20)?.try_into().ok()?);
        if values.len() != 16 * 2 * sums.radiance[0].len() {
            return None;
        }
        let stored = values.chunks_exact(16).map(|chunk| {
            let mut bytes = [0; 16];
            bytes.copy_from_slice(chunk);
            i128::from_le_bytes(bytes)
        });
        for (sum, value) in sums.radiance.iter_mut().flatten().zip(stored) {
            *sum = value;
        }
        Some(sums)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_back_and_damage_is_seen() {
        let mut sums = FrameSums::zero(3, 2);
        sums.samples_per_half = 5;
        sums.bad = 1;
        sums.radiance[1][7] = -(1 << 90);
        let bytes = sums.encode();
        assert_eq!(FrameSums::decode(&bytes), Some(sums));
        for at in [0, 20, bytes.len() - 1] {
            let mut damaged = bytes.clone();
            damaged[at] ^= 1;
            assert_eq!(FrameSums::decode(&damaged), None);
        }
        assert_eq!(FrameSums::decode(&bytes[..bytes.len() - 1]), None);
        assert_eq!(FrameSums::decode(&[]), None);
    }
}
