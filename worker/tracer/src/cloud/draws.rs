//! The random numbers of a cloud.

use crate::math::hash::mix64;
use glam::DVec3;
use std::f64::consts::PI;

/// Uniform numbers of one particle: a hash of (seed, particle, counter).
pub(super) struct Draws {
    key: u64,
    counter: u64,
}

impl Draws {
    pub(super) fn new(seed: u64, index: u32) -> Self {
        Self {
            key: mix64(seed ^ mix64(u64::from(index) ^ 0xC10D_5EED)),
            counter: 0,
        }
    }

    /// 64 random bits.
    pub(super) fn bits(&mut self) -> u64 {
        self.counter += 1;
        mix64(self.key ^ self.counter)
    }

    /// Uniform in [0, 1).
    pub(super) fn next(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / 9_007_199_254_740_992.0
    }

    /// Uniform in the ball of radius 1.
    pub(super) fn in_unit_ball(&mut self) -> DVec3 {
        let y = 1.0 - 2.0 * self.next();
        let angle = 2.0 * PI * self.next();
        let ring = libm::sqrt((1.0 - y * y).max(0.0));
        let radius = libm::cbrt(self.next());
        DVec3::new(ring * libm::cos(angle), y, ring * libm::sin(angle)) * radius
    }
}
