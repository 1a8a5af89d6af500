//! The box test and the triangle test, for one ray and several targets.
//!
//! Both follow Woop, Benthin, Wald 2013, "Watertight ray/triangle intersection":
//! edge functions in a space where the ray is the z axis, and boxes whose
//! interval is widened by the roundings of its computation. Two differences: the
//! distance comes from the triangle's plane, since the weighted sum of corner
//! depths is wrong on long slivers; and an edge function of exactly zero counts
//! for both neighbours, so that no second precision is needed.

use super::lanes::{Backend, Floats, LaneMask};
use super::mesh::Tri4;
use super::wide::Node8;

/// Three roundings on either side of the slab interval (Ize 2013, "Robust BVH ray
/// traversal"), all on the far side, and one for folding it into the reciprocal.
pub(super) const FAR_SLACK: f32 = 1.0 + 8.0 * f32::EPSILON;

/// A box is entered although it begins this much behind the best hit: the plane
/// distance of a hit may round to less than the entry of its box, and then the
/// order of visits would decide. 2^-16 is 128 roundings.
pub(super) const CULL_SLACK: f32 = 1.0 + 1.0 / 65536.0;

/// A ray in the form the box test wants.
pub(super) struct BoxRay<B: Backend> {
    o: [B::F8; 3],
    /// One over the direction; infinite where it is zero.
    inverse: [B::F8; 3],
    /// The same, larger by `FAR_SLACK`: for the far sides.
    inverse_far: [B::F8; 3],
    /// Which bound is met first on each axis: 0 lower, 1 upper.
    near: [usize; 3],
}

impl<B: Backend> BoxRay<B> {
    #[inline(always)]
    pub(super) fn new(o: [f32; 3], d: [f32; 3]) -> Self {
        let inverse = d.map(|d| 1.0 / d);
        Self {
            o: [B::F8::splat(o[0]), B::F8::splat(o[1]), B::F8::splat(o[2])],
            inverse: [
                B::F8::splat(inverse[0]),
                B::F8::splat(inverse[1]),
                B::F8::splat(inverse[2]),
            ],
            inverse_far: [
                B::F8::splat(inverse[0] * FAR_SLACK),
                B::F8::splat(inverse[1] * FAR_SLACK),
                B::F8::splat(inverse[2] * FAR_SLACK),
            ],
            near: [sign(d[0]), sign(d[1]), sign(d[2])],
        }
    }
}

#[inline(always)]
pub(super) fn sign(x: f32) -> usize {
    (x.to_bits() >> 31) as usize
}

/// The entries of a ray into the eight boxes of a node, and which are entered
/// before `t_far`.
///
/// A zero direction gives `0 * inf = NaN` on the very plane; the order of the
/// operands of min and max drops it, so such a box counts as entered.
#[inline(always)]
pub(super) fn hit_boxes<B: Backend>(node: &Node8, ray: &BoxRay<B>, t_far: f32) -> (u32, [f32; 8]) {
    let from_o = |axis: usize, side: usize| B::F8::load(&node.planes[axis][side & 1]) - ray.o[axis];
    let near = |axis: usize| from_o(axis, ray.near[axis]) * ray.inverse[axis];
    let far = |axis: usize| from_o(axis, ray.near[axis] ^ 1) * ray.inverse_far[axis];
    let near = near(0).max(near(1).max(near(2).max(B::F8::splat(0.0))));
    let far = far(0).min(far(1).min(far(2).min(B::F8::splat(t_far))));
    let entered = near.le(far);
    (entered.bits(), near.store())
}

/// Axes of a ray in Woop's space: the last is that of the largest component. Chosen
/// without branches, since the directions of bounced rays are anyone's guess.
#[inline(always)]
pub(super) fn sheared_axes(d: [f32; 3]) -> [usize; 3] {
    let [x, y, z] = d.map(f32::abs);
    let xy = usize::from(y >= x);
    let most = if y >= x { y } else { x };
    let kz = if z >= most { 2 } else { xy };
    const NEXT: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];
    NEXT[kz]
}

/// A ray in the form the triangle test wants: one ray, four lanes.
pub(super) struct TriRay<B: Backend> {
    k: [usize; 3],
    o: [B::F4; 3],
    d: [B::F4; 3],
    shear: [B::F4; 2],
    scale: B::F4,
}

impl<B: Backend> TriRay<B> {
    #[inline(always)]
    pub(super) fn new(o: [f32; 3], d: [f32; 3]) -> Self {
        let [x, y, z] = sheared_axes(d);
        let scale = 1.0 / d[z];
        Self {
            k: [x, y, z],
            o: [B::F4::splat(o[x]), B::F4::splat(o[y]), B::F4::splat(o[z])],
            d: [B::F4::splat(d[x]), B::F4::splat(d[y]), B::F4::splat(d[z])],
            shear: [B::F4::splat(d[x] * scale), B::F4::splat(d[y] * scale)],
            scale: B::F4::splat(scale),
        }
    }
}

/// Lanes that were hit, with the distances and edge functions of all.
pub(super) struct TriHits<V> {
    pub(super) mask: u32,
    pub(super) t: V,
    /// Weights of the corners, times `det`.
    pub(super) v: V,
    pub(super) w: V,
    pub(super) det: V,
}

/// One ray against the four triangles of a block: hits at `0 < t <= t_far`.
#[inline(always)]
pub(super) fn hit_triangles<B: Backend>(
    block: &Tri4,
    ray: &TriRay<B>,
    t_far: f32,
) -> Option<TriHits<B::F4>> {
    let [kx, ky, kz] = ray.k;
    let (xs, ys, zs) = (&block.corner[kx], &block.corner[ky], &block.corner[kz]);
    let corner = |i: usize| {
        [
            B::F4::load(&xs[i]),
            B::F4::load(&ys[i]),
            B::F4::load(&zs[i]),
        ]
    };
    hit_sheared::<4, B::F4>(
        [corner(0), corner(1), corner(2)],
        ray.o,
        ray.d,
        ray.shear,
        ray.scale,
        B::F4::splat(t_far),
    )
}

/// The test itself, lane by lane; all axes already in the order `k`.
#[inline(always)]
pub(super) fn hit_sheared<const N: usize, V: Floats<N>>(
    corner: [[V; 3]; 3],
    o: [V; 3],
    d: [V; 3],
    shear: [V; 2],
    scale: V,
    t_far: V,
) -> Option<TriHits<V>> {
    let zero = V::splat(0.0);
    let from_o = |c: [V; 3]| [c[0] - o[0], c[1] - o[1], c[2] - o[2]];
    let [a, b, c] = [from_o(corner[0]), from_o(corner[1]), from_o(corner[2])];
    let sheared = |p: [V; 3]| [p[0] - shear[0] * p[2], p[1] - shear[1] * p[2]];
    let [[ax, ay], [bx, by], [cx, cy]] = [sheared(a), sheared(b), sheared(c)];
    let u = cx * by - cy * bx;
    let v = ax * cy - ay * cx;
    let w = bx * ay - by * ax;
    let least = u.min(v).min(w);
    let most = u.max(v).max(w);
    let inside = zero.le(least).or(most.le(zero));
    if inside.bits() == 0 {
        return None;
    }
    let det = u + v + w;
    // Distance from the plane, kept within the depths of the corners: seen edge
    // on, the plane's own answer is noise.
    let n = cross(minus(corner[1], corner[0]), minus(corner[2], corner[0]));
    let [az, bz, cz] = [a[2] * scale, b[2] * scale, c[2] * scale];
    let plane = dot(n, a) / dot(n, d);
    let t = plane.max(az.min(bz).min(cz)).min(az.max(bz).max(cz));
    let solid = det.lt(zero).or(zero.lt(det));
    let mask = inside.and(solid).and(zero.lt(t)).and(t.le(t_far)).bits();
    if mask == 0 {
        None
    } else {
        Some(TriHits { mask, t, v, w, det })
    }
}

#[inline(always)]
fn minus<const N: usize, V: Floats<N>>(a: [V; 3], b: [V; 3]) -> [V; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn cross<const N: usize, V: Floats<N>>(a: [V; 3], b: [V; 3]) -> [V; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[inline(always)]
fn dot<const N: usize, V: Floats<N>>(a: [V; 3], b: [V; 3]) -> V {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The best hit so far.
#[derive(Clone, Copy)]
pub(super) struct Best {
    /// Its distance; before any hit, the end of the ray (exclusive).
    pub(super) t: f32,
    /// Boxes that begin behind this are of no interest.
    pub(super) cull: f32,
    /// See `ray::rank`; `NOTHING` before any hit.
    pub(super) rank: u64,
    /// Weights of the second and third corner, times `det`.
    pub(super) v: f32,
    pub(super) w: f32,
    pub(super) det: f32,
}

impl Best {
    /// Nothing yet, on a ray that ends before `t_max`.
    #[inline(always)]
    pub(super) fn new(t_max: f32) -> Self {
        // The largest float below the end: the tests allow t equal to the best.
        Self::until(if t_max > 0.0 { t_max.next_down() } else { -1.0 })
    }

    /// Nothing yet, on a ray that ends with `t`.
    #[inline(always)]
    pub(super) fn until(t: f32) -> Self {
        Self {
            t,
            cull: t * CULL_SLACK,
            rank: super::ray::rank::NOTHING,
            v: 0.0,
            w: 0.0,
            det: 1.0,
        }
    }

    /// True if something at `t` comes before the best.
    #[inline(always)]
    pub(super) fn is_beaten_by(&self, t: f32, rank: u64) -> bool {
        t < self.t || (t == self.t && rank < self.rank)
    }

    #[inline(always)]
    pub(super) fn set(&mut self, t: f32, rank: u64) {
        self.t = t;
        self.cull = t * CULL_SLACK;
        self.rank = rank;
    }
}
