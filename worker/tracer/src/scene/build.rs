//! From a description and the bytes of its files to a [`Scene`].

use super::material::{SurfaceMaterial, Textures, needs_schlick};
use super::transform::{normal_from_local, world_from_local};
use super::{InstanceShading, MeshShading, Scene};
use crate::bsdf::{TableNeeds, Tables, Water};
use crate::camera::Camera;
use crate::cloud;
use crate::geometry::{BuildError, Ellipsoid, Geometry, Instance, Particles, TriMesh};
use crate::light::{SkyLight, SkySampling, SunLight};
use crate::load::{load_mesh, load_sky, resolve_materials};
use crate::water::Sea;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use shearwater_shared::film::SAMPLE_MAX;
use shearwater_shared::job::RenderSettings;
use shearwater_shared::limits::PARTICLES_MAX;
use shearwater_shared::scene::{self, Material, SceneDescription, SceneError, Sky};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Share of the sky's mean radiance below which a light sample is faint.
const FAINT_SHARE: f32 = 0.05;

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
        let meshes = build_meshes(description, assets, &mut report)?;
        let sea = description
            .water
            .as_ref()
            .map(|water| Sea::build(water, origin.to_array()));
        let tables = build_tables(description, &meshes, sea.as_ref())?;
        let materials = Materials::new(description, &meshes, &tables, &mut textures)?;
        let (placed, instances) = place(description, &materials, origin)?;
        let (particles, particle_cloud) = build_clouds(description, origin)?;
        report.particles = particle_cloud.len();
        let (trees, shading) = meshes
            .into_iter()
            .map(|mesh| (mesh.tree, mesh.shading))
            .unzip();
        let water_y = sea.as_ref().map(|sea| (sea.height_m - origin.y) as f32);
        let geometry = Geometry::build(trees, placed, particles, water_y)
            .map_err(|e| geometry_error(".", &e))?;
        let geometry = if options.portable_simd {
            geometry.without_avx2()
        } else {
            geometry
        };
        let sky = build_sky(description, assets, &mut report)?;
        report.notes.append(&mut textures.notes);
        let scene = Self {
            geometry,
            camera: Camera::new(&description.camera, settings.width, settings.height),
            sample_sky: sky.as_ref().is_some_and(SkyLight::is_sampled),
            faint: sky.as_ref().map_or(0.0, SkyLight::mean) * FAINT_SHARE,
            sky,
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
            cloud_albedo: description
                .clouds
                .iter()
                .map(|scene::Cloud::Particles(c)| Vec3::from_array(c.albedo))
                .collect(),
            particle_cloud,
        };
        Ok((scene, report))
    }
}

fn geometry_error(path: &str, error: &BuildError) -> SceneError {
    SceneError::new("scene.json", path, error.to_string())
}

struct BuiltMesh {
    tree: TriMesh,
    shading: MeshShading,
    materials: Vec<Material>,
    notes: Vec<String>,
}

fn build_meshes(
    description: &SceneDescription,
    assets: &Assets,
    report: &mut BuildReport,
) -> Result<Vec<BuiltMesh>, SceneError> {
    let entries: Vec<_> = description.meshes.iter().collect();
    let built: Vec<Result<BuiltMesh, SceneError>> = entries
        .par_iter()
        .map(|(name, mesh)| build_mesh(name, mesh, description, assets))
        .collect();
    let mut meshes = Vec::with_capacity(built.len());
    for mesh in built {
        let mut mesh = mesh?;
        report.triangles += mesh.shading.triangles.len();
        report.notes.append(&mut mesh.notes);
        meshes.push(mesh);
    }
    Ok(meshes)
}

fn build_mesh(
    name: &str,
    mesh: &scene::Mesh,
    description: &SceneDescription,
    assets: &Assets,
) -> Result<BuiltMesh, SceneError> {
    let (loaded, notes) = load_mesh(&mesh.file, mesh, assets)?;
    let materials = resolve_materials(&mesh.file, mesh, &loaded, &description.materials, assets)?;
    let tree = TriMesh::build(&loaded.positions, &loaded.triangles)
        .map_err(|e| SceneError::new(&mesh.file, ".", e.to_string()))?;
    let notes = if notes.is_empty() {
        Vec::new()
    } else {
        vec![format!("mesh {name}: {notes}")]
    };
    let shading = MeshShading {
        triangles: loaded.triangles,
        normals: loaded.normals,
        uvs: loaded.uvs,
        material_of: loaded.material_of,
    };
    Ok(BuiltMesh {
        tree,
        shading,
        materials,
        notes,
    })
}

type Placed = (Vec<Instance>, Vec<InstanceShading>);

fn place(
    description: &SceneDescription,
    materials: &Materials,
    origin: DVec3,
) -> Result<Placed, SceneError> {
    let (mut placed, mut shading) = (Vec::new(), Vec::new());
    for (number, instance) in description.instances.iter().enumerate() {
        let path = format!("instances[{number}]");
        let affine = world_from_local(instance, origin);
        let shaded = materials
            .of_instance(instance, normal_from_local(&affine))
            .map_err(|e| SceneError::new("scene.json", &*path, e))?;
        placed.push(Instance::new(shaded.mesh, affine).map_err(|e| geometry_error(&path, &e))?);
        shading.push(shaded);
    }
    Ok((placed, shading))
}

fn build_tables(
    description: &SceneDescription,
    meshes: &[BuiltMesh],
    sea: Option<&Sea>,
) -> Result<Tables, SceneError> {
    let needs = TableNeeds {
        schlick: description
            .materials
            .values()
            .chain(meshes.iter().flat_map(|m| &m.materials))
            .any(needs_schlick),
        etas: sea.map(|sea| sea.ior).into_iter().collect(),
    };
    Tables::build(&needs).map_err(|e| SceneError::new("scene.json", "water.ior", e.to_string()))
}

fn build_water(sea: Option<&Sea>, tables: &Tables) -> Result<Option<Water>, SceneError> {
    let Some(sea) = sea else { return Ok(None) };
    let water = Water::new(tables, sea.ior, sea.body_color, 0.0);
    water
        .map(Some)
        .map_err(|e| SceneError::new("scene.json", "water", e.to_string()))
}

fn build_sky(
    description: &SceneDescription,
    assets: &Assets,
    report: &mut BuildReport,
) -> Result<Option<SkyLight>, SceneError> {
    Ok(match &description.sky {
        None => None,
        Some(Sky::Constant(sky)) => Some(SkyLight::Constant(Vec3::from_array(sky.radiance))),
        Some(Sky::Map(map)) => {
            let bytes = assets.get(&map.file).ok_or_else(|| {
                SceneError::new(
                    &map.file,
                    "sky.file",
                    "the file was not supplied with the scene",
                )
            })?;
            let mut image = load_sky(&map.file, bytes)?;
            if image.bad_texels > 0 {
                let bad = image.bad_texels;
                report.notes.push(format!(
                    "sky {}: {bad} texels that are no radiance are black",
                    map.file
                ));
            }
            for value in image.rgb.iter_mut().flatten() {
                *value *= map.intensity;
                if !(0.0..=SAMPLE_MAX).contains(value) {
                    let message =
                        format!("{value:e} times the sky's texel: at most {SAMPLE_MAX:e} in all");
                    return Err(SceneError::new("scene.json", "sky.intensity", message));
                }
            }
            Some(SkyLight::map(
                image.width as usize,
                image.height as usize,
                image.rgb,
                map.rotation_deg,
                SkySampling::WhereItPays,
            ))
        }
    })
}

// Particles wholly under the water can be neither seen nor shadow anything.
fn build_clouds(
    description: &SceneDescription,
    origin: DVec3,
) -> Result<(Option<Particles>, Vec<u16>), SceneError> {
    let floor = description.water.as_ref().map(|water| {
        let scene::Water::Tessendorf(sea) = water;
        (sea.height_m - origin.y) as f32
    });
    let mut ellipsoids: Vec<Ellipsoid> = Vec::new();
    let mut owners = Vec::new();
    for (number, cloud) in description.clouds.iter().enumerate() {
        let path = format!("clouds[{number}]");
        let owner = u16::try_from(number)
            .map_err(|_| SceneError::new("scene.json", &*path, "at most 65536 clouds"))?;
        let scene::Cloud::Particles(cloud) = cloud;
        let seen = cloud::particles(cloud, origin)
            .filter(|p| floor.is_none_or(|y| p.centre.y + p.radii.y > y));
        let before = ellipsoids.len();
        ellipsoids.extend(seen);
        if ellipsoids.len() > PARTICLES_MAX {
            return Err(SceneError::new(
                "scene.json",
                path,
                format!("more than {PARTICLES_MAX} particles in all"),
            ));
        }
        owners.resize(owners.len() + ellipsoids.len() - before, owner);
    }
    if ellipsoids.is_empty() {
        return Ok((None, owners));
    }
    let particles = Particles::build(&ellipsoids).map_err(|e| geometry_error("clouds", &e))?;
    Ok((Some(particles), owners))
}

// Materials by number: the scene's own for instances that replace their mesh's,
// and those of each mesh.
struct Materials {
    list: Vec<SurfaceMaterial>,
    of_scene: BTreeMap<String, u32>,
    /// Number of the mesh and its materials.
    of_mesh: BTreeMap<String, (u32, Arc<[u32]>)>,
}

impl Materials {
    fn new(
        description: &SceneDescription,
        meshes: &[BuiltMesh],
        tables: &Tables,
        textures: &mut Textures<'_>,
    ) -> Result<Self, SceneError> {
        let mut list = Vec::new();
        let mut add = |name: &str, material: &Material, textures: &mut Textures<'_>| {
            list.push(SurfaceMaterial::new(name, material, tables, textures)?);
            Ok::<u32, SceneError>(list.len() as u32 - 1)
        };
        let mut of_scene = BTreeMap::new();
        for (name, material) in &description.materials {
            of_scene.insert(name.clone(), add(name, material, textures)?);
        }
        let mut of_mesh = BTreeMap::new();
        for (number, (name, mesh)) in description.meshes.keys().zip(meshes).enumerate() {
            let numbers = mesh
                .materials
                .iter()
                .map(|material| add(name, material, textures));
            let numbers: Arc<[u32]> = numbers.collect::<Result<Vec<_>, _>>()?.into();
            of_mesh.insert(name.clone(), (number as u32, numbers));
        }
        Ok(Self {
            list,
            of_scene,
            of_mesh,
        })
    }

    fn of_instance(
        &self,
        instance: &scene::Instance,
        normal_from_local: glam::Mat3,
    ) -> Result<InstanceShading, String> {
        let (mesh, materials) = self
            .of_mesh
            .get(&instance.mesh)
            .ok_or_else(|| format!("no mesh is named `{}`", instance.mesh))?;
        let replacement = |name: &String| {
            self.of_scene
                .get(name)
                .copied()
                .ok_or_else(|| format!("no material is named `{name}`"))
        };
        Ok(InstanceShading {
            mesh: *mesh,
            materials: Arc::clone(materials),
            replaced_by: instance.material.as_ref().map(replacement).transpose()?,
            normal_from_local,
        })
    }
}
