//! What rays do at the leaves of the sprites' tree, one by one and eight at once.

use glam::Vec3;

use super::best8::Best8;
use super::ellipsoid::is_stopped;
use super::kernels::{Best, BoxRay};
use super::lanes::{Backend, Floats};
use super::packet::{Axes, Leaf8, each_lane};
use super::ray::{BLOCKING_DEPTH, rank};
use super::single::{Leaf, walk_closest};
use super::sprites::{DiscHits, FacingSprites, Sprite8, Sprites, depth, hit_discs, threshold};
use super::wide::Node8;

/// Leaves for one ray: blocks of eight sprites.
pub(super) struct Discs<'a, B: Backend> {
    sprites: &'a Sprites,
    eye: [B::F8; 3],
    o: [B::F8; 3],
    d: [B::F8; 3],
    key: u64,
}

#[inline(always)]
fn splat<B: Backend>(x: [f32; 3]) -> [B::F8; 3] {
    [B::F8::splat(x[0]), B::F8::splat(x[1]), B::F8::splat(x[2])]
}

#[inline(always)]
fn load<B: Backend>(x: &[[f32; 8]; 3]) -> [B::F8; 3] {
    [B::F8::load(&x[0]), B::F8::load(&x[1]), B::F8::load(&x[2])]
}

impl<'a, B: Backend> Discs<'a, B> {
    #[inline(always)]
    pub(super) fn new(facing: &'a FacingSprites, o: [f32; 3], d: [f32; 3], key: u64) -> Self {
        Self {
            sprites: &facing.sprites,
            eye: splat::<B>(facing.eye.to_array()),
            o: splat::<B>(o),
            d: splat::<B>(d),
            key,
        }
    }

    #[inline(always)]
    fn hit(&self, block: &Sprite8, t_far: f32) -> DiscHits<B::F8> {
        let mut hits = hit_discs::<8, B::F8>(
            load::<B>(&block.centre),
            [B::F8::load(&block.middle), B::F8::load(&block.fall)],
            self.eye,
            self.o,
            self.d,
            B::F8::splat(t_far),
        );
        hits.mask &= block.used;
        hits
    }
}

impl<B: Backend> Leaf<B> for Discs<'_, B> {
    #[inline(always)]
    fn closest(&self, block: u32, best: &mut Best) {
        let block = &self.sprites.blocks[block as usize];
        let hits = self.hit(block, best.t);
        let (t, level) = (hits.t.store(), hits.level.store());
        let mut mask = hits.mask;
        while mask != 0 {
            let lane = (mask.trailing_zeros() & 7) as usize;
            mask &= mask - 1;
            let rank = rank::sprite(block.prim[lane]);
            if best.is_beaten_by(t[lane], rank)
                && is_stopped(
                    self.key,
                    rank::wall(rank),
                    threshold(block.opacity[lane], level[lane]),
                )
            {
                best.set(t[lane], rank);
            }
        }
    }
    #[inline(always)]
    fn dim(&self, block: u32, best: &Best, sum: &mut u32) {
        let block = &self.sprites.blocks[block as usize];
        let hits = self.hit(block, best.t);
        let level = hits.level.store();
        let mut mask = hits.mask;
        while mask != 0 {
            let lane = (mask.trailing_zeros() & 7) as usize;
            mask &= mask - 1;
            *sum = sum.saturating_add(depth(block.opacity[lane], level[lane]));
        }
    }
}

/// Leaves for eight rays.
pub(super) struct Discs8<'a, B: Backend> {
    pub(super) facing: &'a FacingSprites,
    from: Axes,
    along: Axes,
    o: [B::F8; 3],
    d: [B::F8; 3],
    keys: &'a [u64; 8],
}

impl<'a, B: Backend> Discs8<'a, B> {
    #[inline(always)]
    pub(super) fn new(facing: &'a FacingSprites, o: &Axes, d: &Axes, keys: &'a [u64; 8]) -> Self {
        Self {
            facing,
            from: *o,
            along: *d,
            o: load::<B>(o),
            d: load::<B>(d),
            keys,
        }
    }

    #[inline(always)]
    fn hit(&self, block: &Sprite8, lane: usize, t_far: &[f32; 8]) -> DiscHits<B::F8> {
        let eye: Vec3 = self.facing.eye;
        hit_discs::<8, B::F8>(
            splat::<B>(block.centre.map(|axis| axis[lane])),
            [
                B::F8::splat(block.middle[lane]),
                B::F8::splat(block.fall[lane]),
            ],
            splat::<B>(eye.to_array()),
            self.o,
            self.d,
            B::F8::load(t_far),
        )
    }
}

impl<B: Backend> Leaf8<B> for Discs8<'_, B> {
    #[inline(always)]
    fn closest(&self, block: u32, lanes: u32, best: &mut Best8) -> bool {
        let block = &self.facing.sprites.blocks[block as usize];
        let mut changed = false;
        for lane in 0..block.count() {
            let hits = self.hit(block, lane, &best.t);
            let mut mask = hits.mask & lanes;
            if mask == 0 {
                continue;
            }
            let (t, level) = (hits.t.store(), hits.level.store());
            let rank = rank::sprite(block.prim[lane]);
            while mask != 0 {
                let ray = (mask.trailing_zeros() & 7) as usize;
                mask &= mask - 1;
                if best.is_beaten_by(ray, t[ray], rank)
                    && is_stopped(
                        self.keys[ray],
                        rank::wall(rank),
                        threshold(block.opacity[lane], level[ray]),
                    )
                {
                    (best.t[ray], best.rank[ray]) = (t[ray], rank);
                    changed = true;
                }
            }
        }
        changed
    }
    #[inline(always)]
    fn closest_alone(&self, nodes: &[Node8], root: u32, lane: usize, best: &mut Best8) {
        let (o, d) = (self.from.map(|a| a[lane]), self.along.map(|a| a[lane]));
        let leaf = Discs::<B>::new(self.facing, o, d, self.keys[lane]);
        let mut one = best.lane(lane);
        walk_closest(nodes, root, &BoxRay::<B>::new(o, d), &leaf, &mut one);
        best.set_lane(lane, &one);
    }
    #[inline(always)]
    fn dim(&self, block: u32, lanes: u32, best: &mut Best8, sums: &mut [u32; 8]) {
        let block = &self.facing.sprites.blocks[block as usize];
        for lane in 0..block.count() {
            let hits = self.hit(block, lane, &best.t);
            let mask = hits.mask & lanes;
            if mask == 0 {
                continue;
            }
            let level = hits.level.store();
            each_lane(mask, |ray| {
                sums[ray] = sums[ray].saturating_add(depth(block.opacity[lane], level[ray]));
                if sums[ray] > BLOCKING_DEPTH {
                    best.t[ray] = -1.0;
                }
            });
        }
    }
}
