//! What can go wrong when sums are put together.

use crate::app::CutOff;
use crate::objects::ObjectError;
use crate::store::StoreError;
use shearwater_shared::film::FilmError;
use shearwater_shared::wire::WireError;

/// Sums could not be put together.
#[derive(Debug, thiserror::Error)]
pub enum FoldError {
    /// The database.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The objects.
    #[error(transparent)]
    Objects(#[from] ObjectError),
    /// The computation.
    #[error(transparent)]
    CutOff(#[from] CutOff),
    /// An object that a row names is gone.
    #[error("stored object `{0}` is lost")]
    Lost(String),
    /// An object is damaged.
    #[error("stored object `{name}` is damaged: {source}")]
    Damaged {
        /// Which object.
        name: String,
        /// How.
        source: WireError,
    },
    /// Sums do not fit together.
    #[error("stored sums of tile {tile} do not fit: {source}")]
    Film {
        /// Which tile.
        tile: u32,
        /// How.
        source: FilmError,
    },
}

impl FoldError {
    /// Trying again would not help.
    #[must_use]
    pub const fn is_permanent(&self) -> bool {
        matches!(
            self,
            Self::Lost(_) | Self::Damaged { .. } | Self::Film { .. }
        )
    }
}
