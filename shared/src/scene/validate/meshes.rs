//! Ranges and names of meshes and instances.

use super::super::at::At;
use super::super::range::{
    COORDINATE, Range, TURN, VELOCITY_MPS, asset, count, defined, number, numbers,
};
use super::super::{Instance, InstanceKey, Mesh, SceneDescription, SceneError};
use super::{animation, parents};
use crate::limits;

pub(super) fn meshes(at: &At<'_>, scene: &SceneDescription) -> Result<(), SceneError> {
    let most = limits::ASSETS_MAX as u64;
    count(at, scene.meshes.len() as u64, 0, most)?;
    for (key, described) in &scene.meshes {
        mesh(&at.field(key), described, scene)?;
    }
    Ok(())
}

fn mesh(at: &At<'_>, mesh: &Mesh, scene: &SceneDescription) -> Result<(), SceneError> {
    asset(&at.field("file"), &mesh.file)?;
    let crease_at = at.field("crease_angle_deg");
    let crease = Range::Closed(0.0, 180.0);
    number(&crease_at, mesh.crease_angle_deg, crease, "degrees")?;
    let map_at = at.field("materials");
    for (from, to) in &mesh.materials {
        let known = scene.materials.keys();
        defined(&map_at.field(from), "material", to, known)?;
    }
    Ok(())
}

pub(super) fn instances(at: &At<'_>, scene: &SceneDescription) -> Result<(), SceneError> {
    let most = limits::INSTANCES_MAX as u64;
    count(at, scene.instances.len() as u64, 0, most)?;
    for (i, described) in scene.instances.iter().enumerate() {
        let instance_at = at.index(i);
        instance(&instance_at, described, scene)?;
        motion(&instance_at, described)?;
    }
    parents::parents(at, &scene.instances)
}

fn motion(at: &At<'_>, instance: &Instance) -> Result<(), SceneError> {
    let velocity_at = at.field("velocity_mps");
    numbers(&velocity_at, &instance.velocity_mps, VELOCITY_MPS, "m/s")?;
    if let Some(spin) = &instance.spin {
        animation::spin(&at.field("spin"), spin)?;
    }
    let time = |key: &InstanceKey| key.time_s;
    animation::path(&at.field("path"), &instance.path, time, |at, key| {
        numbers(&at.field("offset_m"), &key.offset_m, COORDINATE, "m")?;
        numbers(&at.field("turn_deg"), &key.turn_deg, TURN, "degrees")
    })
}

fn instance(at: &At<'_>, instance: &Instance, scene: &SceneDescription) -> Result<(), SceneError> {
    if !scene.meshes.contains_key(&instance.mesh) {
        defined(
            &at.field("mesh"),
            "mesh",
            &instance.mesh,
            scene.meshes.keys(),
        )?;
    }
    if let Some(name) = &instance.material
        && !scene.materials.contains_key(name)
    {
        let known = scene.materials.keys();
        defined(&at.field("material"), "material", name, known)?;
    }
    let moved = at.field("translate_m");
    numbers(&moved, &instance.translate_m, COORDINATE, "m")?;
    numbers(
        &at.field("rotate_deg"),
        &instance.rotate_deg,
        TURN,
        "degrees",
    )?;
    let scale_at = at.field("scale");
    for (axis, &factor) in instance.scale.iter().enumerate() {
        let axis_at = scale_at.index(axis);
        // A scale of 1e-7 is a flat mesh in f32; its inverse must stay usable.
        if !(1e-6..=1e6).contains(&factor.abs()) {
            return Err(axis_at.error(format!(
                "{factor}: expected 1e-6 to 1e6 in size, with either sign"
            )));
        }
    }
    Ok(())
}
