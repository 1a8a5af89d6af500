//! Silhouettes of clouds as pictures: bright where a cloud is dense, black where
//! there is none.

use crate::curve::smoothstep;
use crate::noise::{fbm, hash3, unit};

/// Columns of a picture.
pub const WIDTH: u32 = 256;
/// Rows of a picture.
pub const HEIGHT: u32 = 128;

/// A heap of puffs on a flat base. Lengths are shares of the picture's height;
/// x runs from 0 to 2, y from 0 at the bottom to 1.
pub struct Silhouette {
    /// Height of the base.
    base: f64,
    /// Domes under whose outline the puffs lie: middle, half width, height.
    domes: &'static [[f64; 3]],
    /// Number of puffs.
    puffs: i32,
    /// Smallest and largest radius of a puff.
    radii: [f64; 2],
    /// How much noise tears the rims.
    torn: f64,
    seed: u32,
}

/// A fair-weather cumulus: a broad heap with a higher crown.
pub const CUMULUS: Silhouette = Silhouette {
    base: 0.14,
    domes: &[[0.95, 0.82, 0.42], [0.78, 0.42, 0.76], [1.35, 0.36, 0.55]],
    puffs: 90,
    radii: [0.07, 0.19],
    torn: 0.75,
    seed: 71,
};

/// A row of towers of different height.
pub const TOWERS: Silhouette = Silhouette {
    base: 0.10,
    domes: &[
        [0.42, 0.26, 0.52],
        [0.98, 0.30, 0.92],
        [1.50, 0.24, 0.66],
        [1.0, 0.88, 0.24],
    ],
    puffs: 110,
    radii: [0.06, 0.15],
    torn: 0.75,
    seed: 72,
};

impl Silhouette {
    /// Height of the outline over the base.
    fn outline(&self, x: f64) -> f64 {
        let dome = |&[middle, half, height]: &[f64; 3]| {
            let off = (x - middle) / half;
            height * libm::sqrt((1.0 - off * off).max(0.0))
        };
        self.domes.iter().map(dome).fold(0.0, f64::max)
    }

    /// Middle and radius of each puff.
    fn heap(&self) -> Vec<[f64; 3]> {
        let draw = |i: i32, what: i32| unit(hash3(i, what, 0, self.seed));
        (0..self.puffs)
            .map(|i| {
                let x = 0.1 + 1.8 * draw(i, 0);
                let top = self.outline(x);
                let wanted = self.radii[0] + (self.radii[1] - self.radii[0]) * draw(i, 1);
                let radius = wanted.min(0.5 * top);
                // Towards the outline: the square root leaves the base thinner.
                let room = (top - 1.6 * radius).max(0.0);
                let y = self.base + 0.6 * radius + room * libm::sqrt(draw(i, 2));
                [x, y, radius]
            })
            .filter(|puff| puff[2] > 0.02)
            .collect()
    }

    /// Grey sRGB texels, rows from the top, three bytes each.
    #[must_use]
    pub fn pixels(&self) -> Vec<u8> {
        let heap = self.heap();
        let mut out = Vec::with_capacity((WIDTH * HEIGHT * 3) as usize);
        for row in 0..HEIGHT {
            for column in 0..WIDTH {
                let x = (f64::from(column) + 0.5) / f64::from(HEIGHT);
                let y = 1.0 - (f64::from(row) + 0.5) / f64::from(HEIGHT);
                out.extend([srgb(self.density(&heap, x, y)); 3]);
            }
        }
        out
    }

    fn density(&self, heap: &[[f64; 3]], x: f64, y: f64) -> f64 {
        let (mut sum, mut most) = (0.0, 0.0_f64);
        for &[cx, cy, radius] in heap {
            let (dx, dy) = ((x - cx) / radius, (y - cy) / radius);
            let inside = (1.0 - dx * dx - dy * dy).max(0.0);
            sum += inside;
            most = most.max(inside);
        }
        let body = most + 0.2 * (sum - most);
        // Billows: noise folded at 0 has round tops and sharp clefts.
        let fold = |scale: f64, seed: u32| {
            let noise = fbm(x * scale, y * scale, 3.0, 4, 0.5, self.seed + seed);
            1.0 - (3.2 * noise.abs()).min(1.0)
        };
        let billow = 0.6 * fold(4.5, 0) + 0.4 * fold(11.0, 9);
        let rim = body - self.torn * (1.0 - billow);
        let flat = smoothstep(
            self.base - 0.04,
            self.base + 0.05,
            y + 0.05 * (billow - 0.5),
        );
        smoothstep(0.0, 0.9, rim) * (0.25 + 0.75 * billow) * flat
    }
}

/// 8-bit sRGB of linear light (IEC 61966-2-1).
fn srgb(linear: f64) -> u8 {
    let value = if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055
    };
    (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}
