//! Fixed-step marching, as the textbooks for games have it: biased, kept to be
//! compared with tracking.
//!
//! The density is read once in each step, at one jittered place that all steps of a
//! ray share. The optical depth is then right on average, but exp(-depth) is convex:
//! by Jensen's inequality too much light passes, by about half the depth's variance.

use super::Flight;
use super::draws::Draws;
use super::volume::Volume;
use super::walk::Span;
use crate::math::elementary::{exp, ln};

/// Where the ray is scattered or absorbed, by inverting the marched optical depth.
#[inline]
pub(super) fn collide(volume: &Volume, span: &Span, step_m: f32, draws: &mut Draws) -> Flight {
    let Some((u, jitter)) = draws.pair() else {
        return Flight::GaveUp;
    };
    let mut left = -ln(1.0 - u);
    for step in steps(span, step_m) {
        let sigma_t = volume.sigma_t(span.at(step.start + jitter * step.length));
        let through = sigma_t * step.length;
        if left < through {
            return Flight::Collided((step.start + left / sigma_t).min(span.t1));
        }
        left -= through;
    }
    Flight::Passed
}

/// A biased estimate of the share of light that passes.
#[inline]
pub(super) fn transmittance(
    volume: &Volume,
    span: &Span,
    step_m: f32,
    draws: &mut Draws,
) -> Option<f32> {
    let (jitter, _) = draws.pair()?;
    let mut depth = 0.0f32;
    for step in steps(span, step_m) {
        depth += volume.sigma_t(span.at(step.start + jitter * step.length)) * step.length;
    }
    Some(exp(-depth))
}

struct Step {
    start: f32,
    length: f32,
}

// As many as the scene's limit on steps allows, by the volume's size. The last one
// ends with the span.
#[inline]
fn steps(span: &Span, step_m: f32) -> impl Iterator<Item = Step> + use<> {
    let (t0, t1) = (span.t0, span.t1);
    let count = ((t1 - t0) / step_m) as u32;
    (0..=count).map(move |i| {
        let start = t0 + i as f32 * step_m;
        Step {
            start,
            length: (t1 - start).clamp(0.0, step_m),
        }
    })
}
