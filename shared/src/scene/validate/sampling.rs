//! Ranges of how light is sampled.

use super::super::at::At;
use super::super::range::{Range, SHARE, count, number};
use super::super::{Sampling, SceneError};
use crate::limits;

pub(super) fn sampling(at: &At<'_>, sampling: &Sampling) -> Result<(), SceneError> {
    count(
        &at.field("sobol_scatterings"),
        sampling.sobol_scatterings.into(),
        0,
        limits::SOBOL_SCATTERINGS_MAX.into(),
    )?;
    number(&at.field("faint_share"), sampling.faint_share, SHARE, "")?;
    let at = at.field("roulette");
    count(
        &at.field("from"),
        sampling.roulette.from.into(),
        0,
        limits::ROULETTE_FROM_MAX.into(),
    )?;
    let survival = Range::Closed(limits::SURVIVAL_MIN_MIN, limits::SURVIVAL_MIN_MAX);
    number(
        &at.field("survival_min"),
        sampling.roulette.survival_min,
        survival,
        "",
    )
}
