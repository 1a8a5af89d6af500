//! Semi-opaque ellipsoids, in a tree of their own.

use glam::Vec3;
use obvhs::aabb::Aabb;

use super::BuildError;
use super::collapse::collapse;
use super::ray::{BLOCKING_DEPTH, OPTICAL_DEPTH_SCALE, rank};
use super::sah::{self, Splitter};
use super::wide::WideTree;

/// Particles of a leaf block; the width of the vector test.
const BLOCK: u32 = 8;

/// A block test (a division and a root for eight) against a node test.
const BLOCK_COST: f32 = 1.5;

/// Boxes are widened by this part of their largest coordinate: the test works in
/// the unit sphere's space and rounds otherwise than the box.
const BOX_PAD: f32 = 16.0 * f32::EPSILON;

/// Scale of the acceptance threshold: a 31-bit hash is compared with
/// `opacity * 2^31`, so opacity 1 accepts every hash and 0 none.
const OPACITY_SCALE: f64 = 2_147_483_648.0;

/// An ellipsoid with its axes along the world's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    /// Centre, world space, metres.
    pub centre: Vec3,
    /// Half axes, metres, positive.
    pub radii: Vec3,
    /// Chance that one crossing of the wall stops a ray, 0 to 1. A ray that goes
    /// through crosses twice: (1 - opacity)^2 of the light passes.
    pub opacity: f32,
}

/// Eight ellipsoids, side by side.
#[repr(C, align(32))]
#[derive(Clone, Copy)]
pub(super) struct Ellipsoid8 {
    /// `centre[axis][lane]`, metres.
    pub(super) centre: [[f32; 8]; 3],
    /// One over the half axes.
    pub(super) inverse_radius: [[f32; 8]; 3],
    /// `opacity * 2^31`.
    pub(super) threshold: [u32; 8],
    /// Optical depth of one crossing, in units of 1 / `OPTICAL_DEPTH_SCALE`.
    pub(super) depth: [u32; 8],
    /// Original numbers.
    pub(super) prim: [u32; 8],
    /// Bit `i`: lane `i` is in use. The lowest lanes are.
    pub(super) used: u32,
}

impl Ellipsoid8 {
    /// Lanes in use.
    #[inline(always)]
    pub(super) fn count(&self) -> usize {
        self.used.trailing_ones().min(8) as usize
    }
}

/// Ellipsoids ready for rays.
pub struct Particles {
    pub(super) tree: WideTree,
    pub(super) blocks: Vec<Ellipsoid8>,
    pub(super) ellipsoids: Vec<Ellipsoid>,
}

impl Particles {
    /// Builds the tree.
    ///
    /// # Errors
    /// Values that are not finite, radii that are not positive, an opacity
    /// outside 0 to 1, too many particles, or a tree too deep to walk.
    pub fn build(ellipsoids: &[Ellipsoid]) -> Result<Self, BuildError> {
        if ellipsoids.len() > rank::COUNT_MAX {
            let count = ellipsoids.len();
            return Err(BuildError::TooMany {
                what: "particles",
                count,
                limit: rank::COUNT_MAX,
            });
        }
        if let Some(index) = ellipsoids.iter().position(|e| !is_valid(e)) {
            return Err(BuildError::Ellipsoid { index });
        }
        let boxes: Vec<Aabb> = ellipsoids.iter().map(bounds).collect();
        let build = |splitter| {
            let tree = collapse(&sah::build(&boxes, splitter), BLOCK, BLOCK_COST);
            let blocks = tree.blocks().map(|items| pack(items, ellipsoids)).collect();
            WideTree::new(tree.nodes).map(|tree| (tree, blocks))
        };
        let (tree, blocks) = match build(Splitter::Sah) {
            Err(BuildError::TooDeep { .. }) => build(Splitter::Median)?,
            other => other?,
        };
        Ok(Self {
            tree,
            blocks,
            ellipsoids: ellipsoids.to_vec(),
        })
    }

    /// The ellipsoids as given.
    pub fn ellipsoids(&self) -> &[Ellipsoid] {
        &self.ellipsoids
    }
}

fn is_valid(e: &Ellipsoid) -> bool {
    e.centre.is_finite()
        && e.radii.is_finite()
        && e.radii.min_element() > 0.0
        && e.radii.recip().is_finite()
        && (0.0..=1.0).contains(&e.opacity)
}

fn bounds(e: &Ellipsoid) -> Aabb {
    let reach = e.radii + Vec3::splat((e.centre.abs() + e.radii).max_element() * BOX_PAD);
    Aabb::new((e.centre - reach).into(), (e.centre + reach).into())
}

/// Optical depth of one crossing: `-ln(1 - opacity)`, rounded to units.
fn crossing_depth(opacity: f32) -> u32 {
    let depth = -libm::log1p(-f64::from(opacity)) * f64::from(OPTICAL_DEPTH_SCALE);
    // Opacity 1 gives infinity: the cast saturates and the sum blocks.
    (depth + 0.5).min(f64::from(BLOCKING_DEPTH) + 1.0) as u32
}

fn pack(items: &[u32], ellipsoids: &[Ellipsoid]) -> Ellipsoid8 {
    let mut block = Ellipsoid8 {
        centre: [[0.0; 8]; 3],
        inverse_radius: [[0.0; 8]; 3],
        threshold: [0; 8],
        depth: [0; 8],
        prim: [0; 8],
        used: 0,
    };
    for (lane, &prim) in items.iter().take(BLOCK as usize).enumerate() {
        let e = &ellipsoids[prim as usize];
        for axis in 0..3 {
            block.centre[axis][lane] = e.centre[axis];
            block.inverse_radius[axis][lane] = 1.0 / e.radii[axis];
        }
        block.threshold[lane] = (f64::from(e.opacity) * OPACITY_SCALE) as u32;
        block.depth[lane] = crossing_depth(e.opacity);
        block.prim[lane] = prim;
        block.used |= 1 << lane;
    }
    block
}
