//! Participating media: what scatters light without a surface.
//!
//! A scene's volumes are independent: each decides for itself where a ray would
//! meet something in it, and the nearest place wins; of light that passes, the shares
//! are multiplied. That is the same as one medium with the sum of their densities.

mod bake;
mod density;
mod draws;
mod march;
mod noise;
pub mod phase;
mod tracking;
mod volume;
mod walk;

pub use bake::bake_ellipsoid;
pub use density::{Bounds, DensityGrid};
pub use phase::{Phase, PhaseSample};
pub use volume::{Method, Outline, Volume};
pub use walk::{Piece, Span, Walk};

use crate::geometry::Ray;
use draws::Draws;

/// What became of a ray in one volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Flight {
    /// It came through.
    Passed,
    /// It met something, so many metres along the ray.
    Collided(f32),
    /// It took more steps than are allowed.
    GaveUp,
}

/// Where a ray met something, and in which volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Collision {
    /// Metres along the ray.
    pub t: f32,
    /// How the volume scatters.
    pub phase: Phase,
}

/// A flight took more steps than are allowed; its path ends and is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GaveUp;

/// The volumes of a scene.
#[derive(Clone, Debug, Default)]
pub struct Media {
    volumes: Vec<Volume>,
}

impl Media {
    /// Volumes in the scene's order.
    #[must_use]
    pub fn new(volumes: Vec<Volume>) -> Self {
        Self { volumes }
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.volumes.is_empty()
    }

    /// The nearest collision before `t_limit` (may be infinite). `key` names the
    /// sample and the segment of its path.
    ///
    /// # Errors
    /// Too many steps.
    #[inline]
    pub fn collide(&self, ray: &Ray, t_limit: f32, key: u64) -> Result<Option<Collision>, GaveUp> {
        let mut nearest = None;
        let mut limit = t_limit;
        for (number, volume) in self.volumes.iter().enumerate() {
            let Some(span) = volume.span(ray, limit) else {
                continue;
            };
            let mut draws = Draws::new(key, number);
            let flight = match volume.method {
                Method::Tracking => tracking::collide(volume, &span, &mut draws),
                Method::March { step_m } => march::collide(volume, &span, step_m, &mut draws),
            };
            match flight {
                Flight::Passed => {}
                Flight::GaveUp => return Err(GaveUp),
                Flight::Collided(t) => {
                    // Strictly nearer, or the first of the volumes keeps it.
                    if t < limit || nearest.is_none() {
                        limit = t;
                        nearest = Some(Collision {
                            t,
                            phase: volume.phase,
                        });
                    }
                }
            }
        }
        Ok(nearest)
    }

    /// The share of light that passes along a ray up to its end: of every volume the
    /// estimate of its own method, multiplied in the scene's order.
    ///
    /// # Errors
    /// Too many steps.
    #[inline]
    pub fn transmittance(&self, ray: &Ray, key: u64) -> Result<f32, GaveUp> {
        let mut passed = 1.0f32;
        for (number, volume) in self.volumes.iter().enumerate() {
            let Some(span) = volume.span(ray, ray.t_max) else {
                continue;
            };
            let mut draws = Draws::new(key, number);
            let share = match volume.method {
                Method::Tracking => tracking::transmittance(volume, &span, &mut draws),
                Method::March { step_m } => march::transmittance(volume, &span, step_m, &mut draws),
            };
            passed *= share.ok_or(GaveUp)?;
            if passed == 0.0 {
                break;
            }
        }
        Ok(passed)
    }
}
