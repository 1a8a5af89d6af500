//! Materials of a built scene.

use super::Assets;
use crate::bsdf::{Bsdf, Ggx, GgxParameters, GgxReport, Phong, Tables};
use crate::load::{Texture, load_texture};
use glam::Vec3;
use shearwater_shared::limits::TEXTURES_BYTES_MAX;
use shearwater_shared::scene::{GgxModel, Material, SceneError};
use std::collections::BTreeMap;

/// A material and the texture that tints it.
#[derive(Clone, Debug)]
pub(super) struct SurfaceMaterial {
    kind: Kind,
    /// Number of the texture, if it has one.
    pub texture: Option<u32>,
}

#[derive(Clone, Debug)]
enum Kind {
    Lambert {
        albedo: Vec3,
    },
    Phong {
        kd: Vec3,
        ks: Vec3,
        exponent: f32,
    },
    Ggx {
        plain: Ggx,
        base_color: Vec3,
    },
    GgxReport {
        plain: GgxReport,
        parameters: GgxParameters,
    },
}

/// The textures of a scene, each read once.
pub(super) struct Textures<'a> {
    assets: &'a Assets,
    numbers: BTreeMap<String, u32>,
    /// In order of number.
    pub list: Vec<Texture>,
    /// Texts for people.
    pub notes: Vec<String>,
    bytes: u64,
}

impl<'a> Textures<'a> {
    pub(super) fn new(assets: &'a Assets) -> Self {
        Self {
            assets,
            numbers: BTreeMap::new(),
            list: Vec::new(),
            notes: Vec::new(),
            bytes: 0,
        }
    }

    fn number(&mut self, file: &str) -> Result<u32, SceneError> {
        if let Some(&number) = self.numbers.get(file) {
            return Ok(number);
        }
        let missing = || SceneError::new(file, ".", "the texture was not supplied with the scene");
        let texture = load_texture(file, self.assets.get(file).ok_or_else(missing)?)?;
        self.bytes += texture.bytes() as u64;
        if self.bytes > TEXTURES_BYTES_MAX {
            let message = format!(
                "with this texture the scene's textures take {} bytes: at most {TEXTURES_BYTES_MAX}",
                self.bytes
            );
            return Err(SceneError::new(file, ".", message));
        }
        if texture.bad_texels > 0 {
            let bad = texture.bad_texels;
            self.notes.push(format!(
                "texture {file}: {bad} texels outside 0 to 1 are clamped"
            ));
        }
        let number = self.list.len() as u32;
        self.list.push(texture);
        self.numbers.insert(file.to_owned(), number);
        Ok(number)
    }
}

impl SurfaceMaterial {
    /// A material of the scene, called `name` there.
    pub(super) fn new(
        name: &str,
        material: &Material,
        tables: &Tables,
        textures: &mut Textures<'_>,
    ) -> Result<Self, SceneError> {
        let texture = material
            .textures()
            .next()
            .map(|file| textures.number(file))
            .transpose()?;
        let invalid = |e: &dyn std::fmt::Display| {
            SceneError::new("scene.json", format!("materials.{name}"), e.to_string())
        };
        let kind = match material {
            Material::Lambert(m) => Kind::Lambert {
                albedo: Vec3::from_array(m.albedo),
            },
            Material::Phong(m) => {
                let phong = Phong::new(Vec3::from_array(m.kd), Vec3::from_array(m.ks), m.exponent)
                    .map_err(|e| invalid(&e))?;
                Kind::Phong {
                    kd: phong.kd,
                    ks: phong.ks,
                    exponent: phong.exponent,
                }
            }
            Material::Ggx(m) => {
                let parameters = GgxParameters {
                    base_color: Vec3::from_array(m.base_color),
                    metalness: m.metalness,
                    alpha: m.roughness * m.roughness,
                    dielectric_f0: m.specular_f0,
                };
                match m.model {
                    GgxModel::Corrected => Kind::Ggx {
                        plain: Ggx::new(tables, &parameters).map_err(|e| invalid(&e))?,
                        base_color: parameters.base_color,
                    },
                    GgxModel::Report => Kind::GgxReport {
                        plain: GgxReport::new(&parameters).map_err(|e| invalid(&e))?,
                        parameters,
                    },
                }
            }
        };
        Ok(Self { kind, texture })
    }

    /// Scattering where the texture has the colour `tint`.
    #[inline]
    pub(super) fn bsdf(&self, tables: &Tables, tint: Vec3) -> Bsdf {
        match &self.kind {
            Kind::Lambert { albedo } => Bsdf::Lambert {
                albedo: *albedo * tint,
            },
            Kind::Phong { kd, ks, exponent } => Bsdf::Phong(Phong {
                kd: *kd * tint,
                ks: *ks,
                exponent: *exponent,
            }),
            Kind::Ggx { plain, .. } if self.texture.is_none() => Bsdf::Ggx(*plain),
            Kind::Ggx { plain, base_color } => {
                Bsdf::Ggx(plain.with_base_color(tables, *base_color * tint))
            }
            Kind::GgxReport { plain, .. } if self.texture.is_none() => Bsdf::GgxReport(*plain),
            Kind::GgxReport {
                plain,
                parameters: p,
            } => Bsdf::GgxReport(plain.with_base_color(
                p.base_color * tint,
                p.metalness,
                p.dielectric_f0,
            )),
        }
    }
}

/// Whether a material needs the tables of the corrected GGX.
pub(super) fn needs_schlick(material: &Material) -> bool {
    matches!(material, Material::Ggx(m) if m.model == GgxModel::Corrected)
}
