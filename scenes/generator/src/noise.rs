//! Integer-seeded noise: a hash of lattice points, gradients on it, and sums
//! of octaves. No state, no tables, no platform mathematics.

/// A well mixed 32-bit hash of three lattice coordinates and a seed
/// (the finaliser is the "lowbias32" of Chris Wellons' hash-prospector).
#[must_use]
pub fn hash3(x: i32, y: i32, z: i32, seed: u32) -> u32 {
    let mut h = seed ^ 0x9e37_79b9;
    for word in [x, y, z] {
        h = mix32(h ^ word.cast_unsigned());
        h = h.wrapping_mul(0x85eb_ca6b).wrapping_add(0xc2b2_ae35);
    }
    mix32(h)
}

fn mix32(mut h: u32) -> u32 {
    h ^= h >> 16;
    h = h.wrapping_mul(0x7feb_352d);
    h ^= h >> 15;
    h = h.wrapping_mul(0x846c_a68b);
    h ^ (h >> 16)
}

/// Uniform number in [0, 1) from a hash.
#[must_use]
pub fn unit(hash: u32) -> f64 {
    f64::from(hash) / 4_294_967_296.0
}

/// Gradient noise in about [-1, 1], smooth to the second derivative
/// (Perlin, "Improving Noise", 2002: the quintic and the twelve gradients).
#[must_use]
pub fn gradient(x: f64, y: f64, z: f64, seed: u32) -> f64 {
    let (fx, fy, fz) = (x.floor(), y.floor(), z.floor());
    let (ix, iy, iz) = (fx as i32, fy as i32, fz as i32);
    let (dx, dy, dz) = (x - fx, y - fy, z - fz);
    let (u, v, w) = (fade(dx), fade(dy), fade(dz));
    let corner = |i: i32, j: i32, k: i32| {
        lattice_slope(
            hash3(
                ix.wrapping_add(i),
                iy.wrapping_add(j),
                iz.wrapping_add(k),
                seed,
            ),
            dx - f64::from(i),
            dy - f64::from(j),
            dz - f64::from(k),
        )
    };
    let row = |j: i32, k: i32| {
        let a = corner(0, j, k);
        a + (corner(1, j, k) - a) * u
    };
    let plane = |k: i32| {
        let a = row(0, k);
        a + (row(1, k) - a) * v
    };
    let a = plane(0);
    a + (plane(1) - a) * w
}

fn fade(t: f64) -> f64 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

fn lattice_slope(hash: u32, x: f64, y: f64, z: f64) -> f64 {
    let (a, b) = match (hash >> 2) % 3 {
        0 => (x, y),
        1 => (x, z),
        _ => (y, z),
    };
    (if hash & 1 == 0 { a } else { -a }) + (if hash & 2 == 0 { b } else { -b })
}

/// Fractal sum of `octaves` octaves, each twice as fine and `gain` as high;
/// scaled so that the result stays in about [-1, 1].
#[must_use]
pub fn fbm(x: f64, y: f64, z: f64, octaves: u32, gain: f64, seed: u32) -> f64 {
    let (mut sum, mut height, mut total, mut scale) = (0.0, 1.0, 0.0, 1.0);
    for octave in 0..octaves {
        // An offset per octave keeps the lattice points from lining up at 0.
        let shift = f64::from(octave) * 17.31;
        sum += height
            * gradient(
                x * scale + shift,
                y * scale - shift,
                z * scale,
                seed.wrapping_add(octave),
            );
        total += height;
        height *= gain;
        scale *= 2.03;
    }
    if total > 0.0 { sum / total } else { 0.0 }
}
