//! Walks of one ray: the closest hit, and what dims it.

use super::kernels::{Best, BoxRay, TriRay, hit_boxes};
use super::lanes::Backend;
use super::leaves::{Clouds, Instances, Triangles};
use super::mesh::TriMesh;
use super::particles::Particles;
use super::ray::rank::{self, Winner, winner};
use super::ray::{BLOCKING_DEPTH, Hit, HitKind, Occlusion, Ray};
use super::scene::Geometry;
use super::simd::Stack;
use super::sprite_leaves::Discs;
use super::sprites::FacingSprites;
use super::wide::{LEAF, Node8};
use crate::uses::PARTICLES;

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
pub(super) fn intersect<B: Backend, const USES: u8>(
    scene: &Geometry,
    ray: &Ray,
    key: u64,
) -> Option<Hit> {
    if !ray.is_finite() {
        return None;
    }
    let mut best = Best::new(ray.t_max);
    if let Some(t) = scene.water_distance::<USES>(ray)
        && t <= best.t
    {
        best.set(t, rank::WATER);
    }
    let (o, d) = (ray.o.to_array(), ray.d.to_array());
    let instances = Instances::<USES> { scene, ray };
    if let Some(index) = scene.placement.lone {
        Leaf::<B>::closest(&instances, index, &mut best);
    } else {
        walk_closest(
            scene.placement.top.nodes(),
            0,
            &BoxRay::<B>::new(o, d),
            &instances,
            &mut best,
        );
    }
    if USES & PARTICLES != 0
        && let Some(particles) = &scene.particles
    {
        B::particles_closest(particles, o, d, key, &mut best);
    }
    if USES & PARTICLES != 0
        && let Some(sprites) = &scene.sprites
    {
        B::sprites_closest(sprites, o, d, key, &mut best);
    }
    finish(&best)
}

/// What stands between the ends of one ray.
#[inline(always)]
pub(super) fn transmittance<B: Backend, const USES: u8>(scene: &Geometry, ray: &Ray) -> Occlusion {
    if !ray.is_finite() {
        return Occlusion::CLEAR;
    }
    let best = Best::new(ray.t_max);
    if let Some(t) = scene.water_distance::<USES>(ray)
        && t <= best.t
    {
        return Occlusion::BLOCKED;
    }
    let (o, d) = (ray.o.to_array(), ray.d.to_array());
    let instances = Instances::<USES> { scene, ray };
    let mut depth = 0;
    if let Some(index) = scene.placement.lone {
        Leaf::<B>::dim(&instances, index, &best, &mut depth);
    } else {
        walk_dimming(
            scene.placement.top.nodes(),
            &BoxRay::<B>::new(o, d),
            &instances,
            &best,
            &mut depth,
        );
    }
    if USES & PARTICLES != 0
        && depth <= BLOCKING_DEPTH
        && let Some(particles) = &scene.particles
    {
        B::particles_dim(particles, o, d, best.t, &mut depth);
    }
    if USES & PARTICLES != 0
        && depth <= BLOCKING_DEPTH
        && let Some(sprites) = &scene.sprites
    {
        B::sprites_dim(sprites, o, d, best.t, &mut depth);
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
        Winner::Sprite { prim } => HitKind::Sprite { prim },
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

/// The closest sprite that stops a ray.
#[inline(always)]
pub(super) fn sprites_closest<B: Backend>(
    sprites: &FacingSprites,
    o: [f32; 3],
    d: [f32; 3],
    key: u64,
    best: &mut Best,
) {
    let leaf = Discs::<B>::new(sprites, o, d, key);
    let nodes = sprites.sprites.tree.nodes();
    walk_closest(nodes, 0, &BoxRay::new(o, d), &leaf, best);
}

/// Adds the depths of the sprites at `0 < t <= t_max`.
#[inline(always)]
pub(super) fn sprites_dim<B: Backend>(
    sprites: &FacingSprites,
    o: [f32; 3],
    d: [f32; 3],
    t_max: f32,
    depth: &mut u32,
) {
    let leaf = Discs::<B>::new(sprites, o, d, 0);
    let nodes = sprites.sprites.tree.nodes();
    walk_dimming(nodes, &BoxRay::new(o, d), &leaf, &Best::until(t_max), depth);
}

/// The closest hit of one ray with one instance.
#[inline(always)]
pub(super) fn closest_in_instance<B: Backend, const USES: u8>(
    scene: &Geometry,
    ray: &Ray,
    index: u32,
    best: &mut Best,
) {
    Leaf::<B>::closest(&Instances::<USES> { scene, ray }, index, best);
}

/// The closest hit of one ray with the instances below a node of the top tree.
#[inline(always)]
pub(super) fn closest_below<B: Backend, const USES: u8>(
    scene: &Geometry,
    ray: &Ray,
    nodes: &[Node8],
    root: u32,
    best: &mut Best,
) {
    let boxes = BoxRay::<B>::new(ray.o.to_array(), ray.d.to_array());
    walk_closest(nodes, root, &boxes, &Instances::<USES> { scene, ray }, best);
}

/// What one instance does to one ray.
#[inline(always)]
pub(super) fn dim_in_instance<B: Backend, const USES: u8>(
    scene: &Geometry,
    ray: &Ray,
    index: u32,
    best: &Best,
    depth: &mut u32,
) {
    Leaf::<B>::dim(&Instances::<USES> { scene, ray }, index, best, depth);
}
