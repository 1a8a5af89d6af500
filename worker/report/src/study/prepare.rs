//! From a scene and a variant to what can be rendered.

use super::key;
use crate::variants::{Variant, patched};
use shearwater_shared::job::RenderSettings;
use shearwater_shared::scene::SceneDescription;
use shearwater_shared::stop::Stop;
use shearwater_tracer::{Assets, BuildOptions, Scene, Stage};
use std::cell::OnceCell;

/// A scene with the bytes of its files.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// What it says.
    pub description: SceneDescription,
    /// Its files, by the names that it uses.
    pub assets: Assets,
}

/// Finds the files of a scene: number of the scene, bytes of its scene.json; why not.
pub type Load<'a> = dyn Fn(usize, &[u8]) -> Result<Loaded, String> + 'a;

/// A scene that is ready for any seed, once it is built: where all is in the store, it
/// never is.
pub(super) struct Prepared {
    loaded: Loaded,
    stage: OnceCell<Stage>,
    pub(super) name: String,
    pub(super) size: (u32, u32),
    /// See [`key::of_scene`].
    pub(super) key: String,
}

/// Patch and parse. `size` overrides the scene's.
pub(super) fn prepare(
    load: &Load<'_>,
    number: usize,
    scene: &[u8],
    variant: &Variant,
    size: Option<(u32, u32)>,
) -> Result<Prepared, String> {
    let bytes = patched(scene, variant).map_err(|e| e.to_string())?;
    let loaded = load(number, &bytes)?;
    let image = &loaded.description.image;
    let size = size.unwrap_or((image.width, image.height));
    let key = key::of_scene(&bytes, &loaded.assets, size);
    Ok(Prepared {
        name: loaded.description.name.clone(),
        loaded,
        stage: OnceCell::new(),
        size,
        key,
    })
}

impl Prepared {
    /// The first frame with one seed.
    pub(super) fn frame(&self, spp: u32, seed: u64) -> Result<Scene, String> {
        let settings = RenderSettings {
            width: self.size.0,
            height: self.size.1,
            samples: spp,
            seed,
            frames: 1,
            first_frame: 0,
            stop: Stop::default(),
        };
        settings.validate().map_err(|e| e.to_string())?;
        let stage = match self.stage.get() {
            Some(stage) => stage,
            None => {
                let Loaded {
                    description,
                    assets,
                } = &self.loaded;
                let (stage, _) = Stage::build(description, assets, BuildOptions::default())
                    .map_err(|e| e.to_string())?;
                self.stage.get_or_init(|| stage)
            }
        };
        stage.frame(&settings, 0).map_err(|e| e.to_string())
    }
}
