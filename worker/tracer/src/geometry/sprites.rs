//! Soft discs that face a point, in a tree of their own.

use glam::Vec3;
use obvhs::aabb::Aabb;
use std::sync::Arc;

use super::BuildError;
use super::collapse::collapse;
use super::lanes::{Floats, LaneMask};
use super::ray::{BLOCKING_DEPTH, OPTICAL_DEPTH_SCALE, rank};
use super::sah::{self, Splitter};
use super::wide::WideTree;
use crate::math::elementary::log1p;

/// Sprites of a leaf block; the width of the vector test.
const BLOCK: u32 = 8;

/// A block test (one division for eight) against a node test.
const BLOCK_COST: f32 = 1.5;

/// Boxes are widened by this part of their largest coordinate: the test works
/// along the ray and rounds otherwise than the box.
const BOX_PAD: f32 = 16.0 * f32::EPSILON;

/// Scale of the acceptance threshold, as of particles.
const OPACITY_SCALE: f32 = 2_147_483_648.0;

/// Square of the sine of the angle below which a ray runs along a disc and misses
/// it: the distance would be noise.
const EDGE_ON: f32 = 1.0 / (1_u64 << 40) as f32;

/// A disc whose opacity falls smoothly to 0 at its rim. With q = 1 - (r / radius)^2,
/// it is `opacity * min(q / softness, 1)^2` at the distance r from the centre. q is
/// uniform over the disc, so the mean is `opacity * (1 - 2/3 softness)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sprite {
    /// Centre, world space, metres.
    pub centre: Vec3,
    /// Radius, metres, positive.
    pub radius: f32,
    /// Chance that the middle stops a ray, 0 to 1.
    pub opacity: f32,
    /// Share of the area over which opacity falls, above 0, at most 1.
    pub softness: f32,
}

/// Eight sprites, side by side.
#[repr(C, align(32))]
#[derive(Clone, Copy)]
pub(super) struct Sprite8 {
    /// `centre[axis][lane]`, metres.
    pub(super) centre: [[f32; 8]; 3],
    /// `q / softness` in the middle.
    pub(super) middle: [f32; 8],
    /// Fall of that per square metre of r^2.
    pub(super) fall: [f32; 8],
    /// Opacity in the middle.
    pub(super) opacity: [f32; 8],
    /// Original numbers.
    pub(super) prim: [u32; 8],
    /// Bit `i`: lane `i` is in use. The lowest lanes are.
    pub(super) used: u32,
}

impl Sprite8 {
    /// Lanes in use.
    #[inline(always)]
    pub(super) fn count(&self) -> usize {
        self.used.trailing_ones().min(8) as usize
    }
}

/// Sprites ready for rays. They turn about their centres, so the boxes are those
/// of spheres and the tree serves every frame.
pub struct Sprites {
    pub(super) tree: WideTree,
    pub(super) blocks: Vec<Sprite8>,
    sprites: Vec<Sprite>,
}

/// Sprites, and the point that they face.
pub(super) struct FacingSprites {
    pub(super) sprites: Arc<Sprites>,
    /// World space, metres.
    pub(super) eye: Vec3,
}

impl Sprites {
    /// Builds the tree.
    ///
    /// # Errors
    /// Values out of their ranges, too many sprites, or a tree too deep to walk.
    pub fn build(sprites: Vec<Sprite>) -> Result<Self, BuildError> {
        if sprites.len() > rank::COUNT_MAX {
            let count = sprites.len();
            return Err(BuildError::TooMany {
                what: "sprites",
                count,
                limit: rank::COUNT_MAX,
            });
        }
        if let Some(index) = sprites.iter().position(|s| !is_valid(s)) {
            return Err(BuildError::Sprite { index });
        }
        let boxes: Vec<Aabb> = sprites.iter().map(bounds).collect();
        let build = |splitter| {
            let tree = collapse(&sah::build(&boxes, splitter), BLOCK, BLOCK_COST);
            let blocks = tree.blocks().map(|items| pack(items, &sprites)).collect();
            WideTree::new(tree.nodes).map(|tree| (tree, blocks))
        };
        let (tree, blocks) = match build(Splitter::Sah) {
            Err(BuildError::TooDeep { .. }) => build(Splitter::Median)?,
            other => other?,
        };
        Ok(Self {
            tree,
            blocks,
            sprites,
        })
    }

    /// The sprites as given.
    pub fn sprites(&self) -> &[Sprite] {
        &self.sprites
    }
}

fn is_valid(s: &Sprite) -> bool {
    let [middle, fall] = profile(s);
    s.centre.is_finite()
        && s.radius > 0.0
        && s.radius.is_finite()
        && (0.0..=1.0).contains(&s.opacity)
        && s.softness > 0.0
        && s.softness <= 1.0
        && middle.is_finite()
        && fall.is_normal()
}

fn bounds(s: &Sprite) -> Aabb {
    let reach = s.radius + (s.centre.abs().max_element() + s.radius) * BOX_PAD;
    Aabb::new(
        (s.centre - Vec3::splat(reach)).into(),
        (s.centre + Vec3::splat(reach)).into(),
    )
}

/// `q / softness` in the middle and its fall per square metre.
fn profile(s: &Sprite) -> [f32; 2] {
    let middle = 1.0 / s.softness;
    [middle, middle / (s.radius * s.radius)]
}

fn pack(items: &[u32], sprites: &[Sprite]) -> Sprite8 {
    let mut block = Sprite8 {
        centre: [[0.0; 8]; 3],
        middle: [0.0; 8],
        fall: [0.0; 8],
        opacity: [0.0; 8],
        prim: [0; 8],
        used: 0,
    };
    for (lane, &prim) in items.iter().take(BLOCK as usize).enumerate() {
        let s = &sprites[prim as usize];
        for axis in 0..3 {
            block.centre[axis][lane] = s.centre[axis];
        }
        [block.middle[lane], block.fall[lane]] = profile(s);
        block.opacity[lane] = s.opacity;
        block.prim[lane] = prim;
        block.used |= 1 << lane;
    }
    block
}

/// Where a ray meets discs, lane by lane.
pub(super) struct DiscHits<V> {
    /// Bit `i`: lane `i` is met at `0 < t <= t_far`.
    pub(super) mask: u32,
    pub(super) t: V,
    /// `q / softness`, above 0 where met; 1 and above is the full opacity.
    pub(super) level: V,
}

/// A ray against discs that face `eye`. The way from centre to eye is the normal,
/// of any length: all that it enters are ratios.
#[inline(always)]
pub(super) fn hit_discs<const N: usize, V: Floats<N>>(
    centre: [V; 3],
    [middle, fall]: [V; 2],
    eye: [V; 3],
    o: [V; 3],
    d: [V; 3],
    t_far: V,
) -> DiscHits<V> {
    let zero = V::splat(0.0);
    let minus = |a: [V; 3], b: [V; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let n = minus(eye, centre);
    let w = minus(o, centre);
    let along = n[0] * d[0] + n[1] * d[1] + n[2] * d[2];
    let height = n[0] * w[0] + n[1] * w[1] + n[2] * w[2];
    let square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    // An eye in the very centre has no direction: 0 / 0, which nothing accepts.
    let t = (zero - height) / along;
    let (x, y, z) = (w[0] + t * d[0], w[1] + t * d[1], w[2] + t * d[2]);
    let level = middle - (x * x + y * y + z * z) * fall;
    let met = zero.lt(level).and(zero.lt(t)).and(t.le(t_far));
    let facing = (square * V::splat(EDGE_ON)).le(along * along);
    DiscHits {
        mask: met.and(facing).bits(),
        t,
        level,
    }
}

/// Opacity of a sprite where its level is `level`.
#[inline(always)]
fn opacity_at(opacity: f32, level: f32) -> f32 {
    let x = if level < 1.0 { level } else { 1.0 };
    opacity * (x * x)
}

/// For the hash of a crossing: `opacity * 2^31`.
#[inline(always)]
pub(super) fn threshold(opacity: f32, level: f32) -> u32 {
    (opacity_at(opacity, level) * OPACITY_SCALE) as u32
}

/// Optical depth of a crossing: `-ln(1 - opacity)`, rounded to units.
#[inline(always)]
pub(super) fn depth(opacity: f32, level: f32) -> u32 {
    let alpha = opacity_at(opacity, level);
    if alpha >= 1.0 {
        return BLOCKING_DEPTH + 1;
    }
    (log1p(-alpha) * -OPTICAL_DEPTH_SCALE + 0.5) as u32
}
