//! Pictures made for tests.

use shearwater_coordinator::develop::Picture;

/// A fixed stream of numbers in [0, 1): Knuth's 64-bit linear congruence, upper
/// 24 bits.
pub(crate) struct Numbers(pub(crate) u64);

impl Numbers {
    pub(crate) fn next(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / 16_777_216.0
    }
}

/// Sky-like noise in [0, 2) with a few pixels of 10 to 10^6.
pub(crate) fn noisy(width: u32, height: u32, seed: u64) -> Vec<[f32; 3]> {
    let mut numbers = Numbers(seed);
    (0..width * height)
        .map(|_| {
            let boost = match numbers.next() {
                u if u < 0.005 => 1e6,
                u if u < 0.02 => 10.0,
                _ => 1.0,
            };
            [0; 3].map(|_| 2.0 * boost * numbers.next())
        })
        .collect()
}

/// A picture with every plane.
pub(crate) fn full_picture(width: u32, height: u32) -> Picture {
    let count = (width * height) as usize;
    let mut depth: Vec<f32> = (0..count).map(|i| 0.5 + i as f32 * 0.25).collect();
    depth[0] = f32::INFINITY;
    depth[1] = 0.0;
    depth[2] = f32::NAN;
    Picture {
        width,
        height,
        beauty: noisy(width, height, 1),
        variance: Some(noisy(width, height, 2)),
        albedo: Some(vec![[0.25, 0.5, 1.0]; count]),
        normal: Some(vec![[0.0, -1.0, 0.5]; count]),
        depth: Some(depth),
        sample_count: (0..count)
            .map(|i| 64 + (i % 2) as u32 * (1 << 25))
            .collect(),
    }
}
