//! Walks of one ray: the closest hit, and what dims it.

use glam::Vec3A;

use super::ellipsoid::{cross_ellipsoids, is_stopped};
use super::instance::Instance;
use super::kernels::{Best, BoxRay, TriRay, hit_boxes, hit_triangles};
use super::lanes::{Backend, Floats};
use super::mesh::TriMesh;
use super::particles::{Ellipsoid8, Particles};
use super::ray::rank::{self, Winner, winner};
use super::ray::{BLOCKING_DEPTH, Hit, HitKind, Occlusion, Ray};
use super::scene::Geometry;
use super::simd::Stack;
use super::wide::{LEAF, Node8};

/// What a walk does at a leaf.
pub(super) trait Leaf<B: Backend> {
    /// Tests everything in block `block` and keeps the best.
    fn closest(&self, block: u32, best: &mut Best);
    /// Adds the optical depth of what stands in block `block` before `t_max`;
    /// more than `BLOCKING_DEPTH` ends the walk.
    fn dim(&self, block: u32, best: &Best, depth: &mut u32);
}

/// The closest hit of one ray.
#[inline(always)]
pub(super) fn intersect<B: Backend, const PARTICLES: bool>(
    scene: &Geometry,
    ray: &Ray,
    key: u64,
) -> Option<Hit> {
    if !ray.is_finite() {
        return None;
    }
    let mut best = Best::new(ray.t_max);
    if let Some(t) = scene.water_distance(ray)
        && t <= best.t
    {
        best.set(t, rank::WATER);
    }
    let (o, d) = (ray.o.to_array(), ray.d.to_array());
    let instances = Instances { scene, ray };
    if let Some(index) = scene.lone {
        Leaf::<B>::closest(&instances, index, &mut best);
    } else {
        walk_closest(
            scene.top.nodes(),
            0,
            &BoxRay::<B>::new(o, d),
            &instances,
            &mut best,
        );
    }
    if PARTICLES && let Some(particles) = &scene.particles {
        B::particles_closest(particles, o, d, key, &mut best);
    }
    finish(&best)
}

/// What stands between the ends of one ray.
#[inline(always)]
pub(super) fn transmittance<B: Backend, const PARTICLES: bool>(
    scene: &Geometry,
    ray: &Ray,
) -> Occlusion {
    if !ray.is_finite() {
        return Occlusion::CLEAR;
    }
    let best = Best::new(ray.t_max);
    if let Some(t) = scene.water_distance(ray)
        && t <= best.t
    {
        return Occlusion::BLOCKED;
    }
    let (o, d) = (ray.o.to_array(), ray.d.to_array());
    let instances = Instances { scene, ray };
    let mut depth = 0;
    if let Some(index) = scene.lone {
        Leaf::<B>::dim(&instances, index, &best, &mut depth);
    } else {
        walk_dimming(
            scene.top.nodes(),
            &BoxRay::<B>::new(o, d),
            &instances,
            &best,
            &mut depth,
        );
    }
    if PARTICLES
        && depth <= BLOCKING_DEPTH
        && let Some(particles) = &scene.particles
    {
        B::particles_dim(particles, o, d, best.t, &mut depth);
    }
    Occlusion::from_depth(depth)
}

/// The best hit in the caller's terms.
#[inline(always)]
pub(super) fn finish(best: &Best) -> Option<Hit> {
    let kind = match winner(best.rank) {
        Winner::Nothing => return None,
        Winner::Water => HitKind::Water,
        Winner::Triangle { instance, prim } => HitKind::Triangle {
            instance,
            prim,
            u: best.v / best.det,
            v: best.w / best.det,
        },
        Winner::Particle { prim, inside } => HitKind::Particle { prim, inside },
    };
    Some(Hit { t: best.t, kind })
}

/// Stack entry: entry distance above, child code below. Distances are not
/// negative, so entries order by distance, then by child.
#[inline(always)]
pub(super) fn entry(near: f32, child: u32) -> u64 {
    u64::from(near.to_bits()) << 32 | u64::from(child)
}

/// Nearest child first, until nothing on the stack begins before the best hit.
#[inline(always)]
pub(super) fn walk_closest<B: Backend, L: Leaf<B>>(
    nodes: &[Node8],
    root: u32,
    ray: &BoxRay<B>,
    leaf: &L,
    best: &mut Best,
) {
    let mut stack = Stack::new();
    let mut current = root;
    loop {
        if current & LEAF != 0 {
            leaf.closest(current & !LEAF, best);
        } else {
            let node = &nodes[current as usize];
            let (mask, near) = hit_boxes::<B>(node, ray, best.cull);
            if let Some(child) = push_children(node, mask, &near, &mut stack) {
                current = child;
                continue;
            }
        }
        current = loop {
            let Some(e) = stack.pop() else { return };
            if f32::from_bits((e >> 32) as u32) <= best.cull {
                break e as u32;
            }
        };
    }
}

/// The nearest child that was entered; the others wait on the stack.
#[inline(always)]
fn push_children(node: &Node8, mut mask: u32, near: &[f32; 8], stack: &mut Stack) -> Option<u32> {
    let mut take = || {
        let lane = (mask.trailing_zeros() & 7) as usize;
        let more = mask != 0;
        mask &= mask.wrapping_sub(1);
        more.then(|| entry(near[lane], node.child[lane]))
    };
    let first = take()?;
    let Some(second) = take() else {
        return Some(first as u32);
    };
    let (mut nearest, far) = if first < second {
        (first, second)
    } else {
        (second, first)
    };
    stack.push(far);
    let mut count = 1;
    while let Some(e) = take() {
        let far = if e < nearest {
            std::mem::replace(&mut nearest, e)
        } else {
            e
        };
        stack.push_sorted(far, count);
        count += 1;
    }
    Some(nearest as u32)
}

/// In any order, until the depth blocks.
#[inline(always)]
fn walk_dimming<B: Backend, L: Leaf<B>>(
    nodes: &[Node8],
    ray: &BoxRay<B>,
    leaf: &L,
    best: &Best,
    depth: &mut u32,
) {
    let mut stack = Stack::new();
    let mut current = 0;
    loop {
        if current & LEAF != 0 {
            leaf.dim(current & !LEAF, best, depth);
            if *depth > BLOCKING_DEPTH {
                return;
            }
        } else {
            let node = &nodes[current as usize];
            let (mut mask, _) = hit_boxes::<B>(node, ray, best.cull);
            if mask != 0 {
                current = node.child[(mask.trailing_zeros() & 7) as usize];
                mask &= mask - 1;
                while mask != 0 {
                    stack.push(u64::from(node.child[(mask.trailing_zeros() & 7) as usize]));
                    mask &= mask - 1;
                }
                continue;
            }
        }
        let Some(e) = stack.pop() else { return };
        current = e as u32;
    }
}

/// Leaves of the top tree: one instance each.
struct Instances<'a> {
    scene: &'a Geometry,
    ray: &'a Ray,
}

/// The closest hit of a ray with one mesh, both in mesh space.
#[inline(always)]
pub(super) fn mesh_closest<B: Backend>(
    mesh: &TriMesh,
    o: [f32; 3],
    d: [f32; 3],
    instance: u32,
    best: &mut Best,
) {
    let leaf = Triangles::<B> {
        mesh,
        ray: TriRay::new(o, d),
        instance,
    };
    walk_closest(mesh.tree.nodes(), 0, &BoxRay::new(o, d), &leaf, best);
}

/// True if a ray meets one mesh at `0 < t <= t_max`, both in mesh space.
#[inline(always)]
pub(super) fn mesh_dim<B: Backend>(mesh: &TriMesh, o: [f32; 3], d: [f32; 3], t_max: f32) -> bool {
    let leaf = Triangles::<B> {
        mesh,
        ray: TriRay::new(o, d),
        instance: 0,
    };
    let mut best = Best::new(t_max);
    best.set(t_max, rank::NOTHING);
    let mut depth = 0;
    walk_dimming(
        mesh.tree.nodes(),
        &BoxRay::new(o, d),
        &leaf,
        &best,
        &mut depth,
    );
    depth != 0
}

/// The closest wall of a particle that stops a ray.
#[inline(always)]
pub(super) fn particles_closest<B: Backend>(
    particles: &Particles,
    o: [f32; 3],
    d: [f32; 3],
    key: u64,
    best: &mut Best,
) {
    let leaf = Clouds::<B>::new(particles, o, d, key);
    walk_closest(particles.tree.nodes(), 0, &BoxRay::new(o, d), &leaf, best);
}

/// Adds the depths of the particles' walls at `0 < t <= t_max`.
#[inline(always)]
pub(super) fn particles_dim<B: Backend>(
    particles: &Particles,
    o: [f32; 3],
    d: [f32; 3],
    t_max: f32,
    depth: &mut u32,
) {
    let leaf = Clouds::<B>::new(particles, o, d, 0);
    walk_dimming(
        particles.tree.nodes(),
        &BoxRay::new(o, d),
        &leaf,
        &Best::until(t_max),
        depth,
    );
}

/// The closest hit of one ray with one instance.
#[inline(always)]
pub(super) fn closest_in_instance<B: Backend>(
    scene: &Geometry,
    ray: &Ray,
    index: u32,
    best: &mut Best,
) {
    Leaf::<B>::closest(&Instances { scene, ray }, index, best);
}

/// The closest hit of one ray with the instances below a node of the top tree.
#[inline(always)]
pub(super) fn closest_below<B: Backend>(
    scene: &Geometry,
    ray: &Ray,
    nodes: &[Node8],
    root: u32,
    best: &mut Best,
) {
    let boxes = BoxRay::<B>::new(ray.o.to_array(), ray.d.to_array());
    walk_closest(nodes, root, &boxes, &Instances { scene, ray }, best);
}

/// What one instance does to one ray.
#[inline(always)]
pub(super) fn dim_in_instance<B: Backend>(
    scene: &Geometry,
    ray: &Ray,
    index: u32,
    best: &Best,
    depth: &mut u32,
) {
    Leaf::<B>::dim(&Instances { scene, ray }, index, best, depth);
}

/// The ray in mesh space. The direction keeps its length, so `t` stays the same.
/// None if it leaves the floats' range there.
#[inline(always)]
pub(super) fn into_local(instance: &Instance, ray: &Ray) -> Option<([f32; 3], [f32; 3])> {
    let m = &instance.local_from_world;
    let o = m.transform_point3a(Vec3A::from(ray.o));
    let d = m.transform_vector3a(Vec3A::from(ray.d));
    (o.is_finite() && d.is_finite()).then(|| (o.to_array(), d.to_array()))
}

impl<B: Backend> Leaf<B> for Instances<'_> {
    #[inline(always)]
    fn closest(&self, index: u32, best: &mut Best) {
        let instance = &self.scene.instances[index as usize];
        if let Some((o, d)) = into_local(instance, self.ray) {
            B::mesh_closest(
                &self.scene.meshes[instance.mesh as usize],
                o,
                d,
                index,
                best,
            );
        }
    }
    #[inline(always)]
    fn dim(&self, index: u32, best: &Best, depth: &mut u32) {
        let instance = &self.scene.instances[index as usize];
        if let Some((o, d)) = into_local(instance, self.ray)
            && B::mesh_dim(&self.scene.meshes[instance.mesh as usize], o, d, best.t)
        {
            *depth = u32::MAX;
        }
    }
}

/// Leaves of a mesh: blocks of four triangles.
pub(super) struct Triangles<'a, B: Backend> {
    pub(super) mesh: &'a TriMesh,
    pub(super) ray: TriRay<B>,
    pub(super) instance: u32,
}

impl<B: Backend> Leaf<B> for Triangles<'_, B> {
    #[inline(always)]
    fn closest(&self, block: u32, best: &mut Best) {
        let block = &self.mesh.blocks[block as usize];
        let Some(hits) = hit_triangles::<B>(block, &self.ray, best.t) else {
            return;
        };
        let (t, v, w, det) = (
            hits.t.store(),
            hits.v.store(),
            hits.w.store(),
            hits.det.store(),
        );
        let mut mask = hits.mask;
        while mask != 0 {
            let lane = (mask.trailing_zeros() & 3) as usize;
            mask &= mask - 1;
            let rank = rank::triangle(self.instance, block.prim[lane]);
            if best.is_beaten_by(t[lane], rank) {
                best.set(t[lane], rank);
                (best.v, best.w, best.det) = (v[lane], w[lane], det[lane]);
            }
        }
    }
    #[inline(always)]
    fn dim(&self, block: u32, best: &Best, depth: &mut u32) {
        let block = &self.mesh.blocks[block as usize];
        if hit_triangles::<B>(block, &self.ray, best.t).is_some() {
            *depth = u32::MAX;
        }
    }
}

/// Leaves of the particles' tree: blocks of eight ellipsoids.
pub(super) struct Clouds<'a, B: Backend> {
    particles: &'a Particles,
    o: [B::F8; 3],
    d: [B::F8; 3],
    key: u64,
}

impl<'a, B: Backend> Clouds<'a, B> {
    #[inline(always)]
    pub(super) fn new(particles: &'a Particles, o: [f32; 3], d: [f32; 3], key: u64) -> Self {
        let splat = |x: [f32; 3]| [B::F8::splat(x[0]), B::F8::splat(x[1]), B::F8::splat(x[2])];
        Self {
            particles,
            o: splat(o),
            d: splat(d),
            key,
        }
    }

    #[inline(always)]
    fn cross(&self, block: &Ellipsoid8, t_far: f32) -> super::ellipsoid::Crossings<B::F8> {
        let load = |a: &[[f32; 8]; 3]| [B::F8::load(&a[0]), B::F8::load(&a[1]), B::F8::load(&a[2])];
        let mut c = cross_ellipsoids::<8, B::F8>(
            load(&block.centre),
            load(&block.inverse_radius),
            self.o,
            self.d,
            B::F8::splat(t_far),
        );
        c.near_mask &= block.used;
        c.far_mask &= block.used;
        c
    }
}

impl<B: Backend> Leaf<B> for Clouds<'_, B> {
    #[inline(always)]
    fn closest(&self, block: u32, best: &mut Best) {
        let block = &self.particles.blocks[block as usize];
        let c = self.cross(block, best.t);
        let distances = [c.near.store(), c.far.store()];
        // Near walls in the low half, far walls in the high half.
        let mut mask = c.near_mask | c.far_mask << 8;
        while mask != 0 {
            let bit = mask.trailing_zeros();
            mask &= mask - 1;
            let (lane, crossing) = ((bit & 7) as usize, bit >> 3 & 1);
            let t = distances[crossing as usize][lane];
            let rank = rank::particle(block.prim[lane], crossing);
            if best.is_beaten_by(t, rank)
                && is_stopped(self.key, block.prim[lane], crossing, block.threshold[lane])
            {
                best.set(t, rank);
            }
        }
    }
    #[inline(always)]
    fn dim(&self, block: u32, best: &Best, depth: &mut u32) {
        let block = &self.particles.blocks[block as usize];
        let c = self.cross(block, best.t);
        let mut mask = c.near_mask | c.far_mask << 8;
        while mask != 0 {
            let lane = (mask.trailing_zeros() & 7) as usize;
            mask &= mask - 1;
            *depth = depth.saturating_add(block.depth[lane]);
        }
    }
}
