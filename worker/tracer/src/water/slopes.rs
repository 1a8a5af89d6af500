//! Slopes with their own mip levels: mean slope and the variance that the mean
//! has lost, so that far water keeps its brightness instead of aliasing.

use super::HeightField;
use glam::Vec2;

/// Levels of a slope map; level 0 is the grid itself.
#[derive(Clone, Debug)]
pub struct SlopeMap {
    levels: Vec<Level>,
    /// Variance per axis of the whole field, for footprints beyond the tile.
    total_variance: f32,
}

#[derive(Clone, Debug)]
struct Level {
    n: usize,
    // Where texel 0 lies, in texels: the grid's points are at whole positions, and
    // a mean of 2 x 2 lies in their middle.
    first: f32,
    // slope x, slope z, lost variance per axis, and nothing: 16 bytes a texel.
    texels: Vec<[f32; 4]>,
}

/// A filtered slope.
#[derive(Clone, Copy, Debug)]
pub struct Slopes {
    /// Mean (dh/dx, dh/dz) over the footprint.
    pub slope: Vec2,
    /// Mean variance of the slope per axis inside the footprint.
    pub variance: f32,
}

impl SlopeMap {
    /// Levels by averaging 2 x 2 texels. The variance that is lost is the mean of
    /// the squares less the square of the mean, summed down the levels in f64.
    #[must_use]
    pub fn new(field: &HeightField) -> Self {
        let mut n = field.n;
        // Mean slope x, mean slope z, mean of squared slope length.
        let mut moments: Vec<[f64; 3]> = field
            .slope_x
            .iter()
            .zip(&field.slope_z)
            .map(|(&x, &z)| [x, z, x * x + z * z])
            .collect();
        let mut levels = Vec::new();
        loop {
            let first = 0.5 - 0.5 * n as f32 / field.n as f32;
            levels.push(Level {
                n,
                first,
                texels: moments.iter().map(texel).collect(),
            });
            if n == 1 {
                break;
            }
            moments = halve(&moments, n);
            n /= 2;
        }
        let total_variance = moments.first().map_or(0.0, |m| texel(m)[2]);
        Self {
            levels,
            total_variance,
        }
    }

    /// Slope at `tile` (in tiles, any value; it wraps), over a footprint of
    /// `width` tiles.
    #[inline]
    #[must_use]
    pub fn lookup(&self, tile: Vec2, width: f32) -> Slopes {
        let base = self.levels[0].n as f32;
        let texels = width * base;
        // Beyond the tile there is only its variance; this also takes infinities.
        if texels < base {
            let level = if texels > 1.0 { level_of(texels) } else { 0 };
            let fraction = if texels > 1.0 {
                texels / (1u32 << level) as f32 - 1.0
            } else {
                0.0
            };
            let fine = self.bilinear(level, tile);
            if fraction <= 0.0 {
                return slopes(fine);
            }
            let coarse = self.bilinear(level + 1, tile);
            return slopes(std::array::from_fn(|i| {
                fine[i] + (coarse[i] - fine[i]) * fraction
            }));
        }
        Slopes {
            slope: Vec2::ZERO,
            variance: self.total_variance,
        }
    }

    #[inline]
    fn bilinear(&self, level: usize, tile: Vec2) -> [f32; 4] {
        let Level { n, first, texels } = &self.levels[level.min(self.levels.len() - 1)];
        let (x, fx) = wrap(tile.x, *n, *first);
        let (z, fz) = wrap(tile.y, *n, *first);
        let (x1, z1) = ((x + 1) & (n - 1), (z + 1) & (n - 1));
        let (a, b) = (&texels[z * n + x], &texels[z * n + x1]);
        let (c, d) = (&texels[z1 * n + x], &texels[z1 * n + x1]);
        std::array::from_fn(|i| {
            let near = a[i] + (b[i] - a[i]) * fx;
            let far = c[i] + (d[i] - c[i]) * fx;
            near + (far - near) * fz
        })
    }
}

#[inline]
fn slopes(t: [f32; 4]) -> Slopes {
    Slopes {
        slope: Vec2::new(t[0], t[1]),
        variance: t[2],
    }
}

// floor(log2) of a value above 1 and far below 2^31.
#[inline]
fn level_of(texels: f32) -> usize {
    (31 - (texels as u32).max(1).leading_zeros()) as usize
}

// Texel index and fraction of a periodic coordinate; n is a power of two.
#[inline]
fn wrap(tile: f32, n: usize, first: f32) -> (usize, f32) {
    // Far away the fraction has no digits left; stay within i32.
    let t = if tile.abs() < 1e5 { tile } else { 0.0 };
    let scaled = t * n as f32 - first;
    let whole = scaled as i32 - i32::from(scaled < 0.0);
    let fraction = (scaled - whole as f32).clamp(0.0, 1.0);
    ((whole & (n as i32 - 1)) as usize, fraction)
}

fn texel(m: &[f64; 3]) -> [f32; 4] {
    let lost = (m[2] - m[0] * m[0] - m[1] * m[1]).max(0.0) * 0.5;
    [m[0] as f32, m[1] as f32, lost as f32, 0.0]
}

fn halve(fine: &[[f64; 3]], n: usize) -> Vec<[f64; 3]> {
    let half = n / 2;
    let mut coarse = Vec::with_capacity(half * half);
    for z in 0..half {
        for x in 0..half {
            let at = |dx: usize, dz: usize| fine[(2 * z + dz) * n + 2 * x + dx];
            let four = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
            coarse.push(std::array::from_fn(|i| {
                four.iter().map(|m| m[i]).sum::<f64>() * 0.25
            }));
        }
    }
    coarse
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field() -> HeightField {
        let n = 64;
        let wave =
            |i: usize, f: f64| libm::sin(2.0 * std::f64::consts::PI * f * i as f64 / n as f64);
        let slope = |a: f64, b: f64| {
            (0..n * n)
                .map(|i| 0.1 * wave(i % n, a) + 0.05 * wave(i / n, b))
                .collect::<Vec<_>>()
        };
        HeightField {
            n,
            tile_m: 64.0,
            height: vec![0.0; n * n],
            slope_x: slope(3.0, 7.0),
            slope_z: slope(16.0, 2.0),
        }
    }

    // What the mean loses the variance gains: total second moment per level.
    #[test]
    fn every_level_keeps_the_second_moment() {
        let map = SlopeMap::new(&field());
        let moment = |level: &Level| {
            let sum: f64 = level
                .texels
                .iter()
                .map(|t| f64::from(t[0] * t[0] + t[1] * t[1] + 2.0 * t[2]))
                .sum();
            sum / level.texels.len() as f64
        };
        let first = moment(&map.levels[0]);
        for level in &map.levels {
            assert!(
                (moment(level) / first - 1.0).abs() < 1e-5,
                "level of {}",
                level.n
            );
        }
        assert!((f64::from(map.total_variance) * 2.0 / first - 1.0).abs() < 1e-5);
    }

    #[test]
    fn lookups_are_periodic_and_continuous() {
        let map = SlopeMap::new(&field());
        for (x, z) in [(0.3, 0.7), (0.0, 0.0), (0.999, 0.01)] {
            let (a, b) = (
                map.lookup(Vec2::new(x, z), 0.0),
                map.lookup(Vec2::new(x + 3.0, z - 2.0), 0.0),
            );
            assert!((a.slope - b.slope).length() < 1e-5, "{x} {z}");
        }
        let step = 1e-4;
        for i in 0..20_000 {
            let t = i as f32 * step;
            let (a, b) = (
                map.lookup(Vec2::new(t, 0.2), 0.02),
                map.lookup(Vec2::new(t + step, 0.2), 0.02),
            );
            assert!((a.slope - b.slope).length() < 0.01, "{t}");
        }
        for width in [0.5 / 64.0, 1.0 / 64.0, 2.0 / 64.0, 4.0 / 64.0, 0.999] {
            let at = |w: f32| map.lookup(Vec2::new(0.31, 0.64), w);
            assert!(
                (at(width * 0.999).slope - at(width * 1.001).slope).length() < 1e-3,
                "{width}"
            );
        }
    }

    #[test]
    fn any_number_is_answered() {
        let map = SlopeMap::new(&field());
        for v in [f32::NAN, f32::INFINITY, -f32::INFINITY, 1e30, -1e30] {
            let s = map.lookup(Vec2::new(v, v), 0.01);
            assert!(s.slope.is_finite() && s.variance.is_finite());
            let s = map.lookup(Vec2::new(0.1, 0.1), v);
            assert!(s.slope.is_finite() && s.variance.is_finite());
        }
    }
}
