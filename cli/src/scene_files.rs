//! From a scene.json on this machine to a manifest.
//!
//! Names are relative to the folder of scene.json. They become keys of the
//! manifest and nothing else: no other machine ever makes a path of them.

use crate::exit::CliError;
use crate::output;
use shearwater_shared::hash::ContentHash;
use shearwater_shared::job::{AssetRef, Manifest};
use shearwater_shared::limits;
use shearwater_shared::scene::{self, Material, SceneDescription, SceneError, Sky, references};
use std::collections::{BTreeMap, VecDeque};
use std::path::{Path, PathBuf};

/// Where the bytes of an asset come from.
#[derive(Clone, Debug)]
pub(crate) struct Source(PathBuf);

impl Source {
    /// The bytes.
    pub(crate) async fn read(&self) -> Result<Vec<u8>, CliError> {
        let bytes = tokio::fs::read(&self.0).await;
        bytes.map_err(CliError::io(&self.0))
    }
}

/// A scene with everything that belongs to it.
#[derive(Clone, Debug)]
pub(crate) struct Bundle {
    /// What scene.json says.
    pub(crate) description: SceneDescription,
    /// Names and contents.
    pub(crate) manifest: Manifest,
    /// Where to find each content.
    pub(crate) sources: BTreeMap<ContentHash, Source>,
}

/// A name that somebody uses.
#[derive(Clone, Debug)]
struct Use {
    /// Name of the asset.
    name: String,
    /// File in which it is used.
    file: String,
    /// Where in that file.
    path: String,
}

impl Use {
    fn error(&self, message: String) -> CliError {
        SceneError::new(&self.file, &self.path, message).into()
    }
}

/// Read a scene and all its files.
pub(crate) fn collect(scene_path: &Path) -> Result<Bundle, CliError> {
    let scene_file = if scene_path.is_dir() {
        scene_path.join("scene.json")
    } else {
        scene_path.to_owned()
    };
    let bytes = std::fs::read(&scene_file)
        .map_err(|e| CliError::Scene(format!("{}: {e}", scene_file.display())))?;
    let description = scene::parse(&bytes)?;
    description.doubts().iter().for_each(output::note);
    let folder = scene_file.parent().unwrap_or(Path::new("")).to_owned();
    let hash = ContentHash::of(&bytes);
    let mut bundle = Bundle {
        manifest: Manifest {
            scene: hash,
            files: BTreeMap::new(),
        },
        sources: [(hash, Source(scene_file))].into(),
        description,
    };
    let mut wanted: VecDeque<Use> = uses(&bundle.description).into();
    while let Some(wanting) = wanted.pop_front() {
        if !bundle.manifest.files.contains_key(&wanting.name) {
            wanted.extend(bundle.add(&folder, &wanting)?);
        }
    }
    Ok(bundle)
}

impl Bundle {
    /// Add one file; what it refers to in turn.
    fn add(&mut self, folder: &Path, wanting: &Use) -> Result<Vec<Use>, CliError> {
        if self.manifest.files.len() >= limits::ASSETS_MAX {
            return Err(wanting.error(format!("more than {} files", limits::ASSETS_MAX)));
        }
        let name = &wanting.name;
        if name.is_empty() || name.len() > limits::ASSET_NAME_BYTES_MAX {
            let most = limits::ASSET_NAME_BYTES_MAX;
            return Err(wanting.error(format!("a file name must have 1 to {most} bytes")));
        }
        let path = folder.join(name);
        let missing =
            |e: std::io::Error| wanting.error(format!("file `{name}` ({}): {e}", path.display()));
        let meta = std::fs::metadata(&path).map_err(missing)?;
        if !meta.is_file() {
            return Err(wanting.error(format!("`{name}` is not a file")));
        }
        if meta.len() > limits::ASSET_BYTES_MAX {
            let (size, most) = (meta.len(), limits::ASSET_BYTES_MAX);
            return Err(wanting.error(format!("`{name}` has {size} bytes: at most {most}")));
        }
        let bytes = std::fs::read(&path).map_err(missing)?;
        let hash = ContentHash::of(&bytes);
        let asset = AssetRef {
            hash,
            size: bytes.len() as u64,
        };
        self.manifest.files.insert(name.clone(), asset);
        self.sources.insert(hash, Source(path));
        Ok(references_of(name, &bytes))
    }
}

/// Every name in scene.json with its JSON path.
fn uses(scene: &SceneDescription) -> Vec<Use> {
    let mut uses = Vec::new();
    let mut add = |name: &str, path: String| {
        uses.push(Use {
            name: name.to_owned(),
            file: "scene.json".to_owned(),
            path,
        });
    };
    for (key, mesh) in &scene.meshes {
        add(&mesh.file, format!("meshes.{key}.file"));
    }
    for (key, material) in &scene.materials {
        let field = match material {
            Material::Lambert(_) => "albedo_texture",
            Material::Phong(_) => "kd_texture",
            Material::Ggx(_) => "base_color_texture",
        };
        for texture in material.textures() {
            add(texture, format!("materials.{key}.{field}"));
        }
    }
    if let Some(Sky::Map(map)) = &scene.sky {
        add(&map.file, "sky.file".to_owned());
    }
    // A file that the list above does not know yet is found all the same.
    for name in scene.files() {
        add(&name, ".".to_owned());
    }
    uses
}

/// What an OBJ or MTL file refers to.
fn references_of(name: &str, bytes: &[u8]) -> Vec<Use> {
    let extension = Path::new(name).extension().unwrap_or_default();
    let (path, names) = if extension.eq_ignore_ascii_case("obj") {
        ("mtllib", references::obj_libraries(bytes))
    } else if extension.eq_ignore_ascii_case("mtl") {
        ("map", references::mtl_textures(bytes))
    } else {
        return Vec::new();
    };
    let used = |other: String| Use {
        name: references::resolve(name, &other),
        file: name.to_owned(),
        path: path.to_owned(),
    };
    names.into_iter().map(used).collect()
}
