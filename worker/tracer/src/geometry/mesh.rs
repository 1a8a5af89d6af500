//! One mesh: its triangles in a tree, in mesh space.

use glam::{DVec3, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::splits::split_aabbs_preset;
use obvhs::triangle::Triangle;

use super::BuildError;
use super::collapse::collapse;
use super::sah::{self, Splitter};
use super::wide::{LEAF, Node8, WideTree};

/// Most triangles of a mesh: block indices and split references stay below 2^31.
const TRIANGLES_MAX: usize = 1 << 28;

/// Triangles of a leaf block; the width of the vector test.
const BLOCK: u32 = 4;

/// A block test against a node test, in the collapse's cost.
const BLOCK_COST: f32 = 1.0;

/// A split box is widened by this part of its largest coordinate: the clipping
/// interpolates in `f32`, and a triangle must not stick out of its boxes.
const SPLIT_PAD: f32 = 4.0 * f32::EPSILON;

/// Four triangles, side by side.
#[repr(C, align(32))]
#[derive(Clone, Copy)]
pub(super) struct Tri4 {
    /// `corner[axis][vertex][lane]`.
    pub(super) corner: [[[f32; 4]; 3]; 3],
    /// Original triangle numbers. A short block repeats its first triangle.
    pub(super) prim: [u32; 4],
}

impl Tri4 {
    /// Triangles in the block, without the repetitions.
    #[inline(always)]
    pub(super) fn count(&self) -> usize {
        (1..4)
            .take_while(|&lane| self.prim[lane] != self.prim[0])
            .count()
            + 1
    }
}

/// A triangle mesh ready for rays.
pub struct TriMesh {
    pub(super) tree: WideTree,
    pub(super) blocks: Vec<Tri4>,
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

impl TriMesh {
    /// Builds the tree. `positions` in mesh space, metres; each triangle names
    /// three of them. Triangles with a vertex that is not finite are never hit,
    /// nor are those without area; both keep their numbers.
    ///
    /// # Errors
    /// An index out of range, too many triangles, or a tree too deep to walk.
    pub fn build(positions: &[Vec3], triangles: &[[u32; 3]]) -> Result<Self, BuildError> {
        check(positions, triangles)?;
        let (corners, prims) = finite_triangles(positions, triangles);
        let (boxes, owners) = references(&corners);
        let build = |splitter| {
            let tree = collapse(&sah::build(&boxes, splitter), BLOCK, BLOCK_COST);
            let blocks = tree
                .blocks()
                .map(|items| pack(items, &owners, &corners, &prims))
                .collect();
            WideTree::new(tree.nodes).map(|tree| (tree, blocks))
        };
        let (tree, blocks) = match build(Splitter::Sah) {
            Err(BuildError::TooDeep { .. }) => build(Splitter::Median)?,
            other => other?,
        };
        Ok(Self {
            tree,
            blocks,
            positions: positions.to_vec(),
            triangles: triangles.to_vec(),
        })
    }

    /// The vertices, mesh space.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// Corners of the boxes below the root: their hull holds the mesh.
    pub(super) fn root_corners(&self) -> impl Iterator<Item = DVec3> + '_ {
        let root = &self.tree.nodes()[0];
        used(root).flat_map(move |slot| corners(root, slot))
    }

    /// Corners of the boxes two levels below the root, where there are such: a
    /// closer hull.
    pub(super) fn inner_corners(&self) -> impl Iterator<Item = DVec3> + '_ {
        let nodes = self.tree.nodes();
        let root = &nodes[0];
        used(root).flat_map(move |slot| {
            let child = root.child[slot];
            let below = (child & LEAF == 0).then(|| &nodes[child as usize]);
            let inner = below
                .into_iter()
                .flat_map(|node| used(node).flat_map(move |slot| corners(node, slot)));
            let own = below.is_none().then(|| corners(root, slot));
            inner.chain(own.into_iter().flatten())
        })
    }

    /// The corners of a triangle by its original number, mesh space; zeros for
    /// one that does not exist.
    pub fn corners(&self, prim: u32) -> [Vec3; 3] {
        let Some(indices) = self.triangles.get(prim as usize) else {
            return [Vec3::ZERO; 3];
        };
        indices.map(|i| self.positions[i as usize])
    }
}

/// Slots of a node that hold something.
fn used(node: &Node8) -> impl Iterator<Item = usize> + '_ {
    (0..8).filter(|&slot| node.planes[0][0][slot] <= node.planes[0][1][slot])
}

/// Corners of the box of a slot: bit `axis` of a corner's number picks the lower
/// or the upper bound.
fn corners(node: &Node8, slot: usize) -> impl Iterator<Item = DVec3> + '_ {
    let bound =
        move |corner: usize, axis: usize| f64::from(node.planes[axis][corner >> axis & 1][slot]);
    (0..8).map(move |corner| DVec3::new(bound(corner, 0), bound(corner, 1), bound(corner, 2)))
}

fn check(positions: &[Vec3], triangles: &[[u32; 3]]) -> Result<(), BuildError> {
    if triangles.len() > TRIANGLES_MAX {
        return Err(BuildError::TooMany {
            what: "triangles",
            count: triangles.len(),
            limit: TRIANGLES_MAX,
        });
    }
    for (triangle, indices) in triangles.iter().enumerate() {
        for &vertex in indices {
            if vertex as usize >= positions.len() {
                return Err(BuildError::VertexIndex {
                    triangle,
                    vertex,
                    vertices: positions.len(),
                });
            }
        }
    }
    Ok(())
}

/// Corners of the triangles that can be hit, and their original numbers.
fn finite_triangles(positions: &[Vec3], triangles: &[[u32; 3]]) -> (Vec<Triangle>, Vec<u32>) {
    let mut corners = Vec::with_capacity(triangles.len());
    let mut prims = Vec::with_capacity(triangles.len());
    for (prim, indices) in triangles.iter().enumerate() {
        let [v0, v1, v2] = indices.map(|i| Vec3A::from(positions[i as usize]));
        if v0.is_finite() && v1.is_finite() && v2.is_finite() {
            corners.push(Triangle { v0, v1, v2 });
            prims.push(prim as u32);
        }
    }
    (corners, prims)
}

/// Boxes to build over, and the triangle each belongs to: one per triangle, more
/// for slender diagonal ones (beams, stays), whose single box would be mostly air.
fn references(corners: &[Triangle]) -> (Vec<Aabb>, Vec<u32>) {
    let whole: Vec<Aabb> = corners.iter().map(Triangle::aabb).collect();
    let mut boxes = whole.clone();
    let mut owners: Vec<u32> = (0..corners.len() as u32).collect();
    let mut sum = 0.0_f64;
    let mut largest = 0.0_f32;
    for b in &boxes {
        sum += f64::from(b.half_area());
        largest = largest.max(b.half_area());
    }
    if boxes.is_empty() || !largest.is_finite() {
        return (boxes, owners);
    }
    let average = (sum / boxes.len() as f64) as f32;
    split_aabbs_preset(&mut boxes, &mut owners, corners, average, largest);
    for (b, &owner) in boxes.iter_mut().zip(&owners) {
        let whole = &whole[owner as usize];
        if b != whole {
            let pad = Vec3A::splat(b.min.abs().max(b.max.abs()).max_element() * SPLIT_PAD);
            b.min = (b.min - pad).max(whole.min);
            b.max = (b.max + pad).min(whole.max);
        }
    }
    (boxes, owners)
}

/// The block for some references; each triangle stands in it once.
fn pack(items: &[u32], owners: &[u32], corners: &[Triangle], prims: &[u32]) -> Tri4 {
    let mut members = [0_u32; BLOCK as usize];
    let mut count = 0;
    for &item in items {
        let owner = owners[item as usize];
        if !members[..count].contains(&owner) && count < members.len() {
            members[count] = owner;
            count += 1;
        }
    }
    let mut block = Tri4 {
        corner: [[[0.0; 4]; 3]; 3],
        prim: [0; 4],
    };
    for lane in 0..members.len() {
        let owner = members[if lane < count { lane } else { 0 }] as usize;
        let t = &corners[owner];
        for (vertex, v) in [t.v0, t.v1, t.v2].iter().enumerate() {
            for axis in 0..3 {
                block.corner[axis][vertex][lane] = v[axis];
            }
        }
        block.prim[lane] = prims[owner];
    }
    block
}
