//! Ranges of materials.

use super::super::at::At;
use super::super::range::{Range, SHARE, asset, count, number, numbers, shares};
use super::super::{Material, SceneDescription, SceneError};
use crate::limits;

pub(super) fn materials(at: &At<'_>, scene: &SceneDescription) -> Result<(), SceneError> {
    let most = limits::MATERIALS_MAX as u64;
    count(at, scene.materials.len() as u64, 0, most)?;
    for (key, described) in &scene.materials {
        material(&at.field(key), described)?;
    }
    Ok(())
}

fn material(at: &At<'_>, described: &Material) -> Result<(), SceneError> {
    let texture = |field: &str, name: &Option<String>| {
        name.as_ref()
            .map_or(Ok(()), |name| asset(&at.field(field), name))
    };
    match described {
        Material::Lambert(m) => {
            numbers(&at.field("albedo"), &m.albedo, SHARE, "")?;
            texture("albedo_texture", &m.albedo_texture)
        }
        Material::Phong(m) => {
            numbers(&at.field("kd"), &m.kd, SHARE, "")?;
            numbers(&at.field("ks"), &m.ks, SHARE, "")?;
            shares(at, &m.kd, &m.ks)?;
            let exponents = Range::Closed(0.0, 1e7);
            number(&at.field("exponent"), m.exponent, exponents, "")?;
            texture("kd_texture", &m.kd_texture)
        }
        Material::Ggx(m) => {
            numbers(&at.field("base_color"), &m.base_color, SHARE, "")?;
            number(&at.field("roughness"), m.roughness, SHARE, "")?;
            number(&at.field("metalness"), m.metalness, SHARE, "")?;
            number(&at.field("specular_f0"), m.specular_f0, SHARE, "")?;
            texture("base_color_texture", &m.base_color_texture)
        }
    }
}
