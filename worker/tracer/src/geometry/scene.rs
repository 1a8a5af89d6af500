//! Everything a ray can meet, behind one set of queries.

use glam::Vec3;
use std::sync::Arc;

use super::BuildError;
use super::instance::Instance;
use super::mesh::TriMesh;
use super::particles::Particles;
use super::placement::Placement;
use super::ray::{Hit, Occlusion, Ray};
use super::simd::{self, Path};
use super::sprites::{FacingSprites, Sprites};
use crate::uses::{MOTION, NOTHING, PARTICLES, SURROUNDINGS};

/// Calls the copy of a query that what the scene uses needs. Media are none of the
/// geometry's business: sets that differ only there share a copy.
macro_rules! copies {
    ($query:path, $uses:ident, $args:tt) => {{
        use $query as query;
        match $uses & (PARTICLES | MOTION) {
            NOTHING if $uses & SURROUNDINGS == 0 => query::<NOTHING> $args,
            NOTHING => query::<SURROUNDINGS> $args,
            PARTICLES => query::<{ PARTICLES | SURROUNDINGS }> $args,
            MOTION => query::<{ MOTION | SURROUNDINGS }> $args,
            _ => query::<{ PARTICLES | MOTION | SURROUNDINGS }> $args,
        }
    }};
}

/// Meshes, where they stand, particles and water.
pub struct Geometry {
    pub(super) meshes: Arc<[TriMesh]>,
    pub(super) placement: Arc<Placement>,
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
        let placement = Placement::build(&meshes, instances)?;
        Self::assemble(meshes, placement.into(), particles, water_y)
    }

    /// The same with instances that already stand under their tree.
    ///
    /// # Errors
    /// A water height that is not finite.
    pub fn assemble(
        meshes: Arc<[TriMesh]>,
        placement: Arc<Placement>,
        particles: Option<Arc<Particles>>,
        water_y: Option<f32>,
    ) -> Result<Self, BuildError> {
        if water_y.is_some_and(|y| !y.is_finite()) {
            return Err(BuildError::WaterHeight);
        }
        Ok(Self {
            meshes,
            placement,
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
        self.placement.instances()
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
    /// alike): `key` must differ between samples and between the segments of a path.
    /// Without [`PARTICLES`] in `USES` both are ignored and cost nothing. A ray that is
    /// not finite hits nothing.
    #[inline]
    pub fn intersect<const USES: u8>(&self, ray: &Ray, key: u64) -> Option<Hit> {
        copies!(simd::intersect, USES, (self, ray, key))
    }

    /// How much stands at `0 < t < ray.t_max`: triangles and water block, each
    /// crossing of a particle's wall or of a sprite adds its optical depth. Without
    /// [`PARTICLES`] in `USES` they are ignored. A ray that is not finite is clear.
    #[inline]
    pub fn transmittance_depth<const USES: u8>(&self, ray: &Ray) -> Occlusion {
        copies!(simd::transmittance, USES, (self, ray))
    }

    /// Eight times `intersect`, bit for bit; faster if the rays go much the same way
    /// (neighbouring camera rays), little slower if not.
    #[inline]
    pub fn intersect8<const USES: u8>(&self, rays: &[Ray; 8], keys: &[u64; 8]) -> [Option<Hit>; 8] {
        copies!(simd::intersect8, USES, (self, rays, keys))
    }

    /// Eight times `transmittance_depth`, bit for bit; faster if the rays go much the
    /// same way (neighbouring rays to the sun).
    #[inline]
    pub fn transmittance_depth8<const USES: u8>(&self, rays: &[Ray; 8]) -> [Occlusion; 8] {
        copies!(simd::transmittance8, USES, (self, rays))
    }

    /// Distance to the water plane, if the ray goes there.
    #[inline(always)]
    pub(super) fn water_distance<const USES: u8>(&self, ray: &Ray) -> Option<f32> {
        if USES & SURROUNDINGS == 0 {
            return None;
        }
        let t = (self.water_y? - ray.o.y) / ray.d.y;
        (t > 0.0 && t < ray.t_max).then_some(t)
    }
}
