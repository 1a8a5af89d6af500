//! The scene description, version 1: what `scene.json` says.
//!
//! These types mirror the file and do nothing; [`parse()`] reads and checks one,
//! the tracer builds from it. Unknown fields are refused everywhere. Metres,
//! seconds, degrees; y is up; colours are linear Rec. 709 unless they come from
//! an 8-bit texture, which is sRGB.

mod animation;
mod at;
mod camera;
mod cloud;
mod doubts;
mod material;
mod mesh;
mod parse;
mod post;
mod range;
pub mod references;
mod sampling;
mod sky;
mod tagged;
#[cfg(test)]
mod test_scene;
mod validate;
mod volume;
mod water;

pub use animation::{Animation, CameraKey, InstanceKey, Spin};
pub use camera::Camera;
pub use cloud::{Cloud, Formation, ImageFormation, ParticleCloud, RadialFormation, SpriteCloud};
pub use material::{
    Channel, ChannelTexture, Coat, Conductor, GgxMaterial, GgxModel, LambertMaterial, LobeSampling,
    Material, PhongMaterial,
};
pub use mesh::{Instance, Mesh, Normals};
pub use parse::{SceneError, parse, schema_json};
pub use post::{Bloom, Post, View};
pub use sampling::{Mis, Roulette, RouletteRule, Sampler, Sampling, SkySampling};
pub use sky::{AtmosphereSky, ConstantSky, DomeSky, MapSky, Sky, Sun};
pub use volume::{
    EllipsoidVolume, GridVolume, March, Tracking, VolumeCloud, VolumeMethod, VolumeNoise,
    VolumeShape,
};
pub use water::{
    FlatWater, GerstnerWater, GerstnerWave, Profile, TessendorfWater, Water, WaterLook, Whitecaps,
};

use crate::stop::ErrorTarget;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use tagged::unique_map;

/// The version of the format that this build reads.
pub const SCENE_VERSION: u32 = 1;

/// A whole scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneDescription {
    /// Format version; 1.
    #[schemars(range(min = 1, max = 1))]
    pub version: u32,
    /// Name of the scene; also of the files that `render` writes.
    #[schemars(length(min = 1, max = 200))]
    pub name: String,
    /// Size of the picture.
    pub image: Image,
    /// What a job renders when the user says nothing else.
    #[serde(default)]
    pub job: JobDefaults,
    /// Frames of a moving picture; none is one picture at time 0.
    #[serde(default)]
    pub animation: Option<Animation>,
    /// Camera.
    pub camera: Camera,
    /// Materials by name.
    #[serde(default, deserialize_with = "unique_map")]
    pub materials: BTreeMap<String, Material>,
    /// Meshes by name.
    #[serde(default, deserialize_with = "unique_map")]
    pub meshes: BTreeMap<String, Mesh>,
    /// Placed meshes; one mesh may be placed often without being copied.
    #[serde(default)]
    pub instances: Vec<Instance>,
    /// Light from all directions.
    #[serde(default)]
    pub sky: Option<Sky>,
    /// A distant sphere of light.
    #[serde(default)]
    pub sun: Option<Sun>,
    /// A sea to the horizon.
    #[serde(default)]
    pub water: Option<Water>,
    /// Clouds.
    #[serde(default)]
    pub clouds: Vec<Cloud>,
    /// How paths are sampled.
    #[serde(default)]
    pub sampling: Sampling,
    /// From radiance to a picture.
    #[serde(default)]
    pub post: Post,
}

/// Size of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Image {
    /// Columns, 1 to 16384.
    #[schemars(range(min = 1, max = 16384))]
    pub width: u32,
    /// Rows, 1 to 16384.
    #[schemars(range(min = 1, max = 16384))]
    pub height: u32,
}

/// What a job renders when the user says nothing else.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JobDefaults {
    /// Samples per pixel, even; powers of two converge best.
    #[serde(default = "default_samples")]
    #[schemars(range(min = 2, max = 16_777_216), extend("multipleOf" = 2))]
    pub samples: u32,
    /// Stop where the relative mean squared error is at most this, for example 0.01;
    /// `samples` is then the most that any pixel gets.
    #[serde(default)]
    #[schemars(range(min = 1e-9, max = 10))]
    pub error: Option<ErrorTarget>,
    /// Stop after so many seconds of rendering; `samples` is then the most that any
    /// pixel gets.
    #[serde(default)]
    #[schemars(range(min = 1, max = 31_622_400))]
    pub seconds: Option<u32>,
}

const fn default_samples() -> u32 {
    64
}

impl Default for JobDefaults {
    fn default() -> Self {
        Self {
            samples: default_samples(),
            error: None,
            seconds: None,
        }
    }
}

impl SceneDescription {
    /// Names of every file that the scene itself refers to (meshes, textures,
    /// sky, clouds), sorted. Files that an OBJ refers to are found by
    /// reading the OBJ.
    #[must_use]
    pub fn files(&self) -> BTreeSet<String> {
        let mut files: BTreeSet<String> =
            self.meshes.values().map(|mesh| mesh.file.clone()).collect();
        files.extend(
            self.materials
                .values()
                .flat_map(Material::textures)
                .map(str::to_owned),
        );
        files.extend(self.sky.iter().filter_map(Sky::file).map(str::to_owned));
        files.extend(self.clouds.iter().filter_map(|c| match c.formation() {
            Some(Formation::Image(image)) => Some(image.file.clone()),
            _ => None,
        }));
        files.extend(self.volumes().filter_map(|(_, cloud)| match &cloud.shape {
            VolumeShape::Grid(grid) => Some(grid.file.clone()),
            VolumeShape::Ellipsoid(_) => None,
        }));
        let texture = self.water.as_ref().and_then(Water::texture);
        files.extend(texture.map(str::to_owned));
        files
    }

    /// The clouds that are volumes, with their places in `clouds`.
    pub fn volumes(&self) -> impl Iterator<Item = (usize, &VolumeCloud)> {
        self.clouds
            .iter()
            .enumerate()
            .filter_map(|(i, cloud)| match cloud {
                Cloud::Volume(volume) => Some((i, volume)),
                _ => None,
            })
    }
}
