//! Unbiased flights through a volume.
//!
//! Both methods walk the cells with their exact bounds. Between two possible
//! collisions the bounds' optical depth is used up cell by cell, so empty cells cost
//! a step of the walk and nothing else.

use super::Flight;
use super::draws::Draws;
use super::volume::Volume;
use super::walk::{Span, Walk};
use crate::math::elementary::{exp, ln};

/// Below this transmittance a ratio-tracked ray goes on with the chance
/// [`SURVIVAL`] only, for what is left of it no longer pays the way.
const FAINT: f32 = 0.1;
const SURVIVAL: f32 = 0.5;

/// Where the ray is scattered or absorbed: delta tracking (Woodcock et al. 1965)
/// under the largest density of each cell. A tentative collision below the cell's
/// smallest density is real without looking (Kutz et al. 2017, "Spectral and
/// decomposition tracking").
#[inline]
pub(super) fn collide(volume: &Volume, span: &Span, draws: &mut Draws) -> Flight {
    let Some((mut depth, mut choice)) = next_collision(draws) else {
        return Flight::GaveUp;
    };
    let mut t = span.t0;
    for piece in Walk::new(&volume.density, span) {
        let most = volume.sigma_t_per_m * piece.bounds.max;
        loop {
            let through = most * (piece.end - t);
            if depth >= through {
                depth -= through;
                t = piece.end;
                break;
            }
            // Never stands still: far away a free path may be less than a digit of t.
            t = (t + depth / most).max(t.next_up());
            let least = volume.sigma_t_per_m * piece.bounds.min;
            if choice * most < least || choice * most < volume.sigma_t(span.at(t)) {
                return Flight::Collided(t.min(span.t1));
            }
            match next_collision(draws) {
                Some(next) => (depth, choice) = next,
                None => return Flight::GaveUp,
            }
        }
    }
    Flight::Passed
}

/// An unbiased estimate of the share of light that passes: residual ratio tracking
/// (Novak, Selle and Jarosz 2014). The smallest density of each cell is integrated
/// exactly, only the rest by chance, so an even volume has no noise at all.
#[inline]
pub(super) fn transmittance(volume: &Volume, span: &Span, draws: &mut Draws) -> Option<f32> {
    let (mut left, mut choice) = next_collision(draws)?;
    let (mut t, mut exact_depth, mut ratio) = (span.t0, 0.0f32, 1.0f32);
    for piece in Walk::new(&volume.density, span) {
        let least = volume.sigma_t_per_m * piece.bounds.min;
        let rest = volume.sigma_t_per_m * piece.bounds.max - least;
        exact_depth += least * (piece.end - t);
        loop {
            let through = rest * (piece.end - t);
            if left >= through {
                left -= through;
                t = piece.end;
                break;
            }
            t = (t + left / rest).max(t.next_up());
            let above = volume.sigma_t(span.at(t)) - least;
            ratio *= (1.0 - above / rest).clamp(0.0, 1.0);
            if ratio < FAINT {
                if choice >= SURVIVAL || ratio == 0.0 {
                    return Some(0.0);
                }
                ratio /= SURVIVAL;
            }
            (left, choice) = next_collision(draws)?;
        }
    }
    Some(ratio * exp(-exact_depth))
}

// The optical depth up to the next collision, and a uniform number to judge it by.
#[inline]
fn next_collision(draws: &mut Draws) -> Option<(f32, f32)> {
    let (u, choice) = draws.pair()?;
    Some((-ln(1.0 - u), choice))
}
