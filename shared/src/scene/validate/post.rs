//! Ranges of what is done to the picture.

use super::super::at::At;
use super::super::range::{RADIANCE, Range, SHARE, count, number};
use super::super::{Post, SceneError};
use crate::limits;

pub(super) fn post(at: &At<'_>, post: &Post) -> Result<(), SceneError> {
    let exposure = Range::Closed(-32.0, 32.0);
    number(
        &at.field("exposure_ev"),
        post.exposure_ev,
        exposure,
        "stops",
    )?;
    let Some(bloom) = &post.bloom else {
        return Ok(());
    };
    let at = at.field("bloom");
    number(&at.field("threshold"), bloom.threshold, RADIANCE, "")?;
    let strength = Range::Closed(0.0, limits::BLOOM_STRENGTH_MAX.into());
    number(&at.field("strength"), bloom.strength, strength, "")?;
    let radius = "of the picture's height";
    number(&at.field("radius"), bloom.radius, SHARE, radius)?;
    count(
        &at.field("passes"),
        bloom.passes.into(),
        1,
        limits::BLOOM_PASSES_MAX.into(),
    )
}
