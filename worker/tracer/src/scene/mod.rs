//! A built scene: everything that a sample reads.

mod clouds;
mod frame;
mod keyframes;
mod material;
mod meshes;
pub(crate) mod motion;
mod placed;
mod sky;
mod stage;
mod transform;
mod volumes;

pub use stage::{Assets, BuildOptions, BuildReport, Stage};

use crate::bsdf::{Bsdf, Tables, Water};
use crate::camera::Camera;
use crate::geometry::Geometry;
use crate::light::{SkyLight, SunLight};
use crate::load::Texture;
use crate::medium::{Media, Phase};
use crate::strategy::Strategy;
use crate::uses;
use crate::water::Sea;
use clouds::CloudShading;
use glam::{Vec2, Vec3};
use material::SurfaceMaterial;
use std::sync::Arc;

/// One frame of a scene, built and ready to render. Render space has the axes of
/// the scene and its origin at the stage's anchor, near the camera, so that 32-bit
/// floats are finest where the picture is.
pub struct Scene {
    pub(crate) common: Arc<Common>,
    pub(crate) geometry: Geometry,
    pub(crate) camera: Camera,
    pub(crate) seed: u64,
    pub(crate) frame: u32,
    instances: Arc<[InstanceShading]>,
    sea: Option<Sea>,
}

/// What a sample reads of that which all frames of a scene share.
pub(crate) struct Common {
    pub(crate) sky: Option<SkyLight>,
    pub(crate) sun: Option<SunLight>,
    /// How paths are sampled.
    pub(crate) strategy: Strategy,
    /// There is a sun, to be sampled.
    pub(crate) sample_sun: bool,
    /// Sampling the sky pays, or is wanted.
    pub(crate) sample_sky: bool,
    /// Light samples that would add less than this are traced at random.
    pub(crate) faint: f32,
    pub(crate) tables: Tables,
    /// The volumes.
    pub(crate) media: Media,
    shading: Vec<MeshShading>,
    materials: Vec<SurfaceMaterial>,
    textures: Vec<Texture>,
    /// The sea's surface without roughness.
    water: Option<Water>,
    clouds: CloudShading,
}

/// What shading needs of a mesh, by triangle.
struct MeshShading {
    triangles: Vec<[u32; 3]>,
    /// Per vertex, unit; empty when every triangle is flat.
    normals: Vec<Vec3>,
    /// Per vertex; empty when the mesh has none.
    uvs: Vec<Vec2>,
    /// Per triangle: number of its material within the mesh.
    material_of: Vec<u16>,
}

#[derive(Clone)]
struct InstanceShading {
    mesh: u32,
    /// Number of the material for each material of the mesh.
    materials: Arc<[u32]>,
    /// One material instead of all of these.
    replaced_by: Option<u32>,
    /// Takes normals from mesh to render space when the shutter opens; not
    /// normalised.
    normal_from_local: glam::Mat3,
    /// It turns or moves while the shutter is open.
    is_moving: bool,
}

impl Scene {
    /// What the scene uses, as the bits of [`uses`].
    #[must_use]
    pub fn uses(&self) -> u8 {
        let mut bits = uses::NOTHING;
        let clouds = &self.common.clouds;
        if !(clouds.of_particle.is_empty() && clouds.of_sprite.is_empty()) {
            bits |= uses::PARTICLES;
        }
        if self.camera.is_moving() || self.instances.iter().any(|i| i.is_moving) {
            bits |= uses::MOTION;
        }
        if !self.common.media.is_empty() {
            bits |= uses::MEDIA;
        }
        let dome = matches!(&self.common.sky, Some(sky) if sky.is_finite());
        if self.geometry.water_y().is_some() || dome {
            bits |= uses::SURROUNDINGS;
        }
        bits
    }

    /// Shading normal (either side) and scattering at a point of a triangle,
    /// `time_s` seconds after the shutter opens.
    #[inline]
    pub(crate) fn surface<const USES: u8>(
        &self,
        instance: u32,
        prim: u32,
        u: f32,
        v: f32,
        n_geometric: Vec3,
        time_s: f32,
    ) -> (Vec3, Bsdf) {
        let placed = &self.instances[instance as usize];
        let mesh = &self.common.shading[placed.mesh as usize];
        let corners = mesh.triangles[prim as usize].map(|i| i as usize);
        let w = 1.0 - u - v;
        let normal = if mesh.normals.is_empty() {
            n_geometric
        } else {
            let local = mesh.normals[corners[0]] * w
                + mesh.normals[corners[1]] * u
                + mesh.normals[corners[2]] * v;
            let to_world = if USES & uses::MOTION != 0 && placed.is_moving {
                self.geometry.instances()[instance as usize].normal_from_local(time_s)
            } else {
                placed.normal_from_local
            };
            (to_world * local).try_normalize().unwrap_or(n_geometric)
        };
        let number = match placed.replaced_by {
            Some(number) => number,
            None => placed.materials[mesh.material_of[prim as usize] as usize],
        };
        let material = &self.common.materials[number as usize];
        let uv = (material.is_textured() && !mesh.uvs.is_empty()).then(|| {
            mesh.uvs[corners[0]] * w + mesh.uvs[corners[1]] * u + mesh.uvs[corners[2]] * v
        });
        let bsdf = material.bsdf(&self.common.tables, &self.common.textures, uv);
        (normal, bsdf)
    }

    /// Scattering of a particle.
    #[inline]
    pub(crate) fn particle_bsdf(&self, prim: u32) -> Bsdf {
        Bsdf::Lambert {
            albedo: self.common.clouds.albedo
                [usize::from(self.common.clouds.of_particle[prim as usize])],
        }
    }

    /// Scattering of a sprite.
    #[inline]
    pub(crate) fn sprite_phase(&self, prim: u32) -> Phase {
        let clouds = &self.common.clouds;
        let cloud = usize::from(clouds.of_sprite[prim as usize]);
        Phase {
            albedo: clouds.albedo[cloud],
            g: clouds.g[cloud],
        }
    }

    /// Shading normal and scattering of the water at `p`, for a ray that is
    /// `footprint_m` wide there.
    #[inline]
    #[cfg_attr(not(feature = "effects"), allow(unused_variables))]
    pub(crate) fn water_surface(&self, p: Vec3, time_s: f32, footprint_m: f32) -> (Vec3, Bsdf) {
        match (&self.sea, &self.common.water) {
            #[cfg(feature = "effects")]
            (Some(sea), Some(water)) => {
                let point = sea.at(p.x, p.z, time_s, footprint_m, &self.common.textures);
                let normal = Vec3::new(-point.slope.x, 1.0, -point.slope.y).normalize();
                let water = water.with_body(&self.common.tables, point.body_color, point.alpha);
                (normal, Bsdf::Water(water))
            }
            _ => (Vec3::Y, Bsdf::Lambert { albedo: Vec3::ZERO }),
        }
    }
}
