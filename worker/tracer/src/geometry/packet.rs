//! Walks of eight rays at once.
//!
//! Worth it when the rays go the same way (camera rays of a tile, sun rays). A node
//! is first tested with the interval that holds all eight rays, one vector test
//! for its eight boxes; only boxes that the interval meets are tested lane by
//! lane (Wald, Benthin, Boulos 2008, "Getting rid of packets"; interval test after
//! Boulos et al. 2006, "Geometric and arithmetic culling methods for entire ray
//! packets"). Every lane does the operations of a single ray, so the answers are
//! the same bits; rays that disagree in direction are walked one by one.

use super::best8::Best8;
use super::kernels::{CULL_SLACK, FAR_SLACK, sign};
use super::lanes::{Backend, Floats, LaneMask};
use super::packet_leaves::{Clouds8, Instances8, Triangles8};
use super::ray::{Hit, Occlusion, Ray, rank};
use super::scene::Geometry;
use super::simd::Stack;
use super::single::{self, finish};
use super::sprite_leaves::Discs8;
use super::wide::{LEAF, Node8};
use crate::uses::PARTICLES;

/// `FAR_SLACK` and two roundings more, since a lane folds it into its inverse.
const ANY_SLACK: f32 = FAR_SLACK + 3.0 * f32::EPSILON;

/// Eight vectors, `[axis][lane]`.
pub(super) type Axes = [[f32; 8]; 3];

/// Eight rays that agree in the sign of every component, and their interval.
pub(super) struct PacketRay<B: Backend> {
    o: [B::F8; 3],
    inverse: [B::F8; 3],
    near: [usize; 3],
    /// Per axis: the origin that enters first and the one that leaves last.
    /// The inverse, larger by `FAR_SLACK`.
    inverse_far: [B::F8; 3],
    o_first: [B::F8; 3],
    o_last: [B::F8; 3],
    inverse_least: [B::F8; 3],
    inverse_most: [B::F8; 3],
}

impl<B: Backend> PacketRay<B> {
    /// None if the rays disagree, or if a component is zero: infinite inverses
    /// have no interval.
    #[inline(always)]
    pub(super) fn new(o: &Axes, d: &Axes) -> Option<Self> {
        let splat = B::F8::splat;
        let mut ray = Self {
            o: [B::F8::load(&o[0]), B::F8::load(&o[1]), B::F8::load(&o[2])],
            inverse: [splat(0.0); 3],
            near: [0; 3],
            inverse_far: [splat(0.0); 3],
            o_first: [splat(0.0); 3],
            o_last: [splat(0.0); 3],
            inverse_least: [splat(0.0); 3],
            inverse_most: [splat(0.0); 3],
        };
        for axis in 0..3 {
            let inverse = splat(1.0) / B::F8::load(&d[axis]);
            ray.inverse[axis] = inverse;
            ray.inverse_far[axis] = inverse * splat(FAR_SLACK);
            let (i_least, i_most) = least_and_most(&inverse.store());
            let (o_least, o_most) = least_and_most(&o[axis]);
            let agree = sign(i_least) == sign(i_most);
            if !(agree && i_least.is_finite() && i_most.is_finite()) {
                return None;
            }
            ray.near[axis] = sign(i_least);
            let (first, last) = if i_least > 0.0 {
                (o_most, o_least)
            } else {
                (o_least, o_most)
            };
            (ray.o_first[axis], ray.o_last[axis]) = (splat(first), splat(last));
            (ray.inverse_least[axis], ray.inverse_most[axis]) = (splat(i_least), splat(i_most));
        }
        Some(ray)
    }

    /// Boxes that some ray may enter before `t_far`, with a lower bound of the
    /// entries. Rounding is monotonic, so no lane enters a box that this leaves out.
    #[inline(always)]
    fn hit_any(&self, node: &Node8, t_far: f32) -> (u32, [f32; 8]) {
        let first = |axis: usize| {
            let way = B::F8::load(&node.planes[axis][self.near[axis] & 1]) - self.o_first[axis];
            (way * self.inverse_least[axis]).min(way * self.inverse_most[axis])
        };
        let last = |axis: usize| {
            let way = B::F8::load(&node.planes[axis][self.near[axis] & 1 ^ 1]) - self.o_last[axis];
            (way * self.inverse_least[axis]).max(way * self.inverse_most[axis])
        };
        let near = first(0).max(first(1).max(first(2).max(B::F8::splat(0.0))));
        let far = last(0).min(last(1).min(last(2).min(B::F8::splat(t_far))));
        (near.le(far * B::F8::splat(ANY_SLACK)).bits(), near.store())
    }

    /// The rays that enter child `slot` before their `t_far`.
    #[inline(always)]
    fn hit_child(&self, node: &Node8, slot: usize, t_far: B::F8) -> u32 {
        let slab = |axis: usize, side: usize| {
            B::F8::splat(node.planes[axis][side & 1][slot]) - self.o[axis]
        };
        // The operations of `hit_boxes`, to the last bit.
        let near = |axis: usize| slab(axis, self.near[axis]) * self.inverse[axis];
        let far = |axis: usize| slab(axis, self.near[axis] ^ 1) * self.inverse_far[axis];
        let near = near(0).max(near(1).max(near(2).max(B::F8::splat(0.0))));
        let far = far(0).min(far(1).min(far(2).min(t_far)));
        near.le(far).bits()
    }
}

/// By halves, which compiles to vector operations.
#[inline(always)]
fn least_and_most(a: &[f32; 8]) -> (f32, f32) {
    let mut least = *a;
    let mut most = *a;
    for half in [4, 2, 1] {
        for i in 0..half {
            least[i] = if least[i + half] < least[i] {
                least[i + half]
            } else {
                least[i]
            };
            most[i] = if most[i + half] > most[i] {
                most[i + half]
            } else {
                most[i]
            };
        }
    }
    (least[0], most[0])
}

/// What a packet does at a leaf. `lanes` are the rays that entered its box.
pub(super) trait Leaf8<B: Backend> {
    /// True if some lane has a new best.
    fn closest(&self, block: u32, lanes: u32, best: &mut Best8) -> bool;
    /// Walks on from `root` with one ray alone.
    fn closest_alone(&self, nodes: &[Node8], root: u32, lane: usize, best: &mut Best8);
    /// A lane that is blocked gets a negative `t`, so that it enters no more boxes.
    fn dim(&self, block: u32, lanes: u32, best: &mut Best8, depth: &mut [u32; 8]);
}

/// Subtrees that no more rays than this enter are walked ray by ray.
const ALONE_MAX: u32 = 2;

/// Lane numbers of a mask.
#[inline(always)]
pub(super) fn each_lane(mut mask: u32, mut visit: impl FnMut(usize)) {
    while mask != 0 {
        visit((mask.trailing_zeros() & 7) as usize);
        mask &= mask - 1;
    }
}

/// Stack entry: as for one ray, but the lowest eight bits of the distance, rounded
/// down, make room for the rays that entered.
#[inline(always)]
fn entry8(near: f32, lanes: u32, child: u32) -> u64 {
    u64::from(near.to_bits() & !0xff | lanes) << 32 | u64::from(child)
}

/// The closest hits of eight rays.
#[inline(always)]
pub(super) fn intersect8<B: Backend, const USES: u8>(
    scene: &Geometry,
    rays: &[Ray; 8],
    keys: &[u64; 8],
) -> [Option<Hit>; 8] {
    let (o, d) = axes(rays);
    let finite = rays.iter().all(Ray::is_finite);
    let Some(packet) = PacketRay::<B>::new(&o, &d).filter(|_| finite) else {
        return std::array::from_fn(|i| single::intersect::<B, USES>(scene, &rays[i], keys[i]));
    };
    let mut best = Best8::new(|lane| rays[lane].t_max);
    for (lane, ray) in rays.iter().enumerate() {
        if let Some(t) = scene.water_distance::<USES>(ray)
            && t <= best.t[lane]
        {
            (best.t[lane], best.rank[lane]) = (t, rank::WATER);
        }
    }
    let instances = Instances8::<USES> { scene, rays };
    if let Some(index) = scene.placement.lone {
        Leaf8::<B>::closest(&instances, index, 0xff, &mut best);
    } else {
        walk_closest(scene.placement.top.nodes(), &packet, &instances, &mut best);
    }
    if USES & PARTICLES != 0
        && let Some(particles) = &scene.particles
    {
        B::particles_closest8(&packet, &Clouds8::new(particles, &o, &d, keys), &mut best);
    }
    if USES & PARTICLES != 0
        && let Some(sprites) = &scene.sprites
    {
        B::sprites_closest8(&packet, &Discs8::new(sprites, &o, &d, keys), &mut best);
    }
    std::array::from_fn(|lane| finish(&best.lane(lane)))
}

/// What stands between the ends of eight rays.
#[inline(always)]
pub(super) fn transmittance8<B: Backend, const USES: u8>(
    scene: &Geometry,
    rays: &[Ray; 8],
) -> [Occlusion; 8] {
    let (o, d) = axes(rays);
    let finite = rays.iter().all(Ray::is_finite);
    let Some(packet) = PacketRay::<B>::new(&o, &d).filter(|_| finite) else {
        return std::array::from_fn(|i| single::transmittance::<B, USES>(scene, &rays[i]));
    };
    let mut best = Best8::new(|lane| rays[lane].t_max);
    let mut depth = [0; 8];
    for (lane, ray) in rays.iter().enumerate() {
        if let Some(t) = scene.water_distance::<USES>(ray)
            && t <= best.t[lane]
        {
            (best.t[lane], depth[lane]) = (-1.0, u32::MAX);
        }
    }
    let instances = Instances8::<USES> { scene, rays };
    if let Some(index) = scene.placement.lone {
        Leaf8::<B>::dim(&instances, index, 0xff, &mut best, &mut depth);
    } else {
        walk_dimming(
            scene.placement.top.nodes(),
            &packet,
            &instances,
            &mut best,
            &mut depth,
        );
    }
    if USES & PARTICLES != 0
        && let Some(particles) = &scene.particles
    {
        let leaf = Clouds8::new(particles, &o, &d, &[0; 8]);
        B::particles_dim8(&packet, &leaf, &mut best, &mut depth);
    }
    if USES & PARTICLES != 0
        && let Some(sprites) = &scene.sprites
    {
        let leaf = Discs8::new(sprites, &o, &d, &[0; 8]);
        B::sprites_dim8(&packet, &leaf, &mut best, &mut depth);
    }
    depth.map(Occlusion::from_depth)
}

#[inline(always)]
fn axes(rays: &[Ray; 8]) -> (Axes, Axes) {
    let mut o = [[0.0; 8]; 3];
    let mut d = [[0.0; 8]; 3];
    for (lane, ray) in rays.iter().enumerate() {
        put(&mut o, &mut d, lane, ray.o.to_array(), ray.d.to_array());
    }
    (o, d)
}

#[inline(always)]
pub(super) fn put(o: &mut Axes, d: &mut Axes, lane: usize, from: [f32; 3], along: [f32; 3]) {
    for axis in 0..3 {
        o[axis][lane] = from[axis];
        d[axis][lane] = along[axis];
    }
}

/// The farthest distance at which some ray still looks for something.
#[inline(always)]
fn farthest(t: &[f32; 8]) -> f32 {
    least_and_most(t).1 * CULL_SLACK
}

#[inline(always)]
fn walk_closest<B: Backend, L: Leaf8<B>>(
    nodes: &[Node8],
    ray: &PacketRay<B>,
    leaf: &L,
    best: &mut Best8,
) {
    let mut stack = Stack::new();
    let mut current = entry8(0.0, 0xff, 0);
    let mut t_far = farthest(&best.t);
    loop {
        let (lanes, child) = ((current >> 32) as u32 & 0xff, current as u32);
        if child & LEAF != 0 {
            if leaf.closest(child & !LEAF, lanes, best) {
                t_far = farthest(&best.t);
            }
        } else if lanes.count_ones() <= ALONE_MAX {
            let mut left = lanes;
            while left != 0 {
                leaf.closest_alone(nodes, child, (left.trailing_zeros() & 7) as usize, best);
                left &= left - 1;
            }
            t_far = farthest(&best.t);
        } else {
            let node = &nodes[child as usize];
            let (mask, near) = ray.hit_any(node, t_far);
            let lanes_far = B::F8::load(&best.t) * B::F8::splat(CULL_SLACK);
            let mut count = 0;
            // A loop, not a closure: intrinsics in a closure that is not inlined
            // become calls.
            let mut left = mask;
            while left != 0 {
                let slot = (left.trailing_zeros() & 7) as usize;
                left &= left - 1;
                let entered = ray.hit_child(node, slot, lanes_far);
                if entered != 0 {
                    stack.push_sorted(entry8(near[slot], entered, node.child[slot]), count);
                    count += 1;
                }
            }
        }
        current = loop {
            let Some(e) = stack.pop() else { return };
            if f32::from_bits((e >> 32) as u32 & !0xff) <= t_far {
                break e;
            }
        };
    }
}

#[inline(always)]
fn walk_dimming<B: Backend, L: Leaf8<B>>(
    nodes: &[Node8],
    ray: &PacketRay<B>,
    leaf: &L,
    best: &mut Best8,
    depth: &mut [u32; 8],
) {
    let mut stack = Stack::new();
    let mut current = entry8(0.0, 0xff, 0);
    let mut t_far = farthest(&best.t);
    if t_far < 0.0 {
        return;
    }
    loop {
        let (lanes, child) = ((current >> 32) as u32 & 0xff, current as u32);
        if child & LEAF != 0 {
            leaf.dim(child & !LEAF, lanes, best, depth);
            t_far = farthest(&best.t);
            if t_far < 0.0 {
                return;
            }
        } else {
            let node = &nodes[child as usize];
            let (mask, _) = ray.hit_any(node, t_far);
            let lanes_far = B::F8::load(&best.t) * B::F8::splat(CULL_SLACK);
            let mut left = mask;
            while left != 0 {
                let slot = (left.trailing_zeros() & 7) as usize;
                left &= left - 1;
                let entered = ray.hit_child(node, slot, lanes_far);
                if entered != 0 {
                    stack.push(entry8(0.0, entered, node.child[slot]));
                }
            }
        }
        let Some(e) = stack.pop() else { return };
        current = e;
    }
}

/// The closest hits of a packet with one mesh.
#[inline(always)]
pub(super) fn mesh_closest8<B: Backend>(
    packet: &PacketRay<B>,
    leaf: &Triangles8<'_, B>,
    best: &mut Best8,
) {
    walk_closest(leaf.mesh.tree.nodes(), packet, leaf, best);
}

/// Blocks the rays of a packet that meet one mesh.
#[inline(always)]
pub(super) fn mesh_dim8<B: Backend>(
    packet: &PacketRay<B>,
    leaf: &Triangles8<'_, B>,
    best: &mut Best8,
    depth: &mut [u32; 8],
) {
    walk_dimming(leaf.mesh.tree.nodes(), packet, leaf, best, depth);
}

/// The closest walls of particles that stop the rays of a packet.
#[inline(always)]
pub(super) fn particles_closest8<B: Backend>(
    packet: &PacketRay<B>,
    leaf: &Clouds8<'_, B>,
    best: &mut Best8,
) {
    walk_closest(leaf.particles.tree.nodes(), packet, leaf, best);
}

/// Adds the depths of the particles' walls.
#[inline(always)]
pub(super) fn particles_dim8<B: Backend>(
    packet: &PacketRay<B>,
    leaf: &Clouds8<'_, B>,
    best: &mut Best8,
    depth: &mut [u32; 8],
) {
    walk_dimming(leaf.particles.tree.nodes(), packet, leaf, best, depth);
}

/// The closest sprites that stop the rays of a packet.
#[inline(always)]
pub(super) fn sprites_closest8<B: Backend>(
    packet: &PacketRay<B>,
    leaf: &Discs8<'_, B>,
    best: &mut Best8,
) {
    walk_closest(leaf.facing.sprites.tree.nodes(), packet, leaf, best);
}

/// Adds the depths of the sprites.
#[inline(always)]
pub(super) fn sprites_dim8<B: Backend>(
    packet: &PacketRay<B>,
    leaf: &Discs8<'_, B>,
    best: &mut Best8,
    depth: &mut [u32; 8],
) {
    walk_dimming(leaf.facing.sprites.tree.nodes(), packet, leaf, best, depth);
}
