//! From a scene.json on this machine to a manifest.
//!
//! Names are relative to the folder of scene.json. They become keys of the
//! manifest and nothing else: no other machine ever makes a path of them.

use crate::exit::CliError;
use crate::json_paths;
use crate::output;
use shearwater_shared::hash::ContentHash;
use shearwater_shared::job::{AssetRef, Manifest};
use shearwater_shared::limits;
use shearwater_shared::scene::{self, SceneDescription, SceneError, references};
use std::collections::{BTreeMap, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What the scene's own file is called in errors of the library.
const SCENE_FILE: &str = "scene.json";

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
    /// The scene's file as the user named it.
    file: String,
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
    let scene_file = scene_file(scene_path);
    let bytes = read_scene(&scene_file)?;
    let bundle = collect_bytes(&bytes, &scene_file)?;
    bundle.description.doubts().iter().for_each(output::note);
    Ok(bundle)
}

/// The scene.json that a user means by its path or by that of its folder.
pub(crate) fn scene_file(path: &Path) -> PathBuf {
    if path.is_dir() {
        path.join(SCENE_FILE)
    } else {
        path.to_owned()
    }
}

/// The bytes of a scene.json.
pub(crate) fn read_scene(scene_file: &Path) -> Result<Vec<u8>, CliError> {
    std::fs::read(scene_file).map_err(|e| CliError::Scene(format!("{}: {e}", scene_file.display())))
}

/// All files of a scene whose scene.json would hold `bytes` and lie at `scene_file`.
pub(crate) fn collect_bytes(bytes: &[u8], scene_file: &Path) -> Result<Bundle, CliError> {
    let file = scene_file.display().to_string();
    let description = scene::parse(bytes).map_err(|error| at_file(error, &file))?;
    let mut wanted: VecDeque<Use> = uses(&description, bytes, &file).into();
    let folder = scene_file.parent().unwrap_or(Path::new("")).to_owned();
    let hash = ContentHash::of(bytes);
    let mut bundle = Bundle {
        manifest: Manifest {
            scene: hash,
            files: BTreeMap::new(),
        },
        sources: [(hash, Source(scene_file.to_owned()))].into(),
        description,
        file,
    };
    while let Some(wanting) = wanted.pop_front() {
        if !bundle.manifest.files.contains_key(&wanting.name) {
            wanted.extend(bundle.add(&folder, &wanting)?);
        }
    }
    Ok(bundle)
}

/// An error of the scene itself under the name of its file: a folder may hold
/// several scenes.
fn at_file(mut error: SceneError, file: &str) -> SceneError {
    if error.file == SCENE_FILE {
        file.clone_into(&mut error.file);
    }
    error
}

impl Bundle {
    /// The bytes of its files, by the names that the scene uses.
    pub(crate) fn assets(&self) -> Result<BTreeMap<String, Arc<[u8]>>, CliError> {
        let read = |(name, asset): (&String, &AssetRef)| {
            let Some(Source(path)) = self.sources.get(&asset.hash) else {
                return Err(CliError::Scene(format!("{name}: no such file")));
            };
            let bytes = std::fs::read(path).map_err(CliError::io(path))?;
            Ok((name.clone(), bytes.into()))
        };
        self.manifest.files.iter().map(read).collect()
    }

    /// The same for an error that a worker found.
    pub(crate) fn at_file(&self, error: CliError) -> CliError {
        match error {
            CliError::Scene(text) => {
                let rest = text.strip_prefix(SCENE_FILE);
                let rest = rest.filter(|rest| rest.starts_with(':'));
                CliError::Scene(rest.map_or(text.clone(), |rest| format!("{}{rest}", self.file)))
            }
            other => other,
        }
    }

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

/// Every file that the scene names, with its JSON path. Which ones these are is
/// for [`SceneDescription::files`] alone to say.
fn uses(scene: &SceneDescription, bytes: &[u8], file: &str) -> Vec<Use> {
    let names = scene.files();
    let json = serde_json::from_slice(bytes).unwrap_or_default();
    let mut paths = json_paths::find(&json, &names);
    let used = |name: String| Use {
        path: paths.remove(&name).unwrap_or_else(|| ".".to_owned()),
        file: file.to_owned(),
        name,
    };
    names.into_iter().map(used).collect()
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
