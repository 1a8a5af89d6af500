//! From a description and the bytes of its files to a [`Scene`].

use super::material::{SurfaceMaterial, Textures, needs_schlick};
use super::transform::{normal_from_local, world_from_local};
use super::{InstanceShading, MeshShading, Scene};
use crate::bsdf::{TableNeeds, Tables, Water};
use crate::camera::Camera;
use crate::cloud;
use crate::geometry::{BuildError, Ellipsoid, Geometry, Instance, Particles, TriMesh};
use crate::light::{SkyLight, SunLight};
use crate::load::{LoadedMesh, load_mesh, load_sky};
use crate::water::Sea;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use shearwater_shared::job::RenderSettings;
use shearwater_shared::limits::PARTICLES_MAX;
use shearwater_shared::scene::{SceneDescription, SceneError, Sky};
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
}

impl Scene {
    /// Build frame `frame` of a scene. Meshes are built in parallel; the result is
    /// the same for any number of threads.
    ///
    /// # Errors
    /// A file that is missing or cannot be read: file, place, what was expected.
    pub fn build(
        description: &SceneDescription,
        assets: &Assets,
        settings: &RenderSettings,
        frame: u32,
        options: BuildOptions,
    ) -> Result<(Self, BuildReport), SceneError> {
        let mut report = BuildReport::default();
        let origin = DVec3::from_array(description.camera.position_m);
        let mut textures = Textures::new(assets);
        let names: Vec<&String> = description.meshes.keys().collect();
        let meshes = build_meshes(description, assets, &mut report)?;
        let sea = description.water.as_ref().map(|water| Sea::build(water, origin.to_array()));
        let tables = build_tables(description, sea.as_ref())?;
        let mut materials = Materials::new(description, &tables, &mut textures)?;
        let mut placed = Vec::new();
        let mut instances = Vec::new();
        for (number, instance) in description.instances.iter().enumerate() {
            let path = format!("instances[{number}]");
            let Some(mesh) = names.iter().position(|name| **name == instance.mesh) else {
                return Err(SceneError::new("scene.json", path, format!("no mesh is named `{}`", instance.mesh)));
            };
            let affine = world_from_local(instance, origin);
            placed.push(Instance::new(mesh as u32, affine).map_err(|e| geometry_error(&path, &e))?);
            let numbers = materials.of_instance(description, &instance.mesh, instance.material.as_deref(), &meshes[mesh].2, &mut textures, &mut report)?;
            instances.push(InstanceShading { mesh: mesh as u32, materials: numbers, normal_from_local: normal_from_local(&affine) });
        }
        let (particles, particle_cloud) = build_clouds(description, origin)?;
        report.particles = particle_cloud.len();
        let (trees, shading): (Vec<TriMesh>, Vec<MeshShading>) = meshes.into_iter().map(|(tree, shading, _)| (tree, shading)).unzip();
        let water_y = sea.as_ref().map(|sea| (sea.height_m - origin.y) as f32);
        let geometry = Geometry::build(trees, placed, particles, water_y).map_err(|e| geometry_error(".", &e))?;
        let geometry = if options.portable_simd { geometry.without_avx2() } else { geometry };
        let scene = Self {
            geometry,
            camera: Camera::new(&description.camera, settings.width, settings.height),
            sky: build_sky(description, assets)?,
            sun: description.sun.as_ref().and_then(SunLight::new),
            water: build_water(sea.as_ref(), &tables)?,
            tables,
            seed: settings.seed,
            frame,
            shading,
            instances,
            materials: materials.list,
            textures: textures.list,
            sea,
            cloud_albedo: description.clouds.iter().map(|c| Vec3::from_array(c.albedo)).collect(),
            particle_cloud,
        };
        Ok((scene, report))
    }
}

fn geometry_error(path: &str, error: &BuildError) -> SceneError {
    SceneError::new("scene.json", path, error.to_string())
}

type BuiltMesh = (TriMesh, MeshShading, LoadedMesh);

fn build_meshes(description: &SceneDescription, assets: &Assets, report: &mut BuildReport) -> Result<Vec<BuiltMesh>, SceneError> {
    let built: Vec<Result<(BuiltMesh, Vec<String>), SceneError>> = description
        .meshes
        .par_iter()
        .map(|(name, mesh)| {
            let (mut loaded, notes) = load_mesh(&mesh.file, mesh, assets)?;
            let tree = TriMesh::build(&loaded.positions, &loaded.triangles)
                .map_err(|e| SceneError::new(&mesh.file, ".", e.to_string()))?;
            let shading = MeshShading {
                triangles: std::mem::take(&mut loaded.triangles),
                normals: std::mem::take(&mut loaded.normals),
                uvs: std::mem::take(&mut loaded.uvs),
                material_of: std::mem::take(&mut loaded.material_of),
            };
            loaded.positions = Vec::new();
            let notes = notes.texts().into_iter().map(|note| format!("{name}: {note}")).collect();
            Ok(((tree, shading, loaded), notes))
        })
        .collect();
    let mut meshes = Vec::with_capacity(built.len());
    for mesh in built {
        let (mesh, notes) = mesh?;
        report.triangles += mesh.1.triangles.len();
        report.notes.extend(notes);
        meshes.push(mesh);
    }
    Ok(meshes)
}

fn build_tables(description: &SceneDescription, sea: Option<&Sea>) -> Result<Tables, SceneError> {
    let needs = TableNeeds {
        schlick: description.materials.values().any(needs_schlick),
        etas: sea.map(|sea| sea.ior).into_iter().collect(),
    };
    Tables::build(&needs).map_err(|e| SceneError::new("scene.json", "water.ior", e.to_string()))
}

fn build_water(sea: Option<&Sea>, tables: &Tables) -> Result<Option<Water>, SceneError> {
    let Some(sea) = sea else { return Ok(None) };
    let water = Water::new(tables, sea.ior, sea.body_color, 0.0);
    water.map(Some).map_err(|e| SceneError::new("scene.json", "water", e.to_string()))
}

fn build_sky(description: &SceneDescription, assets: &Assets) -> Result<Option<SkyLight>, SceneError> {
    Ok(match &description.sky {
        None => None,
        Some(Sky::Constant(sky)) => Some(SkyLight::Constant(Vec3::from_array(sky.radiance))),
        Some(Sky::Map(map)) => {
            let bytes = assets
                .get(&map.file)
                .ok_or_else(|| SceneError::new(&map.file, "sky.file", "the file was not supplied with the scene"))?;
            let mut image = load_sky(&map.file, bytes)?;
            for value in image.rgb.iter_mut().flatten() {
                *value *= map.intensity;
            }
            Some(SkyLight::map(image.width, image.height, image.rgb, map.rotation_deg))
        }
    })
}

// Particles wholly under the water can be neither seen nor shadow anything.
fn build_clouds(description: &SceneDescription, origin: DVec3) -> Result<(Option<Particles>, Vec<u16>), SceneError> {
    let floor = description.water.as_ref().map(|water| {
        let shearwater_shared::scene::Water::Tessendorf(sea) = water;
        (sea.height_m - origin.y) as f32
    });
    let mut ellipsoids: Vec<Ellipsoid> = Vec::new();
    let mut owners = Vec::new();
    for (number, cloud) in description.clouds.iter().enumerate() {
        let path = format!("clouds[{number}]");
        let owner = u16::try_from(number).map_err(|_| SceneError::new("scene.json", &*path, "at most 65536 clouds"))?;
        let seen = cloud::particles(cloud, origin).filter(|p| floor.is_none_or(|y| p.centre.y + p.radii.y > y));
        let before = ellipsoids.len();
        ellipsoids.extend(seen);
        if ellipsoids.len() > PARTICLES_MAX {
            return Err(SceneError::new("scene.json", path, format!("more than {PARTICLES_MAX} particles in all")));
        }
        owners.resize(owners.len() + ellipsoids.len() - before, owner);
    }
    if ellipsoids.is_empty() {
        return Ok((None, owners));
    }
    let particles = Particles::build(&ellipsoids).map_err(|e| geometry_error("clouds", &e))?;
    Ok((Some(particles), owners))
}

// The scene's materials by number; those of MTL files are added as met.
struct Materials<'a> {
    list: Vec<SurfaceMaterial>,
    of_scene: BTreeMap<&'a str, u32>,
    of_mtl: BTreeMap<(String, String), u32>,
}

impl<'a> Materials<'a> {
    fn new(description: &'a SceneDescription, tables: &Tables, textures: &mut Textures<'_>) -> Result<Self, SceneError> {
        let mut list = Vec::new();
        let mut of_scene = BTreeMap::new();
        for (name, material) in &description.materials {
            of_scene.insert(name.as_str(), list.len() as u32);
            list.push(SurfaceMaterial::new(name, material, tables, textures)?);
        }
        Ok(Self { list, of_scene, of_mtl: BTreeMap::new() })
    }

    // For each material of the mesh: the instance's own, the one the scene maps it
    // to, the scene's of the same name, the MTL file's, or a grey that is reported.
    fn of_instance(
        &mut self,
        description: &SceneDescription,
        mesh: &str,
        replacement: Option<&str>,
        loaded: &LoadedMesh,
        textures: &mut Textures<'_>,
        report: &mut BuildReport,
    ) -> Result<Vec<u32>, SceneError> {
        let mapping = description.meshes.get(mesh).map(|m| &m.materials);
        let mut numbers = Vec::with_capacity(loaded.materials.len());
        for name in &loaded.materials {
            let mapped = replacement.or_else(|| mapping.and_then(|m| m.get(name)).map(String::as_str));
            let wanted = mapped.unwrap_or(name);
            if let Some(&number) = self.of_scene.get(wanted) {
                numbers.push(number);
                continue;
            }
            if mapped.is_some() {
                let message = format!("no material is named `{wanted}`");
                return Err(SceneError::new("scene.json", format!("meshes.{mesh}.materials"), message));
            }
            let key = (mesh.to_owned(), name.clone());
            let number = match self.of_mtl.get(&key) {
                Some(&number) => number,
                None => {
                    let material = match loaded.mtl.get(name) {
                        Some(mtl) => SurfaceMaterial::from_mtl(mtl, textures)?,
                        None => {
                            report.notes.push(format!("{mesh}: material `{name}` is defined nowhere; it is grey"));
                            SurfaceMaterial::grey()
                        }
                    };
                    self.list.push(material);
                    self.of_mtl.insert(key, self.list.len() as u32 - 1);
                    self.list.len() as u32 - 1
                }
            };
            numbers.push(number);
        }
        Ok(numbers)
    }
}

