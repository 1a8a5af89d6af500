//! Ranges of materials.

use super::super::at::At;
use super::super::range::{Range, SHARE, asset, count, number, numbers, shares};
use super::super::{
    ChannelTexture, GgxMaterial, GgxModel, LobeSampling, Material, SceneDescription, SceneError,
};
use crate::limits;

/// Parts of a complex index of refraction: metals stay below 10 in visible light.
const INDEX: Range = Range::Closed(0.0, 20.0);

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
            texture("base_color_texture", &m.base_color_texture)?;
            ggx(at, m)
        }
    }
}

fn ggx(at: &At<'_>, m: &GgxMaterial) -> Result<(), SceneError> {
    let channel = |field: &str, texture: &Option<ChannelTexture>| {
        let at = at.field(field);
        texture
            .as_ref()
            .map_or(Ok(()), |texture| asset(&at.field("file"), &texture.file))
    };
    numbers(&at.field("base_color"), &m.base_color, SHARE, "")?;
    number(&at.field("roughness"), m.roughness, SHARE, "")?;
    number(&at.field("metalness"), m.metalness(), SHARE, "")?;
    number(&at.field("specular_f0"), m.specular_f0, SHARE, "")?;
    channel("roughness_texture", &m.roughness_texture)?;
    channel("metalness_texture", &m.metalness_texture)?;
    if let Some(metal) = &m.conductor {
        let at = at.field("conductor");
        numbers(&at.field("n"), &metal.n, INDEX, "")?;
        numbers(&at.field("k"), &metal.k, INDEX, "")?;
    }
    if let Some(tint) = &m.f82 {
        numbers(&at.field("f82"), tint, SHARE, "")?;
    }
    if let Some(coat) = &m.coat {
        let at = at.field("coat");
        number(&at.field("weight"), coat.weight, SHARE, "")?;
        number(&at.field("roughness"), coat.roughness, SHARE, "")?;
        number(&at.field("ior"), coat.ior, Range::Closed(1.0, 3.0), "")?;
    }
    together(at, m)
}

// Which settings go together.
fn together(at: &At<'_>, m: &GgxMaterial) -> Result<(), SceneError> {
    if m.conductor.is_some() && m.f82.is_some() {
        let message = "`conductor` and `f82` both say what the metal is: expected one of them";
        return Err(at.field("f82").error(message));
    }
    let only_corrected = [
        ("conductor", m.conductor.is_some()),
        ("f82", m.f82.is_some()),
        ("coat", m.coat.is_some()),
    ];
    for (field, given) in only_corrected {
        if given && m.model == GgxModel::Report {
            let message = "the report's formulas have none: expected `model: corrected`";
            return Err(at.field(field).error(message));
        }
    }
    if m.sampling == LobeSampling::Lobe && m.model == GgxModel::Corrected {
        let message = "`lobe`: expected `mixture`, or `model: report`";
        return Err(at.field("sampling").error(message));
    }
    Ok(())
}
