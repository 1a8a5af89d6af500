//! The albedo tables of a scene.
//!
//! E(mu, alpha) is the share of light at cosine mu that a GGX interface
//! reflects. Under Schlick's Fresnel it is linear in F0, E = A F0 + B, so one
//! table of (A, B) serves all materials; exact Fresnel needs one per index.

use super::BsdfError;
use super::albedo::{AlbedoGrid, AlphaRow};
use super::error::check_range;
use super::fresnel::{dielectric, schlick_weight};

/// Refraction indices kept at once: a table is 8 KiB and costs about 20 ms to
/// fill, and a scene has one kind of water.
pub const DIELECTRICS_MAX: usize = 4;
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
}

/// The tables of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tables {
    /// (A, B) of Schlick's law.
    schlick: Option<AlbedoGrid<2>>,
    dielectrics: Vec<(f32, AlbedoGrid<1>)>,
}

impl Tables {
    /// Fills what `needs` names, in a few tens of milliseconds.
    ///
    /// # Errors
    /// [`BsdfError`] if an index is out of range or there are more than
    /// [`DIELECTRICS_MAX`].
    pub fn build(needs: &TableNeeds) -> Result<Self, BsdfError> {
        let mut etas: Vec<f32> = Vec::new();
        for &eta in &needs.etas {
            check_range("eta", eta, 1.0, ETA_MAX)?;
            if !etas.contains(&eta) {
                etas.push(eta);
            }
        }
        if etas.len() > DIELECTRICS_MAX {
            return Err(BsdfError::TooManyIndices {
                count: etas.len(),
                limit: DIELECTRICS_MAX,
            });
        }
        let schlick = needs.schlick.then(|| {
            AlbedoGrid::fill(|cos| {
                let bias = schlick_weight(cos);
                [1.0 - bias, bias]
            })
        });
        let dielectrics = etas
            .into_iter()
            .map(|eta| (eta, AlbedoGrid::fill(|cos| [dielectric(eta, cos)])))
            .collect();
        Ok(Self {
            schlick,
            dielectrics,
        })
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
}
