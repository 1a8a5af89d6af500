//! One sweep by hand, beside running coordinators or without any.

use crate::app::{now_ms, open_objects, open_store};
use crate::config::{Config, StartError};
use crate::sweep::{Grace, SweepError, Swept, sweep};

/// Why a sweep by hand did not end.
#[derive(Debug, thiserror::Error)]
pub enum GcError {
    /// The stores cannot be opened.
    #[error(transparent)]
    Start(#[from] StartError),
    /// It was cut off.
    #[error(transparent)]
    Sweep(#[from] SweepError),
}

/// What a sweep by hand found.
#[derive(Clone, Debug)]
pub struct GcReport {
    /// What it removed.
    pub swept: Swept,
    /// Rows that are left, by table.
    pub rows: Vec<(&'static str, u64)>,
}

/// Remove what nobody needs any more from the stores that `config` names.
///
/// # Errors
/// See [`GcError`]; what was removed is gone, the rest is as before.
pub async fn gc(config: &Config, grace: Grace) -> Result<GcReport, GcError> {
    let objects = open_objects(config)?;
    let store = open_store(config).await?;
    let swept = sweep(&store, &objects, grace, now_ms()).await;
    let rows = store.row_counts().await;
    store.close().await;
    Ok(GcReport {
        swept: swept?,
        rows: rows.map_err(SweepError::from)?,
    })
}
