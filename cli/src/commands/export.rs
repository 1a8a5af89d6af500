//! `shearwater export`.

use crate::exit::CliError;
use crate::output;
use crate::scene_files::{self, Bundle};
use clap::Args;
use serde_json::{Value, json};
use shearwater_shared::scene::{Material, SceneDescription, Water};
use shearwater_worker::export::{Export as Exported, ExportedParticle, export};
use shearwater_worker::water::{PictureError, water_pictures};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Write a scene as files that other renderers read
///
/// export.json says what is what: camera, materials, sun, water. Beside it lie a PLY
/// for every material of every instance, in the scene's coordinates (metres, y up);
/// the sky as an equirectangular EXR (its middle column looks along -z, columns grow
/// towards +x, its top row looks along +y); textures; the water's normals as EXR; and
/// the cloud particles. The frame is as its shutter opens.
///
/// Example: shearwater export scenes/golden-gate -o out
#[derive(Args, Debug)]
pub(crate) struct Export {
    /// scene.json, or the folder that holds it
    scene: PathBuf,
    /// Folder to write to; made if need be
    #[arg(short, long, value_name = "DIR", default_value = "out")]
    output: PathBuf,
    /// Number of the frame
    #[arg(long, value_name = "N", default_value_t = 0)]
    frame: u32,
}

/// A file to write and its name.
type File = (String, Arc<[u8]>);

pub(crate) async fn run(args: &Export, json: bool) -> Result<(), CliError> {
    let bundle = scene_files::collect(&args.scene)?;
    let scene = &bundle.description;
    let assets = read(&bundle).await?;
    let exported =
        export(scene, &assets, args.frame).map_err(|error| bundle.at_file(error.into()))?;

    let mut files: Vec<File> = Vec::new();
    let textures = textures(&exported, &assets, &mut files);
    let water = water(scene, args.frame, &mut files)?;
    let description = json!({
        "version": 1,
        "name": scene.name,
        "units": "metres, y up, linear Rec. 709",
        "image": scene.image,
        "camera": {
            "position_m": exported.eye_m,
            "target_m": exported.target_m,
            "up": scene.camera.up,
            "vertical_fov_deg": scene.camera.vertical_fov_deg,
            "lens_radius_m": scene.camera.lens_radius_m,
            "focus_distance_m": scene.camera.focus_distance_m,
        },
        "meshes": meshes(&exported, &mut files),
        "textures": textures,
        "particles": particles(&exported.particles, &mut files),
        "sky": exported.sky.as_ref().map(|sky| {
            files.push(("sky.exr".to_owned(), sky.exr.as_slice().into()));
            json!({"file": "sky.exr", "width": sky.width, "height": sky.height})
        }),
        "sun": exported.sun.map(|sun| json!({
            "direction": sun.direction,
            "angular_radius_deg": sun.angular_radius_deg,
            "radiance": sun.radiance,
        })),
        "water": water,
    });
    files.push((
        "export.json".to_owned(),
        description.to_string().into_bytes().into(),
    ));
    write(&args.output, &files)?;
    if json {
        let names: Vec<_> = files
            .iter()
            .map(|(name, _)| args.output.join(name))
            .collect();
        output::object(&json!({ "files": names }));
    } else {
        output::line(format_args!(
            "{} meshes, {} particles, {} files in {}",
            exported.meshes.len(),
            exported.particles.len(),
            files.len(),
            args.output.display()
        ));
    }
    Ok(())
}

async fn read(bundle: &Bundle) -> Result<BTreeMap<String, Arc<[u8]>>, CliError> {
    let mut assets = BTreeMap::new();
    for (name, asset) in &bundle.manifest.files {
        if let Some(source) = bundle.sources.get(&asset.hash) {
            assets.insert(name.clone(), source.read().await?.into());
        }
    }
    Ok(assets)
}

/// The textures under names of their own, by the names that materials use.
fn textures(
    exported: &Exported,
    assets: &BTreeMap<String, Arc<[u8]>>,
    files: &mut Vec<File>,
) -> BTreeMap<String, String> {
    let mut names = BTreeMap::new();
    for name in exported
        .meshes
        .iter()
        .flat_map(|mesh| texture_names(&mesh.material))
    {
        let Some(bytes) = assets.get(name) else {
            continue;
        };
        if !names.contains_key(name) {
            let ending = Path::new(name).extension().and_then(|e| e.to_str());
            let file = format!("texture-{}.{}", names.len(), ending.unwrap_or("png"));
            files.push((file.clone(), Arc::clone(bytes)));
            names.insert(name.to_owned(), file);
        }
    }
    names
}

fn texture_names(material: &Material) -> impl Iterator<Item = &str> {
    let channels = match material {
        Material::Ggx(m) => [&m.roughness_texture, &m.metalness_texture].map(Option::as_ref),
        Material::Lambert(_) | Material::Phong(_) => [None, None],
    };
    let of_channels = channels.into_iter().flatten().map(|c| c.file.as_str());
    material.color_texture().into_iter().chain(of_channels)
}

fn meshes(exported: &Exported, files: &mut Vec<File>) -> Vec<Value> {
    let mut list = Vec::new();
    for (number, mesh) in exported.meshes.iter().enumerate() {
        let file = format!("mesh-{number:03}.ply");
        list.push(json!({
            "file": file,
            "instance": mesh.instance,
            "triangles": mesh.triangles,
            "material": mesh.material,
        }));
        files.push((file, mesh.ply.as_slice().into()));
    }
    list
}

/// Ten floats for each particle, little endian.
fn particles(all: &[ExportedParticle], files: &mut Vec<File>) -> Option<Value> {
    if all.is_empty() {
        return None;
    }
    let floats = all.iter().flat_map(|p| {
        let [x, y, z] = p.centre_m.map(|c| c as f32);
        let ([rx, ry, rz], [r, g, b]) = (p.radii_m, p.albedo);
        [x, y, z, rx, ry, rz, p.opacity, r, g, b]
    });
    let bytes: Vec<u8> = floats.flat_map(f32::to_le_bytes).collect();
    files.push(("particles.f32".to_owned(), bytes.into()));
    Some(json!({
        "file": "particles.f32",
        "count": all.len(),
        "columns": ["x", "y", "z", "radius_x", "radius_y", "radius_z", "opacity",
                    "albedo_r", "albedo_g", "albedo_b"],
        "meaning": "ellipsoids along the axes; `opacity` acts at each crossing of the wall, \
                    which is ideally diffuse on both sides",
    }))
}

fn water(
    scene: &SceneDescription,
    frame: u32,
    files: &mut Vec<File>,
) -> Result<Option<Value>, CliError> {
    let Some(water) = &scene.water else {
        return Ok(None);
    };
    let time_s = scene.frame_time_s(frame);
    let look = Water::look(water);
    let normals = match water_pictures(water, time_s) {
        Ok(pictures) => {
            let file = "water-normals.exr";
            files.push((file.to_owned(), pictures.normal_exr.into()));
            Some(json!({
                "file": file,
                "points": pictures.points,
                "side_m": pictures.side_m,
                "origin_m": look.velocity_mps.map(|v| v * time_s),
                "meaning": "unit normals along x, y, z; rows along z, columns along x; the \
                            first point lies at `origin_m` (x, z), and the tile repeats",
            }))
        }
        Err(PictureError::Flat) => None,
        Err(error) => return Err(CliError::Scene(format!("scene.json: water: {error}"))),
    };
    Ok(Some(json!({
        "height_m": look.height_m,
        "ior": look.ior,
        "roughness": look.roughness,
        "body_color": look.body_color,
        "normals": normals,
    })))
}

fn write(folder: &Path, files: &[File]) -> Result<(), CliError> {
    std::fs::create_dir_all(folder).map_err(CliError::io(folder))?;
    for (name, bytes) in files {
        let path = folder.join(name);
        std::fs::write(&path, bytes).map_err(CliError::io(&path))?;
    }
    Ok(())
}
