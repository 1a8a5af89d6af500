//! Between two passes of a frame: which of its tiles go on, or why it ends.

use super::error::FoldError;
use crate::app::{App, now_ms};
use crate::farm::{TileAtLevel, Verdict, verdict};
use crate::store::{JobRow, NextPass};
use shearwater_shared::api::StopCause;
use shearwater_shared::plan::Run;

/// What follows for a frame of which every unit that is due is counted and folded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    /// Its film is final, for this reason.
    End(StopCause),
    /// Another pass was begun.
    Pass,
    /// Another was faster, or it changed.
    Nothing,
}

/// Decide about a frame. The decision about error is a function of what is counted
/// and of the settings; only the time stop asks the clock.
pub(super) async fn next(app: &App, job: &JobRow, frame: u32) -> Result<Next, FoldError> {
    let plan = job.plan();
    let Some(state) = app.store.pass_state(job.id, frame).await? else {
        return Ok(Next::Nothing);
    };
    if state.withheld > 0 {
        return Ok(Next::End(StopCause::Seconds));
    }
    let Some(target) = job.settings.stop.error else {
        return Ok(Next::End(StopCause::Samples));
    };
    let runs: Vec<Option<Run>> = (0..)
        .zip(&state.tiles)
        .map(|(tile, &(blocks, _))| {
            let block1 = plan.next_level(blocks)?;
            Some(Run {
                frame,
                tile,
                block0: blocks,
                block1,
            })
        })
        .collect();
    let tiles: Vec<TileAtLevel> = (0..)
        .zip(state.tiles.iter().zip(&runs))
        .map(|(tile, (&(blocks, error), run))| TileAtLevel {
            samples: 2 * plan.samples_of_blocks(blocks),
            can_go_on: run.is_some(),
            pixels: plan
                .tile_rect(tile)
                .map_or(0, |rect| rect.width * rect.height),
            relmse: error.relmse(),
        })
        .collect();
    let go_on = match verdict(&tiles, plan.tiles_x(), target) {
        Verdict::Reached => return Ok(Next::End(StopCause::Error)),
        Verdict::Exhausted => return Ok(Next::End(StopCause::Samples)),
        Verdict::GoOn(tiles) => tiles,
    };
    if job.out_of_time(now_ms()).is_some_and(|over| frame < over) {
        return Ok(Next::End(StopCause::Seconds));
    }
    let next = NextPass {
        job: job.id,
        frame,
        pass: state.pass,
        extended: job.extended,
        runs: go_on
            .iter()
            .filter_map(|&tile| *runs.get(tile as usize)?)
            .collect(),
    };
    if !app.store.next_pass(&next, &plan).await? {
        return Ok(Next::Nothing);
    }
    let (job, frame) = (job.id, job.settings.absolute_frame(frame));
    tracing::info!(
        job = job.0,
        frame,
        pass = next.pass + 1,
        tiles = next.runs.len(),
        "tiles go on"
    );
    app.work_came();
    Ok(Next::Pass)
}
