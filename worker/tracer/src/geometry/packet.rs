//! Walks of eight rays at once.
//!
//! Worth it when the rays go the same way (camera rays of a tile, sun rays). A node
//! is first tested with the interval that holds all eight rays, one vector test
//! for its eight boxes; only boxes that the interval meets are tested lane by
//! lane (Wald, Benthin, Boulos 2008, "Getting rid of packets"; interval test after
//! Boulos et al. 2006, "Geometric and arithmetic culling methods for entire ray
//! packets"). Every lane does the operations of a single ray, so the answers are
//! the same bits; rays that disagree in direction are walked one by one.

use super::ellipsoid::{Crossings, cross_ellipsoids, is_stopped};
use super::kernels::{Best, CULL_SLACK, FAR_SLACK, Shear, TriHits, hit_sheared, sign};
use super::lanes::{Backend, Floats, LaneMask};
use super::mesh::{Tri4, TriMesh};
use super::particles::{Ellipsoid8, Particles};
use super::ray::rank;
use super::ray::{BLOCKING_DEPTH, Hit, Occlusion, Ray};
use super::scene::Geometry;
use super::simd::Stack;
use super::single::{self, finish, into_local};
use super::wide::{LEAF, Node8};

/// Eight vectors, `[axis][lane]`.
type Axes = [[f32; 8]; 3];

/// The best hits of eight rays.
pub(super) struct Best8 {
    t: [f32; 8],
    rank: [u64; 8],
    v: [f32; 8],
    w: [f32; 8],
    det: [f32; 8],
}

impl Best8 {
    #[inline(always)]
    fn new(t_max: impl Fn(usize) -> f32) -> Self {
        let t = std::array::from_fn(|lane| Best::new(t_max(lane)).t);
        Self {
            t,
            rank: [rank::NOTHING; 8],
            v: [0.0; 8],
            w: [0.0; 8],
            det: [1.0; 8],
        }
    }

    #[inline(always)]
    fn lane(&self, lane: usize) -> Best {
        let mut best = Best::new(0.0);
        best.set(self.t[lane], self.rank[lane]);
        (best.v, best.w, best.det) = (self.v[lane], self.w[lane], self.det[lane]);
        best
    }

    #[inline(always)]
    fn set_lane(&mut self, lane: usize, best: &Best) {
        (self.t[lane], self.rank[lane]) = (best.t, best.rank);
        (self.v[lane], self.w[lane], self.det[lane]) = (best.v, best.w, best.det);
    }

    #[inline(always)]
    fn is_beaten_by(&self, lane: usize, t: f32, rank: u64) -> bool {
        t < self.t[lane] || (t == self.t[lane] && rank < self.rank[lane])
    }
}

/// Eight rays that agree in the sign of every component, and their interval.
pub(super) struct PacketRay<B: Backend> {
    o: [B::F8; 3],
    inverse: [B::F8; 3],
    near: [usize; 3],
    /// Per axis: the origin that enters first and the one that leaves last.
    o_first: [B::F8; 3],
    o_last: [B::F8; 3],
    inverse_least: [B::F8; 3],
    inverse_most: [B::F8; 3],
}

impl<B: Backend> PacketRay<B> {
    /// None if the rays disagree, or if a component is zero: infinite inverses
    /// have no interval.
    #[inline(always)]
    fn new(o: &Axes, d: &Axes) -> Option<Self> {
        let splat = B::F8::splat;
        let mut ray = Self {
            o: [B::F8::load(&o[0]), B::F8::load(&o[1]), B::F8::load(&o[2])],
            inverse: [splat(0.0); 3],
            near: [0; 3],
            o_first: [splat(0.0); 3],
            o_last: [splat(0.0); 3],
            inverse_least: [splat(0.0); 3],
            inverse_most: [splat(0.0); 3],
        };
        for axis in 0..3 {
            let inverse = splat(1.0) / B::F8::load(&d[axis]);
            ray.inverse[axis] = inverse;
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
    fn hit_any(&self, node: &Node8, t_far: f32) -> u32 {
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
        near.le(far * B::F8::splat(FAR_SLACK))
            .bits()
    }

    /// The rays that enter child `slot` before their `t_far`, and their entries.
    #[inline(always)]
    fn hit_child(&self, node: &Node8, slot: usize, t_far: B::F8) -> (u32, B::F8) {
        let slab = |axis: usize, side: usize| {
            (B::F8::splat(node.planes[axis][side & 1][slot]) - self.o[axis]) * self.inverse[axis]
        };
        let [x, y, z] = self.near;
        let near = slab(0, x).max(slab(1, y).max(slab(2, z).max(B::F8::splat(0.0))));
        let far = slab(0, x ^ 1).min(slab(1, y ^ 1).min(slab(2, z ^ 1).min(t_far)));
        let entered = near.le(far * B::F8::splat(FAR_SLACK));
        (entered.bits(), near)
    }
}

#[inline(always)]
fn least_and_most(a: &[f32; 8]) -> (f32, f32) {
    let mut least = a[0];
    let mut most = a[0];
    for &x in &a[1..] {
        least = if x < least { x } else { least };
        most = if x > most { x } else { most };
    }
    (least, most)
}

/// What a packet does at a leaf.
trait Leaf8<B: Backend> {
    fn closest(&self, block: u32, best: &mut Best8);
    /// A lane that is blocked gets a negative `t`, so that it enters no more boxes.
    fn dim(&self, block: u32, best: &mut Best8, depth: &mut [u32; 8]);
}

/// The closest hits of eight rays.
#[inline(always)]
pub(super) fn intersect8<B: Backend, const PARTICLES: bool>(
    scene: &Geometry,
    rays: &[Ray; 8],
    keys: &[u64; 8],
) -> [Option<Hit>; 8] {
    let (o, d) = axes(rays);
    let finite = rays.iter().all(Ray::is_finite);
    let Some(packet) = PacketRay::<B>::new(&o, &d).filter(|_| finite) else {
        return std::array::from_fn(|i| {
            single::intersect::<B, PARTICLES>(scene, &rays[i], keys[i])
        });
    };
    let mut best = Best8::new(|lane| rays[lane].t_max);
    for (lane, ray) in rays.iter().enumerate() {
        if let Some(t) = scene.water_distance(ray)
            && t <= best.t[lane]
        {
            (best.t[lane], best.rank[lane]) = (t, rank::WATER);
        }
    }
    walk_closest(
        scene.top.nodes(),
        &packet,
        &Instances8 { scene, rays },
        &mut best,
    );
    if PARTICLES && let Some(particles) = &scene.particles {
        let leaf = Clouds8::<B>::new(particles, &o, &d, keys);
        walk_closest(particles.tree.nodes(), &packet, &leaf, &mut best);
    }
    std::array::from_fn(|lane| finish(&best.lane(lane)))
}

/// What stands between the ends of eight rays.
#[inline(always)]
pub(super) fn transmittance8<B: Backend, const PARTICLES: bool>(
    scene: &Geometry,
    rays: &[Ray; 8],
) -> [Occlusion; 8] {
    let (o, d) = axes(rays);
    let finite = rays.iter().all(Ray::is_finite);
    let Some(packet) = PacketRay::<B>::new(&o, &d).filter(|_| finite) else {
        return std::array::from_fn(|i| single::transmittance::<B, PARTICLES>(scene, &rays[i]));
    };
    let mut best = Best8::new(|lane| rays[lane].t_max);
    let mut depth = [0; 8];
    for (lane, ray) in rays.iter().enumerate() {
        if let Some(t) = scene.water_distance(ray)
            && t <= best.t[lane]
        {
            (best.t[lane], depth[lane]) = (-1.0, u32::MAX);
        }
    }
    walk_dimming(
        scene.top.nodes(),
        &packet,
        &Instances8 { scene, rays },
        &mut best,
        &mut depth,
    );
    if PARTICLES && let Some(particles) = &scene.particles {
        let leaf = Clouds8::<B>::new(particles, &o, &d, &[0; 8]);
        walk_dimming(
            particles.tree.nodes(),
            &packet,
            &leaf,
            &mut best,
            &mut depth,
        );
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
fn put(o: &mut Axes, d: &mut Axes, lane: usize, from: [f32; 3], along: [f32; 3]) {
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
    let mut current = 0_u32;
    let mut t_far = farthest(&best.t);
    loop {
        if current & LEAF != 0 {
            leaf.closest(current & !LEAF, best);
            t_far = farthest(&best.t);
        } else {
            let node = &nodes[current as usize];
            let mut mask = ray.hit_any(node, t_far);
            let lanes_far = B::F8::load(&best.t) * B::F8::splat(CULL_SLACK);
            let mut count = 0;
            while mask != 0 {
                let slot = (mask.trailing_zeros() & 7) as usize;
                mask &= mask - 1;
                let (entered, near) = ray.hit_child(node, slot, lanes_far);
                if entered != 0 {
                    // A lane that stays out may lower the bound: harmless.
                    let near = least_and_most(&near.store()).0;
                    stack.push_sorted(
                        u64::from(near.to_bits()) << 32 | u64::from(node.child[slot]),
                        count,
                    );
                    count += 1;
                }
            }
        }
        current = loop {
            let Some(e) = stack.pop() else { return };
            if f32::from_bits((e >> 32) as u32) <= t_far {
                break e as u32;
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
    let mut current = 0_u32;
    let mut t_far = farthest(&best.t);
    if t_far < 0.0 {
        return;
    }
    loop {
        if current & LEAF != 0 {
            leaf.dim(current & !LEAF, best, depth);
            t_far = farthest(&best.t);
            if t_far < 0.0 {
                return;
            }
        } else {
            let node = &nodes[current as usize];
            let mut mask = ray.hit_any(node, t_far);
            let lanes_far = B::F8::load(&best.t) * B::F8::splat(CULL_SLACK);
            while mask != 0 {
                let slot = (mask.trailing_zeros() & 7) as usize;
                mask &= mask - 1;
                if ray.hit_child(node, slot, lanes_far).0 != 0 {
                    stack.push(u64::from(node.child[slot]));
                }
            }
        }
        let Some(e) = stack.pop() else { return };
        current = e as u32;
    }
}

/// The closest hits of a packet with one mesh.
#[inline(always)]
pub(super) fn mesh_closest8<B: Backend>(packet: &PacketRay<B>, leaf: &Triangles8<'_, B>, best: &mut Best8) {
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

/// Leaves of the top tree.
struct Instances8<'a> {
    scene: &'a Geometry,
    rays: &'a [Ray; 8],
}

impl Instances8<'_> {
    /// The packet in mesh space; None if it is none there.
    #[inline(always)]
    fn enter<B: Backend>(&self, index: u32) -> Option<(PacketRay<B>, Triangles8<'_, B>)> {
        let instance = &self.scene.instances[index as usize];
        let mesh = &self.scene.meshes[instance.mesh as usize];
        let mut o = [[0.0; 8]; 3];
        let mut d = [[0.0; 8]; 3];
        for (lane, ray) in self.rays.iter().enumerate() {
            let (from, along) = into_local(instance, ray)?;
            put(&mut o, &mut d, lane, from, along);
        }
        Some((
            PacketRay::new(&o, &d)?,
            Triangles8::new(mesh, index, &o, &d)?,
        ))
    }
}

impl<B: Backend> Leaf8<B> for Instances8<'_> {
    #[inline(always)]
    fn closest(&self, block: u32, best: &mut Best8) {
        if let Some((packet, leaf)) = self.enter::<B>(block) {
            B::mesh_closest8(&packet, &leaf, best);
            return;
        }
        for (lane, ray) in self.rays.iter().enumerate() {
            let mut one = best.lane(lane);
            single::closest_in_instance::<B>(self.scene, ray, block, &mut one);
            best.set_lane(lane, &one);
        }
    }
    #[inline(always)]
    fn dim(&self, block: u32, best: &mut Best8, depth: &mut [u32; 8]) {
        if let Some((packet, leaf)) = self.enter::<B>(block) {
            B::mesh_dim8(&packet, &leaf, best, depth);
            return;
        }
        for (lane, ray) in self.rays.iter().enumerate() {
            single::dim_in_instance::<B>(
                self.scene,
                ray,
                block,
                &best.lane(lane),
                &mut depth[lane],
            );
            if depth[lane] > BLOCKING_DEPTH {
                best.t[lane] = -1.0;
            }
        }
    }
}

/// Leaves of a mesh, for rays with one main axis.
pub(super) struct Triangles8<'a, B: Backend> {
    mesh: &'a TriMesh,
    instance: u32,
    k: [usize; 3],
    /// In the order `k`.
    o: [B::F8; 3],
    d: [B::F8; 3],
    shear: [B::F8; 2],
    scale: B::F8,
}

impl<'a, B: Backend> Triangles8<'a, B> {
    #[inline(always)]
    fn new(mesh: &'a TriMesh, instance: u32, o: &Axes, d: &Axes) -> Option<Self> {
        let of_lane = |lane: usize| Shear::new([d[0][lane], d[1][lane], d[2][lane]]);
        let first = of_lane(0);
        let [x, y, z] = first.k;
        let mut shear = [[0.0; 8]; 3];
        for lane in 0..8 {
            let s = of_lane(lane);
            if s.k != first.k {
                return None;
            }
            (shear[0][lane], shear[1][lane], shear[2][lane]) = (s.shear[0], s.shear[1], s.scale);
        }
        let load = B::F8::load;
        Some(Self {
            mesh,
            instance,
            k: first.k,
            o: [load(&o[x]), load(&o[y]), load(&o[z])],
            d: [load(&d[x]), load(&d[y]), load(&d[z])],
            shear: [load(&shear[0]), load(&shear[1])],
            scale: load(&shear[2]),
        })
    }

    #[inline(always)]
    fn hit(&self, block: &Tri4, lane: usize, t_far: &[f32; 8]) -> Option<TriHits<B::F8>> {
        let corner = |vertex: usize| self.k.map(|k| B::F8::splat(block.corner[k][vertex][lane]));
        let corners = [corner(0), corner(1), corner(2)];
        hit_sheared::<8, B::F8>(
            corners,
            self.o,
            self.d,
            self.shear,
            self.scale,
            B::F8::load(t_far),
        )
    }
}

impl<B: Backend> Leaf8<B> for Triangles8<'_, B> {
    #[inline(always)]
    fn closest(&self, block: u32, best: &mut Best8) {
        let block = &self.mesh.blocks[block as usize];
        for lane in 0..block.count() {
            let Some(hits) = self.hit(block, lane, &best.t) else {
                continue;
            };
            let (t, v, w, det) = (
                hits.t.store(),
                hits.v.store(),
                hits.w.store(),
                hits.det.store(),
            );
            let rank = rank::triangle(self.instance, block.prim[lane]);
            let mut mask = hits.mask;
            while mask != 0 {
                let ray = (mask.trailing_zeros() & 7) as usize;
                mask &= mask - 1;
                if best.is_beaten_by(ray, t[ray], rank) {
                    (best.t[ray], best.rank[ray]) = (t[ray], rank);
                    (best.v[ray], best.w[ray], best.det[ray]) = (v[ray], w[ray], det[ray]);
                }
            }
        }
    }
    #[inline(always)]
    fn dim(&self, block: u32, best: &mut Best8, depth: &mut [u32; 8]) {
        let block = &self.mesh.blocks[block as usize];
        for lane in 0..block.count() {
            let Some(hits) = self.hit(block, lane, &best.t) else {
                continue;
            };
            for ray in 0..8 {
                if hits.mask >> ray & 1 == 1 {
                    (best.t[ray], depth[ray]) = (-1.0, u32::MAX);
                }
            }
        }
    }
}

/// Leaves of the particles' tree.
struct Clouds8<'a, B: Backend> {
    particles: &'a Particles,
    o: [B::F8; 3],
    d: [B::F8; 3],
    keys: &'a [u64; 8],
}

impl<'a, B: Backend> Clouds8<'a, B> {
    #[inline(always)]
    fn new(particles: &'a Particles, o: &Axes, d: &Axes, keys: &'a [u64; 8]) -> Self {
        let load = |x: &Axes| [B::F8::load(&x[0]), B::F8::load(&x[1]), B::F8::load(&x[2])];
        Self {
            particles,
            o: load(o),
            d: load(d),
            keys,
        }
    }

    #[inline(always)]
    fn cross(&self, block: &Ellipsoid8, lane: usize, t_far: &[f32; 8]) -> Crossings<B::F8> {
        let splat = |a: &Axes| {
            [
                B::F8::splat(a[0][lane]),
                B::F8::splat(a[1][lane]),
                B::F8::splat(a[2][lane]),
            ]
        };
        let (centre, inverse) = (splat(&block.centre), splat(&block.inverse_radius));
        cross_ellipsoids::<8, B::F8>(centre, inverse, self.o, self.d, B::F8::load(t_far))
    }
}

impl<B: Backend> Leaf8<B> for Clouds8<'_, B> {
    #[inline(always)]
    fn closest(&self, block: u32, best: &mut Best8) {
        let block = &self.particles.blocks[block as usize];
        for lane in 0..block.count() {
            let c = self.cross(block, lane, &best.t);
            let mut mask = c.near_mask | c.far_mask << 8;
            if mask == 0 {
                continue;
            }
            let distances = [c.near.store(), c.far.store()];
            let (prim, threshold) = (block.prim[lane], block.threshold[lane]);
            while mask != 0 {
                let bit = mask.trailing_zeros();
                mask &= mask - 1;
                let (ray, crossing) = ((bit & 7) as usize, bit >> 3 & 1);
                let t = distances[crossing as usize][ray];
                let rank = rank::particle(prim, crossing);
                if best.is_beaten_by(ray, t, rank)
                    && is_stopped(self.keys[ray], prim, crossing, threshold)
                {
                    (best.t[ray], best.rank[ray]) = (t, rank);
                }
            }
        }
    }
    #[inline(always)]
    fn dim(&self, block: u32, best: &mut Best8, depth: &mut [u32; 8]) {
        let block = &self.particles.blocks[block as usize];
        for lane in 0..block.count() {
            let c = self.cross(block, lane, &best.t);
            let mut mask = c.near_mask | c.far_mask << 8;
            while mask != 0 {
                let ray = (mask.trailing_zeros() & 7) as usize;
                mask &= mask - 1;
                depth[ray] = depth[ray].saturating_add(block.depth[lane]);
                if depth[ray] > BLOCKING_DEPTH {
                    best.t[ray] = -1.0;
                }
            }
        }
    }
}
