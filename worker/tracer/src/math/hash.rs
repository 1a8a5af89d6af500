//! Counter-based hashes: random numbers as a pure function of what they are
//! for. No generator state survives a sample.

/// 2^-24, the spacing of [`u32_to_unit`].
const UNIT_STEP: f32 = 1.0 / 16_777_216.0;
/// 2^32 / golden ratio, odd: spreads small integers over all bits.
const GOLDEN_32: u32 = 0x9e37_79b9;
/// The same for 64 bits (Steele, Lea and Flood 2014, "SplitMix").
const GOLDEN_64: u64 = 0x9e37_79b9_7f4a_7c15;

/// A bijection of 32 bits in which every input bit flips every output bit with
/// probability close to 1/2 (xorshift-multiply; constants found by search,
/// Wellons 2018, "Prospecting for hash functions"). `mix32(0) == 0`.
#[inline]
#[must_use]
pub const fn mix32(v: u32) -> u32 {
    let v = (v ^ (v >> 16)).wrapping_mul(0x21f0_aaad);
    let v = (v ^ (v >> 15)).wrapping_mul(0x735a_2d97);
    v ^ (v >> 15)
}

/// A bijection of 64 bits (Stafford's variant 13 of the Murmur3 finaliser).
/// `mix64(0) == 0`.
#[inline]
#[must_use]
pub const fn mix64(v: u64) -> u64 {
    let v = (v ^ (v >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let v = (v ^ (v >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    v ^ (v >> 31)
}

/// Folds one more 32-bit key into `seed`. Order matters; for a fixed seed it is
/// a bijection of the value, and for a fixed value one of the seed.
#[inline]
#[must_use]
pub const fn hash_combine(seed: u32, value: u32) -> u32 {
    // The odd constant keeps (0, 0) from being a fixed point, and rotating the
    // seed makes the pair ordered.
    mix32(seed.rotate_left(13).wrapping_add(0x85eb_ca6b) ^ mix32(value.wrapping_add(GOLDEN_32)))
}

/// Folds one more 64-bit key into `seed`; properties as [`hash_combine`].
#[inline]
#[must_use]
pub const fn hash_combine64(seed: u64, value: u64) -> u64 {
    mix64(seed.rotate_left(29).wrapping_add(GOLDEN_64) ^ mix64(value.wrapping_add(GOLDEN_64)))
}

/// A uniform number in [0, 1 - 2^-24], every value exact. (Scaling all 32 bits
/// would round up to exactly 1 thirty times in 1e9.)
#[inline]
#[must_use]
pub const fn u32_to_unit(v: u32) -> f32 {
    (v >> 8) as f32 * UNIT_STEP
}
