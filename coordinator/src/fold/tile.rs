//! One tile: read its film and parts, join them, put the new film in place.

use super::error::FoldError;
use crate::app::App;
use crate::objects::ObjectError;
use crate::store::{FoldInput, FoldTask, FrameTile, TileState};
use axum::body::Bytes;
use shearwater_shared::film::{TileFilm, tile_error};
use shearwater_shared::plan::{Plan, Run};
use shearwater_shared::wire;

/// How often a tile is read again when an object vanished under the reader:
/// each time means that another has folded it meanwhile.
const STALE_READS_MAX: u32 = 8;

/// Fold the parts of a tile into its film; false when there was nothing to do
/// or another was faster.
pub(super) async fn fold(app: &App, at: &FrameTile) -> Result<bool, FoldError> {
    let Some(job) = app.store.job(at.job).await? else {
        return Ok(false);
    };
    let Some((film, old)) = read(app, &job.plan(), at).await? else {
        return Ok(false);
    };
    if old.parts.is_empty() {
        return Ok(false);
    }
    let tile = at.tile;
    let plan = job.plan();
    let width = plan.tile_rect(tile).map_or(0, |rect| rect.width as usize);
    let (bytes, error, brightness) = app
        .compute(move || {
            let error = tile_error(&film, width);
            (wire::encode_film(&film), error, film.brightness)
        })
        .await?;
    let name = app.objects.film_name(at.job, at.frame, at.tile);
    let bytes = bytes.map_err(|source| FoldError::Damaged {
        name: format!("film of tile {tile}"),
        source,
    })?;
    app.objects.put(&name, bytes).await?;
    let run = |part: &FoldInput| Run {
        frame: at.frame,
        tile,
        block0: part.block0,
        block1: part.block1,
    };
    let samples = old.parts.iter().map(|part| plan.run_samples(&run(part)));
    let task = FoldTask {
        at: *at,
        samples: samples.sum(),
        old,
        film: name,
        error,
        brightness,
    };
    let swapped = app.store.swap_film(&task).await?;
    // Whoever lost has only its own film to remove. Nobody reads what no row
    // names, except readers of a moment ago, who read again.
    let unneeded: Vec<&String> = if swapped {
        let parts = task.old.parts.iter().map(|part| &part.object);
        task.old.film.iter().chain(parts).collect()
    } else {
        vec![&task.film]
    };
    for name in unneeded {
        if let Err(error) = app.objects.delete(name).await {
            tracing::warn!(%error, "object stays until the sweep");
        }
    }
    Ok(swapped)
}

/// The sums of a tile at this moment, and the state they belong to; `None` when
/// the frame's rows are not made yet.
pub(super) async fn read(
    app: &App,
    plan: &Plan,
    at: &FrameTile,
) -> Result<Option<(TileFilm, TileState)>, FoldError> {
    let pixels = plan.tile_rect(at.tile).map_or(0, |rect| rect.pixels());
    let mut missing = String::new();
    for _ in 0..STALE_READS_MAX {
        let Some(state) = app.store.tile_state(at).await? else {
            return Ok(None);
        };
        match load(app, &state).await {
            Ok(loaded) => {
                let film = app.compute(move || join(loaded, pixels)).await??;
                return Ok(Some((film, state)));
            }
            // The same object missing twice under the same row is lost.
            Err(error) if error.is_missing() && error.name == missing => break,
            Err(error) if error.is_missing() => missing = error.name,
            Err(error) => return Err(error.into()),
        }
    }
    Err(FoldError::Lost(missing))
}

/// The bytes of a tile's objects.
struct Loaded {
    tile: u32,
    film: Option<(String, Bytes)>,
    parts: Vec<(String, Bytes)>,
}

async fn load(app: &App, state: &TileState) -> Result<Loaded, ObjectError> {
    let film = match &state.film {
        Some(name) => Some((name.clone(), app.objects.get(name).await?)),
        None => None,
    };
    let mut parts = Vec::with_capacity(state.parts.len());
    for part in &state.parts {
        parts.push((part.object.clone(), app.objects.get(&part.object).await?));
    }
    Ok(Loaded {
        tile: state.tile,
        film,
        parts,
    })
}

fn join(loaded: Loaded, pixels: usize) -> Result<TileFilm, FoldError> {
    let tile = loaded.tile;
    let unfit = |source| FoldError::Film { tile, source };
    let mut film = match loaded.film {
        Some((name, bytes)) => {
            wire::decode_film(&bytes).map_err(|source| FoldError::Damaged { name, source })?
        }
        None => TileFilm::zero(pixels),
    };
    // The bytes are those that were written; the numbers may still be anything.
    film.check(pixels).map_err(unfit)?;
    for (name, bytes) in loaded.parts {
        let sums =
            wire::decode_sums(&bytes).map_err(|source| FoldError::Damaged { name, source })?;
        film.add(&sums).map_err(unfit)?;
    }
    Ok(film)
}

#[cfg(test)]
mod tests {
    use super::*;

    // Found by fuzzing: such films were read with an index out of bounds, or summed
    // beyond 128 bits.
    #[test]
    fn a_stored_film_that_cannot_be_is_an_error() {
        let joined = |film: &TileFilm| {
            let bytes = wire::encode_film(film).expect("message");
            let film = Some(("film".to_owned(), Bytes::from(bytes)));
            let parts = Vec::new();
            join(
                Loaded {
                    tile: 0,
                    film,
                    parts,
                },
                4,
            )
        };
        assert!(joined(&TileFilm::zero(4)).is_ok());
        for spoil in [
            |film: &mut TileFilm| film.radiance[1].truncate(3),
            |film: &mut TileFilm| film.radiance[0].push(0),
            |film: &mut TileFilm| film.features.truncate(1),
            |film: &mut TileFilm| film.radiance[0][2] = i128::MAX,
            |film: &mut TileFilm| film.samples_per_half = u64::MAX,
        ] {
            let mut film = TileFilm::zero(4);
            spoil(&mut film);
            assert!(
                matches!(joined(&film), Err(FoldError::Film { tile: 0, .. })),
                "{film:?}"
            );
        }
    }
}
