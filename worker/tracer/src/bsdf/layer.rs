//! What a scene says of a layered metal, apart from what changes from texel to
//! texel. Too big for a hit; the [`super::Tables`] keep it by number.

use glam::Vec3;

use super::albedo::AlphaRow;
use super::error::{check_color, check_range};
use super::fresnel::{conductor, conductor_f0, dielectric, schlick};
use super::interface::mirror_or;
use super::{BsdfError, Tables};

/// Layered materials of one scene that differ in more than their colours: the
/// search for equal ones stays short.
pub const LAYERS_MAX: usize = 1024;
/// Largest n and k; metals stay below 10 in visible light.
const INDEX_MAX: f32 = 20.0;

/// What a metal reflects at each angle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum MetalLaw {
    /// Schlick's curve from the base colour.
    #[default]
    Schlick,
    /// Schlick's curve with an edge tint ([`super::fresnel::f82_depth`]).
    F82 {
        /// Reflectance at 82 degrees over Schlick's, per channel in [0, 1].
        tint: Vec3,
    },
    /// Exact, from the complex index n + ik; the base colour tints it.
    Conductor {
        /// n per channel, in [0, 20].
        n: Vec3,
        /// k per channel, in [0, 20].
        k: Vec3,
    },
}

/// A clear coat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoatParameters {
    /// Share of the surface that is coated, in [0, 1].
    pub weight: f32,
    /// GGX roughness alpha, in [0, 1]; 0 is a mirror.
    pub alpha: f32,
    /// Index of refraction, in [1, 10].
    pub eta: f32,
}

/// A layered material without its colours and roughness.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LayerParameters {
    /// The metal.
    pub metal: MetalLaw,
    /// What lies above it.
    pub coat: Option<CoatParameters>,
}

/// [`LayerParameters`], checked, with the places of its tables.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layer {
    pub(super) parameters: LayerParameters,
    pub(super) metal: MetalLaw,
    /// The albedo table of a [`MetalLaw::Conductor`].
    pub(super) conductor: u16,
    /// Reflectance of a [`MetalLaw::Conductor`] at normal incidence.
    pub(super) conductor_f0: Vec3,
    pub(super) coat: Option<Coat>,
}

/// A coat, ready to be evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coat {
    pub(super) weight: f32,
    pub(super) alpha: f32,
    pub(super) eta: f32,
    row: AlphaRow,
    table: u16,
}

impl Coat {
    /// What it reflects at a microfacet, its weight included.
    #[inline]
    pub(super) fn fresnel(&self, cos_half: f32) -> f32 {
        self.weight * dielectric(self.eta, cos_half)
    }

    /// What it reflects of the light at cosine `cos`, its weight included.
    #[inline]
    pub(super) fn reflected(&self, tables: &Tables, cos: f32) -> f32 {
        if self.alpha == 0.0 {
            return self.fresnel(cos);
        }
        self.weight * tables.dielectric_albedo(self.table, self.row, cos)
    }
}

impl Layer {
    /// Refuses what is out of range. `conductor` is the number of the albedo
    /// table of the metal, `dielectric` finds that of an index.
    pub(super) fn new(
        parameters: &LayerParameters,
        conductor: u16,
        dielectric: impl Fn(f32) -> Result<u16, BsdfError>,
    ) -> Result<Self, BsdfError> {
        let mut f0 = Vec3::ZERO;
        match parameters.metal {
            MetalLaw::Schlick => {}
            MetalLaw::F82 { tint } => {
                check_color("f82", tint)?;
            }
            MetalLaw::Conductor { n, k } => {
                for part in n.to_array().into_iter().chain(k.to_array()) {
                    check_range("conductor", part, 0.0, INDEX_MAX)?;
                }
                f0 = per_channel(n, k, conductor_f0);
            }
        }
        let coat = |coat: CoatParameters| {
            let alpha = mirror_or(check_range("coat.alpha", coat.alpha, 0.0, 1.0)?);
            Ok(Coat {
                weight: check_range("coat.weight", coat.weight, 0.0, 1.0)?,
                alpha,
                eta: coat.eta,
                row: AlphaRow::new(alpha),
                table: dielectric(coat.eta)?,
            })
        };
        Ok(Self {
            parameters: *parameters,
            metal: parameters.metal,
            conductor,
            conductor_f0: f0,
            coat: parameters.coat.map(coat).transpose()?,
        })
    }

    /// Reflectance of the metal at normal incidence where it is tinted so.
    #[inline]
    pub(super) fn metal_f0(&self, base_color: Vec3) -> Vec3 {
        match self.metal {
            MetalLaw::Conductor { .. } => base_color * self.conductor_f0,
            _ => base_color,
        }
    }
}

/// Exact reflectance of a metal at cosine `cos`.
#[inline]
pub(super) fn conductor_rgb(n: Vec3, k: Vec3, cos: f32) -> Vec3 {
    per_channel(n, k, |n, k| conductor(n, k, cos))
}

#[inline]
fn per_channel(n: Vec3, k: Vec3, f: impl Fn(f32, f32) -> f32) -> Vec3 {
    Vec3::new(f(n.x, k.x), f(n.y, k.y), f(n.z, k.z))
}

/// The curve of a mixture of a dielectric and a metal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Mixed {
    /// Schlick's from F0, less `depth` times the dip of F82.
    Schlick { f0: Vec3, depth: Vec3 },
    /// Schlick's from the dielectric's share, and the tinted metal's.
    Conductor {
        dielectric_f0: f32,
        metalness: f32,
        tint: Vec3,
        n: Vec3,
        k: Vec3,
    },
}

impl Mixed {
    /// Reflectance at a microfacet.
    #[inline]
    pub(super) fn fresnel(&self, cos: f32) -> Vec3 {
        match *self {
            Self::Schlick { f0, depth } => {
                (schlick(f0, cos) - depth * super::fresnel::f82_dip(cos)).max(Vec3::ZERO)
            }
            Self::Conductor {
                dielectric_f0,
                metalness,
                tint,
                n,
                k,
            } => {
                let metal = tint * conductor_rgb(n, k, cos) * metalness;
                if metalness >= 1.0 {
                    return metal;
                }
                metal + schlick(Vec3::splat(dielectric_f0), cos) * (1.0 - metalness)
            }
        }
    }
}
