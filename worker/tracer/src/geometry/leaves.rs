//! What one ray does at the leaves: instances, triangles, particles.

use glam::Vec3A;

use super::ellipsoid::{Crossings, cross_ellipsoids, is_stopped};
use super::instance::Instance;
use super::kernels::{Best, TriRay, hit_triangles};
use super::lanes::{Backend, Floats};
use super::mesh::TriMesh;
use super::particles::{Ellipsoid8, Particles};
use super::ray::{Ray, rank};
use super::scene::Geometry;
use super::single::Leaf;
use crate::uses::MOTION;

/// Leaves of the top tree: one instance each.
pub(super) struct Instances<'a, const USES: u8> {
    pub(super) scene: &'a Geometry,
    pub(super) ray: &'a Ray,
}

/// The ray in mesh space. The direction keeps its length, so `t` stays the same.
/// None if it leaves the floats' range there.
#[inline(always)]
pub(super) fn into_local<const USES: u8>(
    instance: &Instance,
    ray: &Ray,
) -> Option<([f32; 3], [f32; 3])> {
    if USES & MOTION != 0
        && let Some(motion) = &instance.motion
    {
        let (o, d) = motion.local_ray(ray);
        return (o.is_finite() && d.is_finite()).then(|| (o.to_array(), d.to_array()));
    }
    let m = &instance.local_from_world;
    let o = m.transform_point3a(Vec3A::from(ray.o));
    let d = m.transform_vector3a(Vec3A::from(ray.d));
    (o.is_finite() && d.is_finite()).then(|| (o.to_array(), d.to_array()))
}

impl<B: Backend, const USES: u8> Leaf<B> for Instances<'_, USES> {
    #[inline(always)]
    fn closest(&self, index: u32, best: &mut Best) {
        let instance = &self.scene.placement.instances[index as usize];
        if let Some((o, d)) = into_local::<USES>(instance, self.ray) {
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
        let instance = &self.scene.placement.instances[index as usize];
        if let Some((o, d)) = into_local::<USES>(instance, self.ray)
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
    fn cross(&self, block: &Ellipsoid8, t_far: f32) -> Crossings<B::F8> {
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
                && is_stopped(self.key, rank::wall(rank), block.threshold[lane])
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
