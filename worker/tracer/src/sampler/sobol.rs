//! Four dimensions of Sobol's sequence, index-shuffled and Owen-scrambled.

/// Bit-reversed Sobol points by the bytes of the index: the point of `i` is the
/// XOR of `TABLE[k][byte k of i]`. Reversed, because the scramble works from the
/// lowest bit up. Dimension 0 is the identity (van der Corput, reversed).
static TABLE: [[[u32; 4]; 256]; 4] = make_table();

/// Direction numbers of dimensions 1 to 3: degree, coefficients of the primitive
/// polynomial, first odd numbers m (Joe and Kuo 2008, new-joe-kuo-6).
const PARAMETERS: [(usize, u32, [u32; 3]); 3] =
    [(1, 0, [1, 0, 0]), (2, 1, [1, 3, 0]), (3, 1, [1, 3, 1])];

const fn direction_numbers(dimension: usize) -> [u32; 32] {
    let mut v = [0u32; 32];
    if dimension == 0 {
        let mut i = 0;
        while i < 32 {
            v[i] = 1 << (31 - i);
            i += 1;
        }
        return v;
    }
    let (degree, coefficients, first) = PARAMETERS[dimension - 1];
    let mut i = 0;
    while i < 32 {
        if i < degree {
            v[i] = first[i] << (31 - i);
        } else {
            let mut x = v[i - degree] ^ (v[i - degree] >> degree);
            let mut k = 1;
            while k < degree {
                if (coefficients >> (degree - 1 - k)) & 1 == 1 {
                    x ^= v[i - k];
                }
                k += 1;
            }
            v[i] = x;
        }
        i += 1;
    }
    v
}

const fn make_table() -> [[[u32; 4]; 256]; 4] {
    let mut table = [[[0u32; 4]; 256]; 4];
    let mut dimension = 0;
    while dimension < 4 {
        let directions = direction_numbers(dimension);
        let mut byte = 0;
        while byte < 4 {
            let mut value = 0;
            while value < 256 {
                let mut x = 0u32;
                let mut bit = 0;
                while bit < 8 {
                    if (value >> bit) & 1 == 1 {
                        x ^= directions[8 * byte + bit];
                    }
                    bit += 1;
                }
                table[byte][value][dimension] = x.reverse_bits();
                value += 1;
            }
            byte += 1;
        }
        dimension += 1;
    }
    table
}

// A permutation in which each bit depends on the bits below it only: on
// reversed numbers that is Owen's nested scramble. Constants by N. Vegdahl
// (2021, "Building a better LK hash"), in the form of Laine and Karras (2011).
#[inline]
fn nested_permutation(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x
}

/// Point `index` of a four-dimensional Sobol sequence whose order is shuffled by
/// `shuffle_seed` and whose dimensions are scrambled by four seeds derived from
/// `scramble_seed`; 32-bit fractions. Any aligned power-of-two range of indices is
/// an Owen-scrambled net (Burley 2020).
#[inline]
#[must_use]
pub fn sobol4_owen(index: u32, shuffle_seed: u32, scramble_seed: u32) -> [u32; 4] {
    let i = nested_permutation(index.reverse_bits(), shuffle_seed).reverse_bits();
    let (a, b) = (
        &TABLE[0][(i & 255) as usize],
        &TABLE[1][(i >> 8 & 255) as usize],
    );
    let (c, d) = (
        &TABLE[2][(i >> 16 & 255) as usize],
        &TABLE[3][(i >> 24) as usize],
    );
    let mut seed = scramble_seed;
    std::array::from_fn(|k| {
        seed = seed.wrapping_mul(0x2c1b_3c6d).wrapping_add(0x297a_2d39);
        nested_permutation(a[k] ^ b[k] ^ c[k] ^ d[k], seed ^ (seed >> 15)).reverse_bits()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    // A (0, 2)-sequence in its first two dimensions: 2^m points lie one in each
    // elementary interval, for every shape; scrambling must keep that.
    #[test]
    fn first_two_dimensions_are_a_net_for_every_scramble() {
        for seed in 0..8u32 {
            let points: Vec<_> = (0..256)
                .map(|i| sobol4_owen(i, seed.wrapping_mul(77), seed ^ 0xABCD))
                .collect();
            for bits_x in 0..=8u32 {
                let mut seen = [0u8; 256];
                for p in &points {
                    let x = if bits_x == 0 {
                        0
                    } else {
                        p[0] >> (32 - bits_x)
                    };
                    let y = if bits_x == 8 {
                        0
                    } else {
                        p[1] >> (24 + bits_x)
                    };
                    seen[((x << (8 - bits_x)) | y) as usize] += 1;
                }
                assert!(
                    seen.iter().all(|&n| n == 1),
                    "seed {seed}, {bits_x} bits of x"
                );
            }
        }
    }

    // Every dimension alone is stratified in every aligned block.
    #[test]
    fn each_dimension_is_stratified_in_aligned_blocks() {
        for block in [0u32, 3, 1 << 20] {
            for dimension in 0..4 {
                let mut seen = [0u8; 64];
                for i in 0..64 {
                    seen[(sobol4_owen(block * 64 + i, 9, 5)[dimension] >> 26) as usize] += 1;
                }
                assert!(
                    seen.iter().all(|&n| n == 1),
                    "block {block}, dimension {dimension}"
                );
            }
        }
    }

    // Independent scrambles: the correlation of two sequences' errors is
    // statistically zero; here of their first points over many seeds.
    #[test]
    fn scrambles_are_independent() {
        let n = 20_000u32;
        for dimension in 0..4 {
            let mut sum = 0.0;
            for s in 0..n {
                let value = |seed| {
                    f64::from(sobol4_owen(0, seed, seed ^ 0x1234)[dimension]) / 4_294_967_296.0
                        - 0.5
                };
                sum += value(crate::math::hash::mix32(2 * s))
                    * value(crate::math::hash::mix32(2 * s + 1));
            }
            // Standard deviation of the mean product is (1/12) / sqrt(n); 5 sigma.
            let limit = 5.0 / 12.0 / f64::from(n).sqrt();
            assert!(
                (sum / f64::from(n)).abs() < limit,
                "dimension {dimension}: {}",
                sum / f64::from(n)
            );
        }
    }
}
