//! Slopes with their own mip levels: mean slope and the variance that the mean
//! has lost, so that far water keeps its brightness instead of aliasing.

use glam::Vec2;

/// Levels of a slope map; level 0 is the grid itself.
#[derive(Clone, Debug)]
pub struct SlopeMap {
    levels: Vec<Level>,
    /// The mean of the whole field, for footprints beyond the tile.
    whole: [f32; 4],
}

#[derive(Clone, Debug)]
struct Level {
    n: usize,
    // Where texel 0 lies, in texels: the grid's points are at whole positions, and
    // a mean of 2 x 2 lies in their middle.
    first: f32,
    // slope x, slope z, lost variance per axis, foam: 16 bytes a texel.
    texels: Vec<[f32; 4]>,
}

/// A filtered slope.
#[derive(Clone, Copy, Debug)]
pub struct Slopes {
    /// Mean (dh/dx, dh/dz) over the footprint.
    pub slope: Vec2,
    /// Mean variance of the slope per axis inside the footprint.
    pub variance: f32,
    /// Share of the footprint that is under foam.
    pub foam: f32,
}

impl Slopes {
    /// Linear interpolation, `share` of the way to `other`.
    #[inline]
    #[must_use]
    pub fn towards(self, other: Self, share: f32) -> Self {
        let mix = |a: f32, b: f32| a + (b - a) * share;
        Self {
            slope: self.slope + (other.slope - self.slope) * share,
            variance: mix(self.variance, other.variance),
            foam: mix(self.foam, other.foam),
        }
    }
}

impl SlopeMap {
    /// Levels of n x n slopes by averaging 2 x 2 texels, n a power of two. The
    /// variance that is lost is the mean of the squares less the square of the mean,
    /// summed down the levels in f64. `foam` is the coverage with whitecaps, one
    /// value a texel, or empty.
    #[must_use]
    pub fn new(n: usize, slope_x: &[f32], slope_z: &[f32], foam: &[f32]) -> Self {
        let slopes = slope_x.iter().zip(slope_z);
        let foam = foam.iter().chain(std::iter::repeat(&0.0));
        let texels: Vec<[f32; 4]> = slopes
            .zip(foam)
            .map(|((&x, &z), &f)| [x, z, 0.0, f])
            .collect();
        let mut moments = halve(&texels, n, |&[x, z, _, foam]| {
            let (x, z) = (f64::from(x), f64::from(z));
            [x, z, x * x + z * z, f64::from(foam)]
        });
        let mut levels = vec![Level {
            n,
            first: 0.0,
            texels,
        }];
        let mut coarse = n / 2;
        while coarse > 0 {
            levels.push(Level {
                n: coarse,
                first: 0.5 - 0.5 * coarse as f32 / n as f32,
                texels: moments.iter().map(texel).collect(),
            });
            moments = halve(&moments, coarse, |m| *m);
            coarse /= 2;
        }
        let whole = levels.last().and_then(|level| level.texels.first());
        Self {
            whole: whole.copied().unwrap_or_default(),
            levels,
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
        slopes(self.whole)
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
        foam: t[3],
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
    // The floor, also of negative whole numbers: a tile further must be the same bits.
    let whole = scaled as i32;
    let whole = whole - i32::from(whole as f32 > scaled);
    let fraction = (scaled - whole as f32).clamp(0.0, 1.0);
    ((whole & (n as i32 - 1)) as usize, fraction)
}

fn texel(m: &[f64; 4]) -> [f32; 4] {
    let lost = (m[2] - m[0] * m[0] - m[1] * m[1]).max(0.0) * 0.5;
    [m[0] as f32, m[1] as f32, lost as f32, m[3] as f32]
}

// Means over 2 x 2 of the moments that `read` makes of an entry; n is the side of
// the finer level. Nothing comes of a single entry.
fn halve<T>(fine: &[T], n: usize, read: impl Fn(&T) -> [f64; 4]) -> Vec<[f64; 4]> {
    let mut coarse = Vec::with_capacity(n * n / 4);
    for rows in fine.chunks_exact(2 * n) {
        let (upper, lower) = rows.split_at(n);
        for (above, below) in upper.chunks_exact(2).zip(lower.chunks_exact(2)) {
            let (a, b, c, d) = (
                read(&above[0]),
                read(&above[1]),
                read(&below[0]),
                read(&below[1]),
            );
            coarse.push(std::array::from_fn(|i| (a[i] + b[i] + c[i] + d[i]) * 0.25));
        }
    }
    coarse
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map() -> SlopeMap {
        let n = 64;
        let wave =
            |i: usize, f: f64| libm::sin(2.0 * std::f64::consts::PI * f * i as f64 / n as f64);
        let slope = |a: f64, b: f64| {
            (0..n * n)
                .map(|i| (0.1 * wave(i % n, a) + 0.05 * wave(i / n, b)) as f32)
                .collect::<Vec<_>>()
        };
        SlopeMap::new(n, &slope(3.0, 7.0), &slope(16.0, 2.0), &[])
    }

    // What the mean loses the variance gains: total second moment per level.
    #[test]
    fn every_level_keeps_the_second_moment() {
        let map = map();
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
        assert!((f64::from(map.whole[2]) * 2.0 / first - 1.0).abs() < 1e-5);
    }

    #[test]
    fn lookups_are_periodic_and_continuous() {
        let map = map();
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
        let map = map();
        for v in [f32::NAN, f32::INFINITY, -f32::INFINITY, 1e30, -1e30] {
            let s = map.lookup(Vec2::new(v, v), 0.01);
            assert!(s.slope.is_finite() && s.variance.is_finite());
            let s = map.lookup(Vec2::new(0.1, 0.1), v);
            assert!(s.slope.is_finite() && s.variance.is_finite());
        }
    }
}
