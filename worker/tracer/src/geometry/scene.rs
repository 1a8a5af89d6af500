//! Everything a ray can meet, behind one set of queries.

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use std::sync::Arc;

use super::BuildError;
use super::collapse::collapse;
use super::instance::Instance;
use super::mesh::TriMesh;
use super::particles::Particles;
use super::ray::{Hit, Occlusion, Ray, rank};
use super::sah::{self, Splitter};
use super::simd::{self, Path};
use super::sprites::{FacingSprites, Sprites};
use super::wide::{LEAF, Node8, WideTree};

/// Meshes, where they stand, particles and water.
pub struct Geometry {
    pub(super) meshes: Arc<[TriMesh]>,
    pub(super) instances: Vec<Instance>,
    /// Leaves are instance numbers.
    pub(super) top: WideTree,
    /// The only instance, if there is but one: it needs no tree above it.
    pub(super) lone: Option<u32>,
    pub(super) particles: Option<Arc<Particles>>,
    pub(super) sprites: Option<FacingSprites>,
    water_y: Option<f32>,
    pub(super) path: Path,
}

impl Geometry {
    /// Puts everything together. `water_y` is the height of an endless opaque
    /// plane, metres.
    ///
    /// # Errors
    /// An instance of an unknown mesh, too many instances, or a water height that
    /// is not finite.
    pub fn build(
        meshes: impl Into<Arc<[TriMesh]>>,
        instances: Vec<Instance>,
        particles: Option<Arc<Particles>>,
        water_y: Option<f32>,
    ) -> Result<Self, BuildError> {
        let meshes = meshes.into();
        if water_y.is_some_and(|y| !y.is_finite()) {
            return Err(BuildError::WaterHeight);
        }
        if instances.len() >= rank::COUNT_MAX {
            let count = instances.len();
            return Err(BuildError::TooMany {
                what: "instances",
                count,
                limit: rank::COUNT_MAX,
            });
        }
        let (boxes, owners) = instance_boxes(&meshes, &instances)?;
        let lone = if let [only] = owners[..] {
            Some(only)
        } else {
            None
        };
        let top = match top_tree(&boxes, &owners, Splitter::Sah) {
            Err(BuildError::TooDeep { .. }) => top_tree(&boxes, &owners, Splitter::Median)?,
            other => other?,
        };
        Ok(Self {
            meshes,
            instances,
            top,
            lone,
            particles,
            sprites: None,
            water_y,
            path: Path::detect(),
        })
    }

    /// Adds sprites, turned to `eye` (world space, metres).
    #[must_use]
    pub fn with_sprites(mut self, sprites: Arc<Sprites>, eye: Vec3) -> Self {
        self.sprites = Some(FacingSprites { sprites, eye });
        self
    }

    /// Runs all queries without AVX2, as on a machine that lacks it. The results
    /// are the same bits; for tests and for comparison.
    #[must_use]
    pub fn without_avx2(mut self) -> Self {
        self.path = Path::Portable;
        self
    }

    /// The meshes, as given.
    pub fn meshes(&self) -> &[TriMesh] {
        &self.meshes
    }

    /// The instances, as given.
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }

    /// The particles, as given.
    pub fn particles(&self) -> Option<&Particles> {
        self.particles.as_deref()
    }

    /// Height of the water plane, metres.
    pub fn water_y(&self) -> Option<f32> {
        self.water_y
    }

    /// The closest hit at `0 < t < ray.t_max`. A particle's wall stops the ray with
    /// the chance of its opacity, decided by a hash of `key`, particle and wall (sprites
    /// alike):
    /// `key` must differ between samples and between the segments of a path. With
    /// `USES` without [`PARTICLES`](crate::uses::PARTICLES), both are ignored and
    /// cost nothing. A ray that is not
    /// finite hits nothing.
    #[inline]
    pub fn intersect<const USES: u8>(&self, ray: &Ray, key: u64) -> Option<Hit> {
        simd::intersect::<USES>(self, ray, key)
    }

    /// How much stands at `0 < t < ray.t_max`: triangles and water block, each
    /// crossing of a particle's wall or of a sprite adds its optical depth. Without
    /// [`PARTICLES`](crate::uses::PARTICLES) in `USES` they are ignored. A ray that is not finite is clear.
    #[inline]
    pub fn transmittance_depth<const USES: u8>(&self, ray: &Ray) -> Occlusion {
        simd::transmittance::<USES>(self, ray)
    }

    /// Eight times `intersect`, bit for bit; faster if the rays go much the same way
    /// (neighbouring camera rays), little slower if not.
    #[inline]
    pub fn intersect8<const USES: u8>(&self, rays: &[Ray; 8], keys: &[u64; 8]) -> [Option<Hit>; 8] {
        simd::intersect8::<USES>(self, rays, keys)
    }

    /// Eight times `transmittance_depth`, bit for bit; faster if the rays go much the
    /// same way (neighbouring rays to the sun).
    #[inline]
    pub fn transmittance_depth8<const USES: u8>(&self, rays: &[Ray; 8]) -> [Occlusion; 8] {
        simd::transmittance8::<USES>(self, rays)
    }

    /// Distance to the water plane, if the ray goes there.
    #[inline(always)]
    pub(super) fn water_distance(&self, ray: &Ray) -> Option<f32> {
        let t = (self.water_y? - ray.o.y) / ray.d.y;
        (t > 0.0 && t < ray.t_max).then_some(t)
    }
}

/// Vertices of all instances, each instance counted by itself, up to which their
/// world boxes are exact: about a second of work.
const EXACT_VERTICES_MAX: usize = 50_000_000;

/// World boxes of the instances that have any, and their numbers.
fn instance_boxes(
    meshes: &[TriMesh],
    instances: &[Instance],
) -> Result<(Vec<Aabb>, Vec<u32>), BuildError> {
    let mut boxes = Vec::with_capacity(instances.len());
    let mut owners = Vec::with_capacity(instances.len());
    let vertices = |i: &Instance| {
        meshes
            .get(i.mesh as usize)
            .map_or(0, |m| m.positions().len())
    };
    let exact = instances
        .iter()
        .map(vertices)
        .fold(0, usize::saturating_add)
        <= EXACT_VERTICES_MAX;
    for (index, instance) in instances.iter().enumerate() {
        let Some(mesh) = meshes.get(instance.mesh as usize) else {
            return Err(BuildError::MeshIndex {
                instance: index,
                mesh: instance.mesh,
                meshes: meshes.len(),
            });
        };
        if let Some((lo, hi)) = instance.world_bounds(mesh, exact) {
            boxes.push(Aabb::new(Vec3A::from(lo), Vec3A::from(hi)));
            owners.push(index as u32);
        }
    }
    Ok((boxes, owners))
}

/// A tree whose leaf codes are the instances themselves.
fn top_tree(boxes: &[Aabb], owners: &[u32], splitter: Splitter) -> Result<WideTree, BuildError> {
    let tree = collapse(&sah::build(boxes, splitter), 1, 1.0);
    let mut nodes: Vec<Node8> = tree.nodes;
    let blocks: Vec<u32> = tree
        .items
        .iter()
        .map(|&item| owners[item as usize])
        .collect();
    for node in &mut nodes {
        for child in &mut node.child {
            if *child & LEAF != 0
                && let Some(&owner) = blocks.get((*child & !LEAF) as usize)
            {
                *child = LEAF | owner;
            }
        }
    }
    WideTree::new(nodes)
}
