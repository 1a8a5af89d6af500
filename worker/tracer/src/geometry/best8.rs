//! The best hits of a packet.

use super::kernels::Best;
use super::ray::rank;

/// The best hits of eight rays.
pub(super) struct Best8 {
    pub(super) t: [f32; 8],
    pub(super) rank: [u64; 8],
    pub(super) v: [f32; 8],
    pub(super) w: [f32; 8],
    pub(super) det: [f32; 8],
}

impl Best8 {
    #[inline(always)]
    /// Nothing yet; `t_max(lane)` is the end of a ray.
    pub(super) fn new(t_max: impl Fn(usize) -> f32) -> Self {
        let t = std::array::from_fn(|lane| Best::new(t_max(lane)).t);
        Self {
            t,
            rank: [rank::NOTHING; 8],
            v: [0.0; 8],
            w: [0.0; 8],
            det: [1.0; 8],
        }
    }

    #[inline(always)]
    pub(super) fn lane(&self, lane: usize) -> Best {
        let mut best = Best::new(0.0);
        best.set(self.t[lane], self.rank[lane]);
        (best.v, best.w, best.det) = (self.v[lane], self.w[lane], self.det[lane]);
        best
    }

    #[inline(always)]
    pub(super) fn set_lane(&mut self, lane: usize, best: &Best) {
        (self.t[lane], self.rank[lane]) = (best.t, best.rank);
        (self.v[lane], self.w[lane], self.det[lane]) = (best.v, best.w, best.det);
    }

    #[inline(always)]
    pub(super) fn is_beaten_by(&self, lane: usize, t: f32, rank: u64) -> bool {
        t < self.t[lane] || (t == self.t[lane] && rank < self.rank[lane])
    }
}
