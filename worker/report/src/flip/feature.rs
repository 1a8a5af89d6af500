//! Edges and points: where they differ, a difference is noticed more (2020,
//! section 4.2).

use super::separable::{along_columns, along_rows};

/// Width of an edge that the eye detects, in degrees.
const EDGE_WIDTH_DEG: f32 = 0.082;

/// Weights of each tap: Gaussian, its first and its second derivative.
pub(super) struct FeatureFilter {
    radius: usize,
    taps: Vec<[f32; 3]>,
}

/// Lengths of the gradient and of the second derivatives at a pixel.
#[derive(Clone, Copy)]
pub(super) struct Features {
    pub(super) edge: f32,
    pub(super) point: f32,
}

impl FeatureFilter {
    /// For a screen of `ppd` pixels per degree.
    pub(super) fn new(ppd: f32) -> Self {
        let sigma = 0.5 * EDGE_WIDTH_DEG * ppd;
        let radius = (3.0 * sigma).ceil() as usize;
        let mut taps: Vec<[f32; 3]> = (0..=2 * radius)
            .map(|tap| {
                let x = tap as f32 - radius as f32;
                let g = libm::expf(-x * x / (2.0 * sigma * sigma));
                [g, -x * g, (x * x / (sigma * sigma) - 1.0) * g]
            })
            .collect();
        // Positive and negative weights sum to 1 and -1 each.
        let sums = [0, 1, 2].map(|c| {
            let of = |sign: f32| taps.iter().map(|t| (sign * t[c]).max(0.0)).sum::<f32>();
            [of(1.0), of(-1.0)]
        });
        for tap in &mut taps {
            *tap = [0, 1, 2].map(|c| match tap[c] {
                w if w > 0.0 => w / sums[c][0],
                w if w < 0.0 => w / sums[c][1],
                _ => 0.0,
            });
        }
        Self { radius, taps }
    }

    /// Features of a picture in YCxCz; only Y takes part.
    pub(super) fn apply(&self, size: (usize, usize), ycxcz: &[[f32; 3]]) -> Vec<Features> {
        let taps = &self.taps;
        let rows = along_rows(size, ycxcz, self.radius, |tap, [y, _, _]: [f32; 3]| {
            let grey = (y + 16.0) / 116.0;
            taps[tap].map(|w| w * grey)
        });
        let both = along_columns(size, &rows, self.radius, |tap, [g, d, dd]: [f32; 3]| {
            let [wg, wd, wdd] = taps[tap];
            [wg * d, wg * dd, wd * g, wdd * g]
        });
        let length = |a: f32, b: f32| (a * a + b * b).sqrt();
        both.into_iter()
            .map(|[dx, ddx, dy, ddy]| Features {
                edge: length(dx, dy),
                point: length(ddx, ddy),
            })
            .collect()
    }
}
