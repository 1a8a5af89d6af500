//! Meshes, their materials and their placement.

use super::material::{SurfaceMaterial, Textures};
use super::motion::{Exposure, push_joints};
use super::stage::{Assets, BuildReport, geometry_error};
use super::transform::normal_from_local;
use super::{InstanceShading, MeshShading};
use crate::bsdf::Tables;
use crate::geometry::{Instance, TriMesh};
use crate::load::{load_mesh, resolve_materials};
use glam::DVec3;
use rayon::prelude::*;
use shearwater_shared::scene::{self, Material, SceneDescription, SceneError};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A mesh of the scene, read and built.
pub(super) struct BuiltMesh {
    pub(super) tree: TriMesh,
    pub(super) shading: MeshShading,
    pub(super) materials: Vec<Material>,
    notes: Vec<String>,
}

/// Every mesh of the scene, in the order of their names.
pub(super) fn build_meshes(
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

/// Instances for the tree and for shading.
pub(super) type Placed = (Instance, InstanceShading);

/// Where instance `number` stands in one exposure; `chain` are it and the instances
/// that it is placed in, itself first.
pub(super) fn place(
    description: &SceneDescription,
    materials: &Materials,
    origin_m: DVec3,
    number: usize,
    chain: &[u32],
    exposure: Exposure,
) -> Result<Placed, SceneError> {
    let path = format!("instances[{number}]");
    let mut joints = Vec::new();
    let mut origin_m = origin_m;
    for &above in chain.iter().rev() {
        let above = &description.instances[above as usize];
        push_joints(&mut joints, above, origin_m, exposure);
        origin_m = DVec3::ZERO;
    }
    let (mesh, shading) = materials
        .of_instance(&description.instances[number])
        .map_err(|e| SceneError::new("scene.json", &*path, e))?;
    let placed = Instance::moving(mesh, joints, exposure.shutter_s)
        .map_err(|e| geometry_error(&path, &e))?;
    let shading = InstanceShading {
        normal_from_local: normal_from_local(placed.world_from_local()),
        is_moving: placed.is_moving(),
        ..shading
    };
    Ok((placed, shading))
}

/// Materials by number: the scene's own for instances that replace their mesh's,
/// and those of each mesh.
pub(super) struct Materials {
    pub(super) list: Vec<SurfaceMaterial>,
    of_scene: BTreeMap<String, u32>,
    /// Number of the mesh and its materials.
    of_mesh: BTreeMap<String, (u32, Arc<[u32]>)>,
}

impl Materials {
    pub(super) fn new(
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

    fn of_instance(&self, instance: &scene::Instance) -> Result<(u32, InstanceShading), String> {
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
        let shading = InstanceShading {
            mesh: *mesh,
            materials: Arc::clone(materials),
            replaced_by: instance.material.as_ref().map(replacement).transpose()?,
            normal_from_local: glam::Mat3::IDENTITY,
            is_moving: false,
        };
        Ok((*mesh, shading))
    }
}
