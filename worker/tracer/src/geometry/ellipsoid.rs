//! Ray against ellipsoids, and the chance that a wall stops it.

use super::lanes::{Floats, LaneMask};

/// Distances at which a ray crosses ellipsoids, lane by lane.
pub(super) struct Crossings<V> {
    /// Bit `i`: the near wall of lane `i` is met at `0 < t <= t_far`.
    pub(super) near_mask: u32,
    /// The same for the far wall.
    pub(super) far_mask: u32,
    pub(super) near: V,
    pub(super) far: V,
}

/// Where the ray meets the walls. In the space where the ellipsoid is the unit
/// sphere, the discriminant is `1 - |l|^2` with `l` the way from the centre to the
/// nearest point of the line (Haines et al. 2019, "Precision improvements for
/// ray/sphere intersection"): `b^2 - 4ac` cancels for small or distant spheres.
#[inline(always)]
pub(super) fn cross_ellipsoids<const N: usize, V: Floats<N>>(
    centre: [V; 3],
    inverse_radius: [V; 3],
    o: [V; 3],
    d: [V; 3],
    t_far: V,
) -> Crossings<V> {
    let zero = V::splat(0.0);
    let one = V::splat(1.0);
    let [ix, iy, iz] = inverse_radius;
    let (ox, oy, oz) = (
        (o[0] - centre[0]) * ix,
        (o[1] - centre[1]) * iy,
        (o[2] - centre[2]) * iz,
    );
    let (dx, dy, dz) = (d[0] * ix, d[1] * iy, d[2] * iz);
    let inverse = one / (dx * dx + dy * dy + dz * dz);
    let s = (ox * dx + oy * dy + oz * dz) * inverse;
    let (lx, ly, lz) = (ox - s * dx, oy - s * dy, oz - s * dz);
    let discriminant = one - (lx * lx + ly * ly + lz * lz);
    let met = zero.le(discriminant);
    // `s` is as wrong as a dot product far from the centre; `l`, which is short,
    // says by how much.
    let s = s + (lx * dx + ly * dy + lz * dz) * inverse;
    // A negative discriminant gives NaN, which no comparison below accepts.
    let half = (discriminant * inverse).sqrt();
    let near = zero - s - half;
    let far = half - s;
    Crossings {
        near_mask: met.and(zero.lt(near)).and(near.le(t_far)).bits(),
        far_mask: met.and(zero.lt(far)).and(far.le(t_far)).bits(),
        near,
        far,
    }
}

/// True if the wall stops the ray. `key` names sample and path segment, `wall` is
/// `rank::wall` of what is crossed.
///
/// The finalizer is variant 13 of Stafford's mixers ("Better bit mixing", 2011),
/// a bijection that passes avalanche tests; key and wall are joined before it by
/// an odd multiplier (the golden ratio's bits), so that neighbours differ in the
/// high bits too. The top 31 bits are compared with `opacity * 2^31`.
#[inline(always)]
pub(super) fn is_stopped(key: u64, wall: u64, threshold: u32) -> bool {
    let mut x = key ^ (wall + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^= x >> 31;
    ((x >> 33) as u32) < threshold
}
