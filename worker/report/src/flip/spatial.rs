//! What the eye cannot resolve is blurred away: contrast sensitivity as Gaussians
//! (2020, section 4.1 and table 1).

use super::separable::{along_columns, along_rows};

/// One Gaussian a sqrt(pi / b) exp(-(pi x)^2 / b), x in degrees.
#[derive(Clone, Copy)]
struct Term {
    a: f32,
    b: f32,
}

const LUMA: Term = Term { a: 1.0, b: 0.0047 };
const RED_GREEN: Term = Term { a: 1.0, b: 0.0053 };
const BLUE_YELLOW: [Term; 2] = [Term { a: 34.1, b: 0.04 }, Term { a: 13.5, b: 0.025 }];

/// Weights of each tap for Y, Cx and the two terms of Cz.
pub(super) struct SpatialFilter {
    radius: usize,
    taps: Vec<[f32; 4]>,
}

impl SpatialFilter {
    /// For a screen of `ppd` pixels per degree.
    pub(super) fn new(ppd: f32) -> Self {
        const PI: f32 = std::f32::consts::PI;
        // Three standard deviations of the widest term.
        let radius = (3.0 * (BLUE_YELLOW[0].b / (2.0 * PI * PI)).sqrt() * ppd).ceil() as usize;
        let gauss = |x: f32, term: Term| libm::expf(-PI * PI * x * x / term.b);
        // A sum of two Gaussians does not separate, but each does: the weight of
        // one axis is the square root of its height.
        let height = |term: Term| (term.a * (PI / term.b).sqrt()).sqrt();
        let mut taps: Vec<[f32; 4]> = (0..=2 * radius)
            .map(|tap| {
                let x = (tap as f32 - radius as f32) / ppd;
                let [wide, narrow] = BLUE_YELLOW.map(|term| height(term) * gauss(x, term));
                [gauss(x, LUMA), gauss(x, RED_GREEN), wide, narrow]
            })
            .collect();
        let sum = |c: usize| taps.iter().map(|tap| tap[c]).sum::<f32>();
        let blue = (sum(2) * sum(2) + sum(3) * sum(3)).sqrt();
        let norm = [sum(0), sum(1), blue, blue];
        for tap in &mut taps {
            *tap = [0, 1, 2, 3].map(|c| tap[c] / norm[c]);
        }
        Self { radius, taps }
    }

    /// Blur a picture in YCxCz.
    pub(super) fn apply(&self, size: (usize, usize), ycxcz: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let taps = &self.taps;
        let rows = along_rows(size, ycxcz, self.radius, |tap, [y, cx, cz]: [f32; 3]| {
            let w = taps[tap];
            [w[0] * y, w[1] * cx, w[2] * cz, w[3] * cz]
        });
        let both = along_columns(size, &rows, self.radius, |tap, v: [f32; 4]| {
            let w = taps[tap];
            [0, 1, 2, 3].map(|c| w[c] * v[c])
        });
        let join = |[y, cx, wide, narrow]: [f32; 4]| [y, cx, wide + narrow];
        both.into_iter().map(join).collect()
    }
}
