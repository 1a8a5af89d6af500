//! What eight rays do at the leaves: see `packet`.

use super::best8::Best8;
use super::ellipsoid::{Crossings, cross_ellipsoids, is_stopped};
use super::kernels::{Best, BoxRay, TriHits, TriRay, hit_sheared, sheared_axes};
use super::lanes::{Backend, Floats};
use super::leaves::{Clouds, Triangles, into_local};
use super::mesh::{Tri4, TriMesh};
use super::packet::{Axes, Leaf8, PacketRay, each_lane, put};
use super::particles::{Ellipsoid8, Particles};
use super::ray::{BLOCKING_DEPTH, Ray, rank};
use super::scene::Geometry;
use super::single::{self, Leaf, walk_closest};
use super::wide::Node8;

/// Leaves of the top tree.
pub(super) struct Instances8<'a, const USES: u8> {
    pub(super) scene: &'a Geometry,
    pub(super) rays: &'a [Ray; 8],
}

impl<const USES: u8> Instances8<'_, USES> {
    /// The packet in mesh space; None if it is none there.
    #[inline(always)]
    fn enter<B: Backend>(&self, index: u32) -> Option<(PacketRay<B>, Triangles8<'_, B>)> {
        let instance = &self.scene.placement.instances[index as usize];
        let mesh = &self.scene.meshes[instance.mesh as usize];
        let mut o = [[0.0; 8]; 3];
        let mut d = [[0.0; 8]; 3];
        for (lane, ray) in self.rays.iter().enumerate() {
            let (from, along) = into_local::<USES>(instance, ray)?;
            put(&mut o, &mut d, lane, from, along);
        }
        Some((
            PacketRay::new(&o, &d)?,
            Triangles8::new(mesh, index, &o, &d)?,
        ))
    }
}

impl<B: Backend, const USES: u8> Leaf8<B> for Instances8<'_, USES> {
    #[inline(always)]
    fn closest(&self, block: u32, lanes: u32, best: &mut Best8) -> bool {
        if let Some((packet, leaf)) = self.enter::<B>(block) {
            B::mesh_closest8(&packet, &leaf, best);
            return true;
        }
        each_lane(lanes, |lane| {
            let mut one = best.lane(lane);
            single::closest_in_instance::<B, USES>(self.scene, &self.rays[lane], block, &mut one);
            best.set_lane(lane, &one);
        });
        true
    }
    #[inline(always)]
    fn closest_alone(&self, nodes: &[Node8], root: u32, lane: usize, best: &mut Best8) {
        let mut one = best.lane(lane);
        single::closest_below::<B, USES>(self.scene, &self.rays[lane], nodes, root, &mut one);
        best.set_lane(lane, &one);
    }
    #[inline(always)]
    fn dim(&self, block: u32, lanes: u32, best: &mut Best8, depth: &mut [u32; 8]) {
        if let Some((packet, leaf)) = self.enter::<B>(block) {
            B::mesh_dim8(&packet, &leaf, best, depth);
            return;
        }
        each_lane(lanes, |lane| {
            single::dim_in_instance::<B, USES>(
                self.scene,
                &self.rays[lane],
                block,
                &best.lane(lane),
                &mut depth[lane],
            );
            if depth[lane] > BLOCKING_DEPTH {
                best.t[lane] = -1.0;
            }
        });
    }
}

/// Leaves of a mesh, for rays with one main axis.
pub(super) struct Triangles8<'a, B: Backend> {
    /// Origins and directions, mesh space, for lanes that go alone.
    from: Axes,
    along: Axes,
    pub(super) mesh: &'a TriMesh,
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
        let of_lane = |lane: usize| sheared_axes([d[0][lane], d[1][lane], d[2][lane]]);
        let k = of_lane(0);
        if (1..8).any(|lane| of_lane(lane) != k) {
            return None;
        }
        let load = |a: &Axes| k.map(|axis| B::F8::load(&a[axis]));
        let (from, along) = (*o, *d);
        let d = load(d);
        let scale = B::F8::splat(1.0) / d[2];
        Some(Self {
            from,
            along,
            mesh,
            instance,
            k,
            o: load(o),
            d,
            shear: [d[0] * scale, d[1] * scale],
            scale,
        })
    }

    /// One lane as a ray of its own.
    #[inline(always)]
    fn alone(&self, lane: usize) -> ([f32; 3], [f32; 3], Triangles<'_, B>) {
        let (o, d) = (self.from.map(|a| a[lane]), self.along.map(|a| a[lane]));
        (
            o,
            d,
            Triangles {
                mesh: self.mesh,
                ray: TriRay::new(o, d),
                instance: self.instance,
            },
        )
    }

    /// One corner of a triangle in every lane, axes in the packet's order. A method
    /// and not a closure: what is not inlined loses its registers.
    #[inline(always)]
    fn corner(&self, block: &Tri4, lane: usize, vertex: usize) -> [B::F8; 3] {
        let [x, y, z] = self.k;
        [
            B::F8::splat(block.corner[x][vertex][lane]),
            B::F8::splat(block.corner[y][vertex][lane]),
            B::F8::splat(block.corner[z][vertex][lane]),
        ]
    }

    #[inline(always)]
    fn hit(&self, block: &Tri4, lane: usize, t_far: &[f32; 8]) -> Option<TriHits<B::F8>> {
        let corners = [
            self.corner(block, lane, 0),
            self.corner(block, lane, 1),
            self.corner(block, lane, 2),
        ];
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
    fn closest(&self, block: u32, lanes: u32, best: &mut Best8) -> bool {
        let number = block;
        let block = &self.mesh.blocks[block as usize];
        // Four triangles for each ray, or eight rays for each triangle.
        if (lanes.count_ones() as usize) < block.count() {
            each_lane(lanes, |lane| {
                let mut one = best.lane(lane);
                self.alone(lane).2.closest(number, &mut one);
                best.set_lane(lane, &one);
            });
            return true;
        }
        let mut changed = false;
        for lane in 0..block.count() {
            let Some(hits) = self.hit(block, lane, &best.t) else {
                continue;
            };
            changed = true;
            let (t, v, w, det) = (
                hits.t.store(),
                hits.v.store(),
                hits.w.store(),
                hits.det.store(),
            );
            let rank = rank::triangle(self.instance, block.prim[lane]);
            // A single ray would not have come here either.
            let mut mask = hits.mask & lanes;
            while mask != 0 {
                let ray = (mask.trailing_zeros() & 7) as usize;
                mask &= mask - 1;
                if best.is_beaten_by(ray, t[ray], rank) {
                    (best.t[ray], best.rank[ray]) = (t[ray], rank);
                    (best.v[ray], best.w[ray], best.det[ray]) = (v[ray], w[ray], det[ray]);
                }
            }
        }
        changed
    }
    #[inline(always)]
    fn closest_alone(&self, nodes: &[Node8], root: u32, lane: usize, best: &mut Best8) {
        let (o, d, leaf) = self.alone(lane);
        let mut one = best.lane(lane);
        walk_closest(nodes, root, &BoxRay::<B>::new(o, d), &leaf, &mut one);
        best.set_lane(lane, &one);
    }
    #[inline(always)]
    fn dim(&self, block: u32, lanes: u32, best: &mut Best8, depth: &mut [u32; 8]) {
        let number = block;
        let block = &self.mesh.blocks[block as usize];
        if (lanes.count_ones() as usize) < block.count() {
            each_lane(lanes, |lane| {
                let end = Best::until(best.t[lane]);
                self.alone(lane).2.dim(number, &end, &mut depth[lane]);
                if depth[lane] > BLOCKING_DEPTH {
                    best.t[lane] = -1.0;
                }
            });
            return;
        }
        for lane in 0..block.count() {
            let Some(hits) = self.hit(block, lane, &best.t) else {
                continue;
            };
            each_lane(hits.mask & lanes, |ray| {
                (best.t[ray], depth[ray]) = (-1.0, u32::MAX);
            });
        }
    }
}

/// Leaves of the particles' tree.
pub(super) struct Clouds8<'a, B: Backend> {
    pub(super) particles: &'a Particles,
    from: Axes,
    along: Axes,
    o: [B::F8; 3],
    d: [B::F8; 3],
    keys: &'a [u64; 8],
}

impl<'a, B: Backend> Clouds8<'a, B> {
    #[inline(always)]
    pub(super) fn new(particles: &'a Particles, o: &Axes, d: &Axes, keys: &'a [u64; 8]) -> Self {
        let load = |x: &Axes| [B::F8::load(&x[0]), B::F8::load(&x[1]), B::F8::load(&x[2])];
        Self {
            from: *o,
            along: *d,
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
    fn closest(&self, block: u32, lanes: u32, best: &mut Best8) -> bool {
        let block = &self.particles.blocks[block as usize];
        let mut changed = false;
        for lane in 0..block.count() {
            let c = self.cross(block, lane, &best.t);
            let mut mask = (c.near_mask & lanes) | (c.far_mask & lanes) << 8;
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
                    && is_stopped(self.keys[ray], rank::wall(rank), threshold)
                {
                    (best.t[ray], best.rank[ray]) = (t, rank);
                    changed = true;
                }
            }
        }
        changed
    }
    #[inline(always)]
    fn closest_alone(&self, nodes: &[Node8], root: u32, lane: usize, best: &mut Best8) {
        let (o, d) = (self.from.map(|a| a[lane]), self.along.map(|a| a[lane]));
        let leaf = Clouds::<B>::new(self.particles, o, d, self.keys[lane]);
        let mut one = best.lane(lane);
        walk_closest(nodes, root, &BoxRay::<B>::new(o, d), &leaf, &mut one);
        best.set_lane(lane, &one);
    }
    #[inline(always)]
    fn dim(&self, block: u32, lanes: u32, best: &mut Best8, depth: &mut [u32; 8]) {
        let block = &self.particles.blocks[block as usize];
        for lane in 0..block.count() {
            let c = self.cross(block, lane, &best.t);
            let mut mask = (c.near_mask & lanes) | (c.far_mask & lanes) << 8;
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
