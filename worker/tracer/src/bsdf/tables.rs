//! The albedo tables of a scene.
//!
//! E(mu, alpha) is the share of light at cosine mu that a GGX interface
//! reflects. Under Schlick's Fresnel it is linear in F0, E = A F0 + B, so one
//! table of (A, B) serves all materials, and one of the dip of an edge tint all
//! metals that have one; exact Fresnel needs a table per index.

use super::BsdfError;
use super::albedo::{AlbedoGrid, AlphaRow};
use super::error::check_range;
use super::fresnel::{dielectric, f82_dip, schlick_weight};
use super::layer::{LAYERS_MAX, Layer, LayerParameters, MetalLaw, conductor_rgb};
use glam::Vec3;

/// Refraction indices kept at once: a table is 8 KiB and costs about 20 ms to
/// fill, and a scene has one kind of water.
pub const DIELECTRICS_MAX: usize = 4;
/// Metals of a complex index kept at once: a table is 24 KiB and costs about
/// 100 ms of one core to fill.
pub const CONDUCTORS_MAX: usize = 8;
/// Largest index of refraction; diamond has 2.42.
const ETA_MAX: f32 = 10.0;

/// Which tables a scene needs; absent ones cost nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TableNeeds {
    /// Some material is [`super::Ggx`].
    pub schlick: bool,
    /// The indices of the [`super::Water`] surfaces, each in [1, 10]; repeats
    /// are ignored.
    pub etas: Vec<f32>,
    /// The [`super::Layered`] materials; repeats are ignored. What they need
    /// besides need not be named.
    pub layers: Vec<LayerParameters>,
}

/// The tables of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tables {
    /// (A, B) of Schlick's law.
    schlick: Option<AlbedoGrid<2>>,
    dielectrics: Vec<(f32, AlbedoGrid<1>)>,
    /// The dip of F82.
    dip: Option<AlbedoGrid<1>>,
    conductors: Vec<(MetalLaw, AlbedoGrid<3>)>,
    layers: Vec<Layer>,
}

impl Tables {
    /// Fills what `needs` names, in a few tens of milliseconds.
    ///
    /// # Errors
    /// [`BsdfError`] if an index is out of range or there are more than
    /// [`DIELECTRICS_MAX`], [`CONDUCTORS_MAX`] or [`LAYERS_MAX`].
    pub fn build(needs: &TableNeeds) -> Result<Self, BsdfError> {
        let layers = distinct(needs.layers.iter().copied());
        limit("layered materials", layers.len(), LAYERS_MAX)?;
        let coats = layers.iter().filter_map(|layer| layer.coat);
        let etas = distinct(needs.etas.iter().copied().chain(coats.map(|coat| coat.eta)));
        for &eta in &etas {
            check_range("eta", eta, 1.0, ETA_MAX)?;
        }
        limit("refraction indices", etas.len(), DIELECTRICS_MAX)?;
        let metals = distinct(layers.iter().map(|layer| layer.metal));
        let conductors: Vec<_> = metals
            .iter()
            .filter_map(|metal| match *metal {
                MetalLaw::Conductor { n, k } => Some((*metal, n, k)),
                _ => None,
            })
            .collect();
        limit("conductors", conductors.len(), CONDUCTORS_MAX)?;
        let mut tables = Self {
            schlick: (needs.schlick || !layers.is_empty()).then(fill_schlick),
            dip: metals
                .iter()
                .any(|metal| matches!(metal, MetalLaw::F82 { .. }))
                .then(|| AlbedoGrid::fill(|cos| [f82_dip(cos)])),
            dielectrics: etas
                .into_iter()
                .map(|eta| (eta, AlbedoGrid::fill(|cos| [dielectric(eta, cos)])))
                .collect(),
            conductors: Vec::new(),
            layers: Vec::new(),
        };
        for layer in &layers {
            let number = conductors.iter().position(|c| c.0 == layer.metal);
            let number = number.unwrap_or(0) as u16;
            let checked = Layer::new(layer, number, |eta| tables.dielectric_index(eta))?;
            tables.layers.push(checked);
        }
        tables.conductors = conductors
            .into_iter()
            .map(|(metal, n, k)| {
                let law = |cos| conductor_rgb(n, k, cos).to_array();
                (metal, AlbedoGrid::fill(law))
            })
            .collect();
        Ok(tables)
    }

    /// An error unless Schlick's table is there.
    pub(super) fn require_schlick(&self) -> Result<(), BsdfError> {
        match self.schlick {
            Some(_) => Ok(()),
            None => Err(BsdfError::MissingTable {
                what: "GGX with Schlick's Fresnel",
            }),
        }
    }

    /// The table of this index.
    pub(super) fn dielectric_index(&self, eta: f32) -> Result<u16, BsdfError> {
        self.dielectrics
            .iter()
            .position(|(known, _)| *known == eta)
            .map(|index| index as u16)
            .ok_or(BsdfError::MissingTable {
                what: "this refraction index",
            })
    }

    /// (A, B) at a cosine.
    #[inline]
    pub(super) fn schlick_albedo(&self, row: AlphaRow, mu: f32) -> [f32; 2] {
        self.schlick
            .as_ref()
            .map_or([0.0; 2], |grid| grid.at(row, mu))
    }

    /// (A, B) of the cosine-weighted mean.
    #[inline]
    pub(super) fn schlick_average(&self, row: AlphaRow) -> [f32; 2] {
        self.schlick
            .as_ref()
            .map_or([0.0; 2], |grid| grid.average(row))
    }

    /// E of one dielectric at a cosine.
    #[inline]
    pub(super) fn dielectric_albedo(&self, table: u16, row: AlphaRow, mu: f32) -> f32 {
        self.dielectrics
            .get(usize::from(table))
            .map_or(0.0, |(_, grid)| grid.at(row, mu)[0])
    }

    /// Its cosine-weighted mean.
    #[inline]
    pub(super) fn dielectric_average(&self, table: u16, row: AlphaRow) -> f32 {
        self.dielectrics
            .get(usize::from(table))
            .map_or(0.0, |(_, grid)| grid.average(row)[0])
    }

    /// The number of a layered material.
    pub(super) fn layer_number(&self, parameters: &LayerParameters) -> Result<u16, BsdfError> {
        self.layers
            .iter()
            .position(|layer| layer.parameters == *parameters)
            .map(|index| index as u16)
            .ok_or(BsdfError::MissingTable {
                what: "this layered material",
            })
    }

    /// A layered material by its number.
    #[inline]
    pub(super) fn layer(&self, number: u16) -> Option<&Layer> {
        self.layers.get(usize::from(number))
    }

    /// The albedo of F82's dip at a cosine.
    #[inline]
    pub(super) fn dip_albedo(&self, row: AlphaRow, mu: f32) -> f32 {
        self.dip.as_ref().map_or(0.0, |grid| grid.at(row, mu)[0])
    }

    /// Its cosine-weighted mean.
    #[inline]
    pub(super) fn dip_average(&self, row: AlphaRow) -> f32 {
        self.dip.as_ref().map_or(0.0, |grid| grid.average(row)[0])
    }

    /// E of one conductor at a cosine.
    #[inline]
    pub(super) fn conductor_albedo(&self, table: u16, row: AlphaRow, mu: f32) -> Vec3 {
        let grid = self.conductors.get(usize::from(table));
        grid.map_or(Vec3::ZERO, |(_, grid)| Vec3::from_array(grid.at(row, mu)))
    }

    /// Its cosine-weighted mean.
    #[inline]
    pub(super) fn conductor_average(&self, table: u16, row: AlphaRow) -> Vec3 {
        let grid = self.conductors.get(usize::from(table));
        grid.map_or(Vec3::ZERO, |(_, grid)| Vec3::from_array(grid.average(row)))
    }
}

/// (A, B) under Schlick's law.
fn fill_schlick() -> AlbedoGrid<2> {
    AlbedoGrid::fill(|cos| {
        let bias = schlick_weight(cos);
        [1.0 - bias, bias]
    })
}

/// Each once, in the order of their first appearance; one more than any limit at
/// most, so that whoever counts them notices and the search stays short.
fn distinct<T: PartialEq>(all: impl Iterator<Item = T>) -> Vec<T> {
    let mut once: Vec<T> = Vec::new();
    for one in all {
        if once.len() <= LAYERS_MAX && !once.contains(&one) {
            once.push(one);
        }
    }
    once
}

fn limit(what: &'static str, count: usize, limit: usize) -> Result<(), BsdfError> {
    if count <= limit {
        Ok(())
    } else {
        Err(BsdfError::TooMany { what, count, limit })
    }
}
