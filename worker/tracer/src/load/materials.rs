//! Which material each name in an OBJ means.

use super::{Assets, LoadedMesh, MtlMap, MtlMaterial, UNNAMED_MATERIAL};
use shearwater_shared::scene::{
    Channel, ChannelTexture, GgxMaterial, GgxModel, LambertMaterial, LobeSampling, Material, Mesh,
    PhongMaterial, SceneError,
};
use std::collections::BTreeMap;

/// Reflectance of faces that no file says anything about.
const DEFAULT_ALBEDO: f32 = 0.5;
/// Roughness where an MTL file gives a metalness only.
const DEFAULT_ROUGHNESS: f32 = 0.5;
/// Most names that an error lists.
const LISTED_MAX: usize = 12;

/// One material of the scene's own kind for each of `loaded.materials`.
///
/// A name means what `mesh.materials` maps it to, else the scene's material of
/// that name, else the MTL file's. Texture names in the result are asset names.
///
/// # Errors
/// A name that nothing defines (with the names that are known), or an MTL
/// texture that is not among the assets (with the line that names it).
pub fn resolve_materials(
    file: &str,
    mesh: &Mesh,
    loaded: &LoadedMesh,
    scene: &BTreeMap<String, Material>,
    assets: &Assets,
) -> Result<Vec<Material>, SceneError> {
    let mut used = vec![false; loaded.materials.len()];
    for &material in &loaded.material_of {
        if let Some(used) = used.get_mut(usize::from(material)) {
            *used = true;
        }
    }
    let names = loaded.materials.iter().zip(&loaded.material_lines);
    names
        .zip(used)
        .map(|((name, line), used)| {
            if !used {
                // Named, but no face has it: whatever it was, it is not seen.
                return Ok(lambert([DEFAULT_ALBEDO; 3], None));
            }
            let meant = mesh.materials.get(name).unwrap_or(name);
            if let Some(material) = scene.get(meant) {
                return Ok(material.clone());
            }
            if let Some(material) = loaded.mtl.get(name) {
                check_textures(material, assets)?;
                return Ok(from_mtl(material));
            }
            if name == UNNAMED_MATERIAL {
                return Ok(lambert([DEFAULT_ALBEDO; 3], None));
            }
            let message = format!(
                "`{name}`: no material of that name; the scene has {}, the MTL files have {}",
                list(scene.keys()),
                list(loaded.mtl.keys())
            );
            Err(SceneError::new(file, format!("line {line}"), message))
        })
        .collect()
}

fn list<'a>(names: impl ExactSizeIterator<Item = &'a String>) -> String {
    let more = names.len().saturating_sub(LISTED_MAX);
    let shown: Vec<String> = names.take(LISTED_MAX).map(|n| format!("`{n}`")).collect();
    match (shown.is_empty(), more) {
        (true, _) => "none".to_owned(),
        (false, 0) => shown.join(", "),
        (false, more) => format!("{} and {more} more", shown.join(", ")),
    }
}

fn check_textures(material: &MtlMaterial, assets: &Assets) -> Result<(), SceneError> {
    let maps = [&material.map_kd, &material.map_pr, &material.map_pm];
    for MtlMap { asset, file, line } in maps.into_iter().flatten() {
        if !assets.contains_key(asset) {
            let message = format!("the texture is missing; line {line} of {file} names it");
            return Err(SceneError::new(asset, ".", message));
        }
    }
    Ok(())
}

fn lambert(albedo: [f32; 3], albedo_texture: Option<String>) -> Material {
    Material::Lambert(LambertMaterial {
        albedo,
        albedo_texture,
    })
}

/// The nearest material of ours: GGX where the PBR extension is used, Phong
/// where there is a specular share, else Lambert.
fn from_mtl(mtl: &MtlMaterial) -> Material {
    let texture = mtl.map_kd.as_ref().map(|map| map.asset.clone());
    let physical = [mtl.roughness, mtl.metalness].iter().any(Option::is_some)
        || mtl.map_pr.is_some()
        || mtl.map_pm.is_some();
    if physical {
        return Material::Ggx(metallic(mtl, texture));
    }
    if mtl.ks == [0.0; 3] {
        return lambert(mtl.kd, texture);
    }
    // Files often ask for more light than arrives: scale both shares down by
    // the channel that asks for most, which keeps the colours.
    let most = mtl
        .kd
        .iter()
        .zip(&mtl.ks)
        .fold(1.0_f32, |most, (d, s)| most.max(d + s));
    Material::Phong(PhongMaterial {
        kd: mtl.kd.map(|d| d / most),
        kd_texture: texture,
        ks: mtl.ks.map(|s| s / most),
        exponent: mtl.ns,
        sampling: LobeSampling::default(),
    })
}

/// The PBR extension's material: a map without a number stands for itself.
fn metallic(mtl: &MtlMaterial, base_color_texture: Option<String>) -> GgxMaterial {
    let channel = |map: &Option<MtlMap>| {
        map.as_ref().map(|map| ChannelTexture {
            file: map.asset.clone(),
            channel: Channel::R,
        })
    };
    let unsaid = if mtl.map_pr.is_some() {
        1.0
    } else {
        DEFAULT_ROUGHNESS
    };
    GgxMaterial {
        base_color: mtl.kd,
        base_color_texture,
        roughness: mtl.roughness.unwrap_or(unsaid),
        roughness_texture: channel(&mtl.map_pr),
        metalness: mtl.metalness,
        metalness_texture: channel(&mtl.map_pm),
        specular_f0: 0.04,
        conductor: None,
        f82: None,
        coat: None,
        model: GgxModel::default(),
        sampling: LobeSampling::default(),
    }
}
