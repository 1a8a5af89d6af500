//! Parts become tiles, tiles become films.

use super::error::{Attempt, StoreError, corrupt};
use super::errors::brightness_text;
use super::lists::{Listed, list, listed};
use super::open::Store;
use super::order::lock_job;
use super::rows::{big, int, optional_text, small, text};
use crate::metrics::Transaction as Kind;
use shearwater_shared::film::{Brightness, TileError};
use shearwater_shared::job::JobId;

/// A tile of a frame of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameTile {
    /// Job.
    pub job: JobId,
    /// Frame.
    pub frame: u32,
    /// Tile.
    pub tile: u32,
}

/// What is stored of a tile: its film so far, and parts that it lacks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TileState {
    /// Which tile.
    pub tile: u32,
    /// Counts the swaps of the film.
    pub version: i64,
    /// Blocks in the film.
    pub blocks: u32,
    /// The film's object; none when no part is folded.
    pub film: Option<String>,
    /// Parts that are not in the film.
    pub parts: Vec<FoldInput>,
}

/// A part that is not yet folded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FoldInput {
    /// First block.
    pub block0: u32,
    /// One past the last block.
    pub block1: u32,
    /// Object of the sums.
    pub object: String,
    /// Microseconds of cores spent on it.
    pub core_us: i64,
}

/// A film that takes the place of a tile's old film and some parts.
#[derive(Clone, Debug)]
pub struct FoldTask {
    /// Which tile.
    pub at: FrameTile,
    /// The state that was read.
    pub old: TileState,
    /// The new film's object, durable.
    pub film: String,
    /// The new film's error sums.
    pub error: TileError,
    /// The histogram of the new film's samples.
    pub brightness: Brightness,
    /// Samples, over all pixels, of the parts that it takes.
    pub samples: u64,
}

const TAKE_PARTS: Listed = listed!(
    "UPDATE part SET object = NULL FROM (SELECT CAST(value ->> 0 AS BIGINT) AS j, \
     CAST(value ->> 1 AS BIGINT) AS f, CAST(value ->> 2 AS BIGINT) AS t, \
     CAST(value ->> 3 AS BIGINT) AS b0, value ->> 4 AS o FROM ",
    ") v WHERE part.job = v.j AND part.frame = v.f AND part.tile = v.t AND part.block0 = v.b0 \
     AND part.object = v.o"
);

impl Store {
    /// Tiles worth folding: all blocks that are due are there, or `parts_max` parts wait.
    ///
    /// # Errors
    /// The database failed.
    pub async fn tiles_to_fold(
        &self,
        parts_max: u32,
        limit: u32,
    ) -> Result<Vec<FrameTile>, StoreError> {
        sqlx::query(
            "SELECT p.job, p.frame, p.tile FROM part p \
             JOIN tilefold t ON t.job = p.job AND t.frame = p.frame AND t.tile = p.tile \
             WHERE p.object IS NOT NULL AND p.job IN (SELECT id FROM job \
             WHERE finished_ms IS NULL) \
             GROUP BY p.job, p.frame, p.tile, t.blocks, t.due \
             HAVING count(*) >= $1 OR t.blocks + sum(p.block1 - p.block0) >= t.due \
             ORDER BY p.job, p.frame, p.tile LIMIT $2",
        )
        .bind(i64::from(parts_max))
        .bind(i64::from(limit))
        .fetch_all(&self.read)
        .await
        .attempt("find tiles to fold")?
        .iter()
        .map(|row| {
            Ok(FrameTile {
                job: JobId(int(row, "job")?),
                frame: small(row, "frame")?,
                tile: small(row, "tile")?,
            })
        })
        .collect()
    }

    /// One tile's state; `None` when there is no such tile (yet).
    ///
    /// # Errors
    /// The database failed.
    pub async fn tile_state(&self, at: &FrameTile) -> Result<Option<TileState>, StoreError> {
        let mut states = self
            .tile_states(at.job, at.frame, at.tile, at.tile + 1)
            .await?;
        Ok(states.pop())
    }

    /// The states of tiles `[tile0, tile1)` of a frame, in order; empty when
    /// the frame's rows are not made yet. Film and parts of a tile belong to
    /// one moment.
    ///
    /// # Errors
    /// The database failed.
    pub async fn tile_states(
        &self,
        job: JobId,
        frame: u32,
        tile0: u32,
        tile1: u32,
    ) -> Result<Vec<TileState>, StoreError> {
        // One statement, one snapshot: a fold between two would lose a part.
        let rows = sqlx::query(
            "SELECT t.tile, t.version, t.blocks, t.object AS film, p.block0, p.block1, \
             p.object AS part, p.core_us FROM tilefold t LEFT JOIN part p ON p.job = t.job \
             AND p.frame = t.frame AND p.tile = t.tile AND p.object IS NOT NULL \
             WHERE t.job = $1 AND t.frame = $2 AND t.tile >= $3 AND t.tile < $4 \
             ORDER BY t.tile, p.block0",
        )
        .bind(job.0)
        .bind(i64::from(frame))
        .bind(i64::from(tile0))
        .bind(i64::from(tile1))
        .fetch_all(&self.read)
        .await
        .attempt("read tiles")?;
        let mut states: Vec<TileState> = Vec::new();
        for row in &rows {
            let tile = small(row, "tile")?;
            if states.last().is_none_or(|state| state.tile != tile) {
                states.push(TileState {
                    tile,
                    version: int(row, "version")?,
                    blocks: small(row, "blocks")?,
                    film: optional_text(row, "film")?,
                    parts: Vec::new(),
                });
            }
            if let (Some(object), Some(state)) = (optional_text(row, "part")?, states.last_mut()) {
                state.parts.push(FoldInput {
                    block0: small(row, "block0")?,
                    block1: small(row, "block1")?,
                    object,
                    core_us: int(row, "core_us")?,
                });
            }
        }
        Ok(states)
    }

    /// Put the new film in the place of the old one and of its parts, if the
    /// tile is still as it was read; false when another was faster.
    ///
    /// # Errors
    /// The database failed; the tile is as before.
    pub async fn swap_film(&self, fold: &FoldTask) -> Result<bool, StoreError> {
        let _timed = self.measures.transaction(Kind::Fold);
        let mut tx = self.begin().await?;
        if !lock_job(&mut tx, fold.at.job).await? {
            return Ok(false);
        }
        let [job, frame, tile] = [fold.at.job.0, fold.at.frame.into(), i64::from(fold.at.tile)];
        let added: u32 = fold.old.parts.iter().map(|p| p.block1 - p.block0).sum();
        let error = serde_json::to_string(&fold.error).map_err(|e| corrupt("tile error", e))?;
        let swapped = sqlx::query(
            "UPDATE tilefold SET version = version + 1, blocks = blocks + $5, object = $6, \
             error = $7, brightness = $8 \
             WHERE job = $1 AND frame = $2 AND tile = $3 AND version = $4",
        )
        .bind(job)
        .bind(frame)
        .bind(tile)
        .bind(fold.old.version)
        .bind(i64::from(added))
        .bind(&fold.film)
        .bind(error)
        .bind(brightness_text(&fold.brightness)?)
        .execute(&mut *tx)
        .await
        .attempt("swap film")?;
        if swapped.rows_affected() != 1 {
            return Ok(false);
        }
        let parts: Vec<_> = fold
            .old
            .parts
            .iter()
            .map(|part| (job, frame, tile, part.block0, &part.object))
            .collect();
        let taken = sqlx::query(TAKE_PARTS.of(self.engine))
            .bind(list(&parts)?)
            .execute(&mut *tx)
            .await
            .attempt("take parts")?;
        if taken.rows_affected() != parts.len() as u64 {
            return Ok(false);
        }
        let core_us = fold.old.parts.iter().map(|part| part.core_us).sum::<i64>();
        sqlx::query(
            "UPDATE frame SET samples_folded = samples_folded + $3, \
             core_us_folded = core_us_folded + $4 WHERE job = $1 AND frame = $2",
        )
        .bind(job)
        .bind(frame)
        .bind(big(fold.samples))
        .bind(core_us)
        .execute(&mut *tx)
        .await
        .attempt("add to frame")?;
        tx.commit().await.attempt("commit fold")?;
        Ok(true)
    }

    /// Error sums of the folded tiles of a frame, in tile order.
    ///
    /// # Errors
    /// The database failed.
    pub async fn tile_errors(
        &self,
        job: JobId,
        frame: u32,
    ) -> Result<Vec<(u32, TileError)>, StoreError> {
        sqlx::query(
            "SELECT tile, error FROM tilefold WHERE job = $1 AND frame = $2 \
             AND error IS NOT NULL ORDER BY tile",
        )
        .bind(job.0)
        .bind(i64::from(frame))
        .fetch_all(&self.read)
        .await
        .attempt("read tile errors")?
        .iter()
        .map(|row| {
            let error = serde_json::from_str(&text(row, "error")?);
            Ok((
                small(row, "tile")?,
                error.map_err(|e| corrupt("tile error", e))?,
            ))
        })
        .collect()
    }

    /// Frames of which every unit that is due is counted, folded and audited and whose
    /// film hash is not yet stored: they end, or go on to the next pass.
    ///
    /// # Errors
    /// The database failed.
    pub async fn frames_to_finish(&self, limit: u32) -> Result<Vec<(JobId, u32)>, StoreError> {
        sqlx::query(
            "SELECT f.job, f.frame FROM frame f JOIN job j ON j.id = f.job \
             WHERE f.film_hash IS NULL AND j.finished_ms IS NULL \
             AND f.units_done >= f.units_due AND NOT EXISTS (SELECT 1 FROM part p \
             WHERE p.job = f.job AND p.frame = f.frame AND p.object IS NOT NULL) \
             AND NOT EXISTS (SELECT 1 FROM audit a WHERE a.job = f.job AND a.frame = f.frame) \
             AND NOT EXISTS (SELECT 1 FROM distrust d JOIN part p ON p.worker = d.worker \
             WHERE p.job = f.job AND p.frame = f.frame) ORDER BY f.job, f.frame LIMIT $1",
        )
        .bind(i64::from(limit))
        .fetch_all(&self.read)
        .await
        .attempt("find frames to finish")?
        .iter()
        .map(|row| Ok((JobId(int(row, "job")?), small(row, "frame")?)))
        .collect()
    }
}
