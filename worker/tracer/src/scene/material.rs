//! Materials of a built scene.

use super::Assets;
use crate::bsdf::{
    Bsdf, CoatParameters, Ggx, GgxParameters, GgxReport, LayerParameters, Layered, LobeSampling,
    MetalLaw, Phong, TableNeeds, Tables,
};
use crate::load::{Encoding, Texture, load_texture};
use glam::{Vec2, Vec3};
use shearwater_shared::limits::TEXTURES_BYTES_MAX;
use shearwater_shared::scene::{
    self, ChannelTexture, GgxMaterial, GgxModel, Material, PhongMaterial, SceneError,
};
use std::collections::BTreeMap;

/// A material and its textures.
#[derive(Clone, Debug)]
pub(super) struct SurfaceMaterial {
    kind: Kind,
    /// Number of the texture that tints it, if it has one.
    tint: Option<u32>,
    roughness: Option<ChannelMap>,
    metalness: Option<ChannelMap>,
    is_textured: bool,
}

/// One channel of a texture.
#[derive(Clone, Copy, Debug)]
struct ChannelMap {
    texture: u32,
    channel: u8,
}

#[derive(Clone, Debug)]
enum Kind {
    Lambert {
        albedo: Vec3,
    },
    Phong(Phong),
    Ggx {
        plain: Ggx,
        base_color: Vec3,
    },
    /// [`Kind::Ggx`] whose roughness or metalness follows a texture.
    GgxMapped {
        plain: Ggx,
        factors: Factors,
    },
    GgxReport {
        plain: GgxReport,
        factors: Factors,
        dielectric_f0: f32,
    },
    Layered {
        plain: Layered,
        factors: Factors,
    },
}

/// What textures multiply.
#[derive(Clone, Copy, Debug)]
struct Factors {
    base_color: Vec3,
    metalness: f32,
    /// Perceptual.
    roughness: f32,
}

/// What a GGX material is at a texel.
struct Texel {
    base_color: Vec3,
    metalness: f32,
    alpha: f32,
}

/// The textures of a scene, each read once.
pub(super) struct Textures<'a> {
    assets: &'a Assets,
    numbers: BTreeMap<(String, Encoding), u32>,
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

    /// Number of the texture in a file, which is read if it is new.
    pub(super) fn number(&mut self, file: &str, encoding: Encoding) -> Result<u32, SceneError> {
        // Another encoding is another texture: its texels mean something else.
        let key = (file.to_owned(), encoding);
        if let Some(&number) = self.numbers.get(&key) {
            return Ok(number);
        }
        let missing = || SceneError::new(file, ".", "the texture was not supplied with the scene");
        let texture = load_texture(file, self.assets.get(file).ok_or_else(missing)?, encoding)?;
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
        self.numbers.insert(key, number);
        Ok(number)
    }

    fn channel(
        &mut self,
        texture: &Option<ChannelTexture>,
    ) -> Result<Option<ChannelMap>, SceneError> {
        let Some(texture) = texture else {
            return Ok(None);
        };
        Ok(Some(ChannelMap {
            texture: self.number(&texture.file, Encoding::Linear)?,
            channel: match texture.channel {
                scene::Channel::R => 0,
                scene::Channel::G => 1,
                scene::Channel::B => 2,
            },
        }))
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
        let invalid = |e: crate::bsdf::BsdfError| {
            SceneError::new("scene.json", format!("materials.{name}"), e.to_string())
        };
        let tint = material.color_texture();
        let tint = tint
            .map(|file| textures.number(file, Encoding::Srgb))
            .transpose()?;
        let (mut roughness, mut metalness) = (None, None);
        let kind = match material {
            Material::Lambert(m) => Kind::Lambert {
                albedo: Vec3::from_array(m.albedo),
            },
            Material::Phong(m) => Kind::Phong(phong(m).map_err(invalid)?),
            Material::Ggx(m) => {
                roughness = textures.channel(&m.roughness_texture)?;
                metalness = textures.channel(&m.metalness_texture)?;
                let mapped = roughness.is_some() || metalness.is_some();
                ggx(m, mapped, tables).map_err(invalid)?
            }
        };
        Ok(Self {
            kind,
            is_textured: tint.is_some() || roughness.is_some() || metalness.is_some(),
            tint,
            roughness,
            metalness,
        })
    }

    /// Whether it looks anything up by texture coordinates.
    #[inline]
    pub(super) fn is_textured(&self) -> bool {
        self.is_textured
    }

    /// Scattering at texture coordinates `uv`, where there are any.
    #[inline]
    pub(super) fn bsdf(&self, tables: &Tables, textures: &[Texture], uv: Option<Vec2>) -> Bsdf {
        let tint = match (self.tint, uv) {
            (Some(texture), Some(uv)) => {
                Vec3::from_array(textures[texture as usize].rgb(uv.x, uv.y))
            }
            _ => Vec3::ONE,
        };
        match &self.kind {
            Kind::Lambert { albedo } => Bsdf::Lambert {
                albedo: *albedo * tint,
            },
            Kind::Phong(phong) => Bsdf::Phong(Phong {
                kd: phong.kd * tint,
                ..*phong
            }),
            Kind::Ggx { plain, .. } if self.tint.is_none() => Bsdf::Ggx(*plain),
            Kind::Ggx { plain, base_color } => {
                Bsdf::Ggx(plain.with_base_color(tables, *base_color * tint))
            }
            Kind::GgxMapped { plain, factors } => {
                let at = self.texel(factors, tint, textures, uv);
                Bsdf::Ggx(plain.with_texel(tables, at.base_color, at.metalness, at.alpha))
            }
            Kind::GgxReport { plain, .. } if !self.is_textured => Bsdf::GgxReport(*plain),
            Kind::GgxReport {
                plain,
                factors,
                dielectric_f0,
            } => {
                let at = self.texel(factors, tint, textures, uv);
                let colored = plain.with_base_color(at.base_color, at.metalness, *dielectric_f0);
                Bsdf::GgxReport(colored.with_alpha(at.alpha))
            }
            Kind::Layered { plain, .. } if !self.is_textured => Bsdf::Layered(*plain),
            Kind::Layered { plain, factors } => {
                let at = self.texel(factors, tint, textures, uv);
                Bsdf::Layered(plain.with_texel(tables, at.base_color, at.metalness, at.alpha))
            }
        }
    }

    #[inline]
    fn texel(
        &self,
        factors: &Factors,
        tint: Vec3,
        textures: &[Texture],
        uv: Option<Vec2>,
    ) -> Texel {
        let share = |map: Option<ChannelMap>| match (map, uv) {
            (Some(map), Some(uv)) => {
                textures[map.texture as usize].rgb(uv.x, uv.y)[usize::from(map.channel)]
            }
            _ => 1.0,
        };
        let roughness = factors.roughness * share(self.roughness);
        Texel {
            base_color: factors.base_color * tint,
            metalness: factors.metalness * share(self.metalness),
            alpha: roughness * roughness,
        }
    }
}

fn phong(m: &PhongMaterial) -> Result<Phong, crate::bsdf::BsdfError> {
    let phong = Phong::new(Vec3::from_array(m.kd), Vec3::from_array(m.ks), m.exponent)?;
    Ok(phong.with_sampling(sampling(m.sampling)))
}

fn ggx(m: &GgxMaterial, mapped: bool, tables: &Tables) -> Result<Kind, crate::bsdf::BsdfError> {
    let factors = Factors {
        base_color: Vec3::from_array(m.base_color),
        metalness: m.metalness(),
        roughness: m.roughness,
    };
    let parameters = GgxParameters {
        base_color: factors.base_color,
        metalness: factors.metalness,
        alpha: m.roughness * m.roughness,
        dielectric_f0: m.specular_f0,
    };
    if m.model == GgxModel::Report {
        let plain = GgxReport::new(&parameters)?.with_sampling(sampling(m.sampling));
        return Ok(Kind::GgxReport {
            plain,
            factors,
            dielectric_f0: m.specular_f0,
        });
    }
    if let Some(layer) = layer(m) {
        let plain = Layered::new(tables, &parameters, &layer)?;
        return Ok(Kind::Layered { plain, factors });
    }
    let plain = Ggx::new(tables, &parameters)?;
    Ok(if mapped {
        Kind::GgxMapped { plain, factors }
    } else {
        Kind::Ggx {
            plain,
            base_color: factors.base_color,
        }
    })
}

fn sampling(described: scene::LobeSampling) -> LobeSampling {
    match described {
        scene::LobeSampling::Mixture => LobeSampling::Mixture,
        scene::LobeSampling::Lobe => LobeSampling::Lobe,
    }
}

/// What a material has beyond the plain GGX, if anything.
fn layer(m: &GgxMaterial) -> Option<LayerParameters> {
    let metal = match (&m.conductor, &m.f82) {
        (Some(metal), _) => MetalLaw::Conductor {
            n: Vec3::from_array(metal.n),
            k: Vec3::from_array(metal.k),
        },
        // A tint of 1 is Schlick's curve.
        (None, Some(tint)) if *tint != [1.0; 3] => MetalLaw::F82 {
            tint: Vec3::from_array(*tint),
        },
        _ => MetalLaw::Schlick,
    };
    let coat = m.coat.filter(|coat| coat.weight > 0.0);
    let coat = coat.map(|coat| CoatParameters {
        weight: coat.weight,
        alpha: coat.roughness * coat.roughness,
        eta: coat.ior,
    });
    (metal != MetalLaw::Schlick || coat.is_some()).then_some(LayerParameters { metal, coat })
}

/// Adds the tables that a material needs.
pub(super) fn add_needs(needs: &mut TableNeeds, material: &Material) {
    if let Material::Ggx(m) = material
        && m.model == GgxModel::Corrected
    {
        match layer(m) {
            Some(layer) => needs.layers.push(layer),
            None => needs.schlick = true,
        }
    }
}
