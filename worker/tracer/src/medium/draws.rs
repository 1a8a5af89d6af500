//! Random numbers of one ray in one volume.

use crate::math::hash::{hash_combine64, mix64, u32_to_unit};

/// Most draws for one ray in one volume. Volumes are at most
/// [`shearwater_shared::limits::OPTICAL_THICKNESS_MAX`] thick, so only roundings
/// gone wild come here; whoever does gives up and is counted.
const DRAWS_MAX: u32 = 1 << 20;

/// A counter-based hash of (sample and segment, volume, counter): what a ray meets
/// in one volume does not depend on the others, nor on their order.
pub(super) struct Draws {
    key: u64,
    counter: u32,
}

impl Draws {
    #[inline]
    pub(super) fn new(segment_key: u64, volume: usize) -> Self {
        Self {
            key: hash_combine64(segment_key, volume as u64),
            counter: 0,
        }
    }

    /// Two uniform numbers in [0, 1); `None` when there were too many.
    #[inline]
    pub(super) fn pair(&mut self) -> Option<(f32, f32)> {
        if self.counter == DRAWS_MAX {
            return None;
        }
        self.counter += 1;
        let bits = mix64(self.key ^ u64::from(self.counter));
        Some((u32_to_unit((bits >> 32) as u32), u32_to_unit(bits as u32)))
    }
}
