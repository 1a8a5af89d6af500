//! From a description and the bytes of its files to what all its frames share.

use super::clouds::build_clouds;
use super::material::{Textures, add_needs};
use super::meshes::{BuiltMesh, Materials, build_meshes};
use super::motion::anchor;
use super::placed::Standing;
use super::sky::{build_sky, build_sun, is_sampled};
use super::volumes::build_media;
use super::{Common, Scene};
use crate::bsdf::{TableNeeds, Tables, Water};
use crate::geometry::{BuildError, Particles, Sprites, TriMesh};
use crate::light::SkyLight;
use crate::load::Encoding;
use crate::strategy::Strategy;
use crate::water::SeaStage;
use glam::{DVec3, Vec3};
use shearwater_shared::job::RenderSettings;
use shearwater_shared::scene::{self, Mis, SceneDescription, SceneError};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The bytes of a scene's files, by the names that the scene uses.
pub type Assets = BTreeMap<String, Arc<[u8]>>;

/// How to build, beyond what the scene says; none of it changes a bit of the
/// picture.
#[derive(Clone, Copy, Debug, Default)]
pub struct BuildOptions {
    /// Do without AVX2 even where the machine has it.
    pub portable_simd: bool,
}

/// What was noticed while building.
#[derive(Clone, Debug, Default)]
pub struct BuildReport {
    /// Texts for people: dropped triangles, materials that nobody defined.
    pub notes: Vec<String>,
    /// Triangles over all meshes, each mesh counted once.
    pub triangles: usize,
    /// Cloud particles that can be seen.
    pub particles: usize,
    /// Cloud sprites that can be seen.
    pub sprites: usize,
}

/// Everything that the frames of a scene share: meshes and their trees, materials,
/// textures, tables, sky, clouds. Making a frame of it is cheap.
pub struct Stage {
    pub(super) description: SceneDescription,
    pub(super) common: Arc<Common>,
    pub(super) trees: Arc<[TriMesh]>,
    pub(super) standing: Standing,
    pub(super) particles: Option<Arc<Particles>>,
    pub(super) sprites: Option<Arc<Sprites>>,
    pub(super) materials: Materials,
    pub(super) sea: Option<SeaStage>,
    /// The point of the scene that is (0, 0, 0) for the tracer.
    pub(super) anchor_m: DVec3,
    pub(super) options: BuildOptions,
}

impl Stage {
    /// Build what the frames of a scene share. Meshes are built in parallel; the
    /// result is the same for any number of threads.
    ///
    /// # Errors
    /// A file that is missing or cannot be read: file, place, what was expected.
    pub fn build(
        description: &SceneDescription,
        assets: &Assets,
        options: BuildOptions,
    ) -> Result<(Self, BuildReport), SceneError> {
        let mut report = BuildReport::default();
        let anchor_m = anchor(description);
        let mut textures = Textures::new(assets);
        let meshes = build_meshes(description, assets, &mut report)?;
        let tables = build_tables(description, &meshes)?;
        let mut materials = Materials::new(description, &meshes, &tables, &mut textures)?;
        let clouds = build_clouds(description, assets, anchor_m, &mut report)?;
        let (trees, shading): (Vec<_>, _) = meshes
            .into_iter()
            .map(|mesh| (mesh.tree, mesh.shading))
            .unzip();
        let sea = build_sea(description, &mut textures)?;
        let sky = build_sky(description, assets, anchor_m, &mut report)?;
        report.notes.append(&mut textures.notes);
        let sun = build_sun(description)?;
        let sampling = &description.sampling;
        let common = Common {
            strategy: Strategy::new(sampling),
            sample_sky: sky.as_ref().is_some_and(|sky| is_sampled(sky, sampling)),
            sample_sun: sun.is_some() && sampling.mis != Mis::ScatteringOnly,
            faint: sky.as_ref().map_or(0.0, SkyLight::mean) * sampling.faint_share,
            sky,
            sun,
            water: build_water(description, &tables)?,
            tables,
            media: build_media(description, assets, anchor_m)?,
            shading,
            materials: std::mem::take(&mut materials.list),
            textures: textures.list,
            clouds: clouds.shading,
        };
        let trees: Arc<[TriMesh]> = trees.into();
        let standing = Standing::build(description, &materials, &trees, anchor_m)?;
        let stage = Self {
            description: description.clone(),
            common: Arc::new(common),
            trees,
            standing,
            particles: clouds.particles,
            sprites: clouds.sprites,
            materials,
            sea,
            anchor_m,
            options,
        };
        Ok((stage, report))
    }
}

impl Scene {
    /// Build one frame of a scene, and nothing to share: [`Stage::build`] and
    /// [`Stage::frame`] in one.
    ///
    /// # Errors
    /// Theirs.
    pub fn build(
        description: &SceneDescription,
        assets: &Assets,
        settings: &RenderSettings,
        frame: u32,
        options: BuildOptions,
    ) -> Result<(Self, BuildReport), SceneError> {
        let (stage, report) = Stage::build(description, assets, options)?;
        Ok((stage.frame(settings, frame)?, report))
    }
}

/// An error of the geometry at a place of the scene.
pub(super) fn geometry_error(path: &str, error: &BuildError) -> SceneError {
    SceneError::new("scene.json", path, error.to_string())
}

fn build_tables(
    description: &SceneDescription,
    meshes: &[BuiltMesh],
) -> Result<Tables, SceneError> {
    let mut needs = TableNeeds {
        etas: description
            .water
            .as_ref()
            .map(|water| water.look().ior)
            .into_iter()
            .collect(),
        ..TableNeeds::default()
    };
    let of_meshes = meshes.iter().flat_map(|m| &m.materials);
    for material in description.materials.values().chain(of_meshes) {
        add_needs(&mut needs, material);
    }
    Tables::build(&needs).map_err(|e| SceneError::new("scene.json", "materials", e.to_string()))
}

fn build_sea(
    description: &SceneDescription,
    textures: &mut Textures<'_>,
) -> Result<Option<SeaStage>, SceneError> {
    let Some(water) = &description.water else {
        return Ok(None);
    };
    let texture = water
        .texture()
        .map(|file| textures.number(file, Encoding::Srgb))
        .transpose()?;
    Ok(Some(SeaStage::new(water, texture)))
}

fn build_water(
    description: &SceneDescription,
    tables: &Tables,
) -> Result<Option<Water>, SceneError> {
    let Some(look) = description.water.as_ref().map(scene::Water::look) else {
        return Ok(None);
    };
    Water::new(tables, look.ior, Vec3::from_array(look.body_color), 0.0)
        .map(Some)
        .map_err(|e| SceneError::new("scene.json", "water", e.to_string()))
}
