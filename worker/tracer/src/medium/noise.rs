//! Fractal gradient noise from integer hashes: equal bits everywhere.

use crate::math::hash::{hash_combine64, mix64};
use glam::DVec3;

/// Sum of octaves of gradient noise, fBm (Perlin 1985 and 2002; Musgrave 1989).
#[derive(Clone, Copy, Debug)]
pub(super) struct Fbm {
    pub(super) octaves: u32,
    pub(super) lacunarity: f64,
    pub(super) gain: f64,
    pub(super) seed: u64,
}

/// The standard deviation of one octave, about; measured by the test below.
const OCTAVE_DEVIATION: f64 = 0.27;

impl Fbm {
    /// Noise at `p`, of deviation about 1 whatever the octaves; lumps of the first
    /// have size 1.
    pub(super) fn at(&self, p: DVec3) -> f64 {
        let (mut sum, mut power) = (0.0, 0.0);
        let (mut strength, mut fineness) = (1.0, 1.0);
        for octave in 0..self.octaves {
            let key = hash_combine64(self.seed, octave.into());
            sum += strength * gradient_noise(p * fineness, key);
            power += strength * strength;
            strength *= self.gain;
            fineness *= self.lacunarity;
        }
        sum / (power.sqrt() * OCTAVE_DEVIATION)
    }
}

// Perlin's noise with the quintic fade and his twelve gradients, by a hash instead
// of his table. Within -1 to 1.
fn gradient_noise(p: DVec3, key: u64) -> f64 {
    let cell = DVec3::new(libm::floor(p.x), libm::floor(p.y), libm::floor(p.z));
    let f = p - cell;
    let fade = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let [x, y, z] = [cell.x as i64, cell.y as i64, cell.z as i64];
    // A hash of the corner's coordinates, folded in one after the other.
    let columns = [0, 1].map(|dx| mix64(key ^ x.wrapping_add(dx) as u64));
    let corner = |dx: usize, dy: i64, dz: i64| {
        let row = mix64(columns[dx].rotate_left(21) ^ y.wrapping_add(dy) as u64);
        let hash = mix64(row.rotate_left(21) ^ z.wrapping_add(dz) as u64);
        gradient(hash, f - DVec3::new(dx as f64, dy as f64, dz as f64))
    };
    let lerp = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let along_x = |dy: i64, dz: i64| lerp(corner(0, dy, dz), corner(1, dy, dz), fade.x);
    let along_y = |dz: i64| lerp(along_x(0, dz), along_x(1, dz), fade.y);
    lerp(along_y(0), along_y(1), fade.z)
}

// Towards the middle of one of a cube's twelve edges.
fn gradient(hash: u64, d: DVec3) -> f64 {
    // 64 bits over 12 edges: uneven by 1e-18.
    let edge = ((u128::from(hash) * 12) >> 64) as u32;
    let (a, b) = match edge >> 2 {
        0 => (d.x, d.y),
        1 => (d.x, d.z),
        _ => (d.y, d.z),
    };
    (if edge & 1 == 0 { a } else { -a }) + (if edge & 2 == 0 { b } else { -b })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fbm(octaves: u32, seed: u64) -> Fbm {
        Fbm {
            octaves,
            lacunarity: 2.0,
            gain: 0.5,
            seed,
        }
    }

    fn points() -> impl Iterator<Item = DVec3> {
        (0..20_000).map(|i| DVec3::new(0.37, 0.613, -0.291) * f64::from(i))
    }

    #[test]
    fn noise_has_mean_zero_and_deviation_one() {
        for (octaves, seed) in [(1, 1), (5, 2)] {
            let noise = fbm(octaves, seed);
            let n = points().count() as f64;
            let mean = points().map(|p| noise.at(p)).sum::<f64>() / n;
            let square = points().map(|p| noise.at(p) * noise.at(p)).sum::<f64>() / n;
            assert!(mean.abs() < 0.05, "{octaves}: {mean}");
            assert!((square.sqrt() - 1.0).abs() < 0.1, "{octaves}: {square}");
        }
    }

    #[test]
    fn noise_is_continuous_across_cells_and_zero_on_the_lattice() {
        let noise = fbm(1, 3);
        for p in points().take(500) {
            let wall = DVec3::new(libm::floor(p.x), p.y, p.z);
            let step = DVec3::new(1e-9, 0.0, 0.0);
            assert!((noise.at(wall - step) - noise.at(wall + step)).abs() < 1e-7);
            let corner = DVec3::new(libm::floor(p.x), libm::floor(p.y), libm::floor(p.z));
            assert_eq!(noise.at(corner), 0.0);
        }
    }

    #[test]
    fn seeds_differ() {
        let p = DVec3::new(0.3, 0.4, 0.5);
        assert_ne!(fbm(3, 1).at(p), fbm(3, 2).at(p));
    }
}
