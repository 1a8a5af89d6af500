//! A reflection model about a shading normal, over the surface it belongs to.
//!
//! Half of what a leaning normal sees may lie below the surface itself. From there
//! no light comes, and for most materials such directions count nothing: the
//! surface is darker than its model where normals lean. Water is not: a wave's
//! face that sends a ray downwards sends it to the next wave, at a grazing angle,
//! where water reflects nearly all of it. So a direction below the water is folded
//! up about the water's plane, as by a mirror that lies there. The reflected light of
//! the model about its own normal then all leaves the surface, none is lost and
//! none is made: the integral of [`Leaning::eval_pdf`] over the directions above the surface
//! is the model's directional albedo.

use glam::Vec3;

use super::{Bsdf, BsdfSample, Tables};
use crate::math::frame::Frame;

/// `wi` mirrored about the plane of the unit normal `geometric`.
#[inline]
fn folded(geometric: Vec3, wi: Vec3) -> Vec3 {
    wi - geometric * (2.0 * wi.dot(geometric))
}

impl Bsdf {
    /// Whether directions below the surface are folded up.
    #[inline]
    const fn folds(&self) -> bool {
        match self {
            #[cfg(feature = "effects")]
            Self::Water(_) => true,
            _ => false,
        }
    }
}

/// A view of a surface whose shading normal leans.
#[derive(Clone, Copy, Debug)]
pub struct Leaning {
    /// About the shading normal.
    pub frame: Frame,
    /// The surface's own normal, unit, on the side of the viewer.
    pub geometric: Vec3,
    /// The direction to the viewer in `frame`, unit, `z >= 0`.
    pub wo_local: Vec3,
    /// Whether the material may be water. `false` where that is known when the
    /// code is compiled spares the question.
    pub water: bool,
}

impl Leaning {
    #[inline]
    fn folds(&self, bsdf: &Bsdf) -> bool {
        self.water && bsdf.folds()
    }

    /// [`Bsdf::eval_pdf`] of light from the unit world direction `wi`. Zero from
    /// below the surface, however the shading normal leans: no leaks.
    // Always: as a call it would cost surfaces that do not fold a copy of `self`.
    #[inline(always)]
    #[must_use]
    pub fn eval_pdf(&self, bsdf: &Bsdf, tables: &Tables, wi: Vec3) -> (Vec3, f32) {
        if wi.dot(self.geometric) <= 0.0 {
            return (Vec3::ZERO, 0.0);
        }
        let above = bsdf.eval_pdf(tables, self.wo_local, self.frame.to_local(wi));
        if !self.folds(bsdf) {
            return above;
        }
        let below = self.frame.to_local(folded(self.geometric, wi));
        if below.z <= 0.0 {
            return above;
        }
        let below = bsdf.eval_pdf(tables, self.wo_local, below);
        (above.0 + below.0, above.1 + below.1)
    }

    /// [`Bsdf::sample`], consistent with [`Self::eval_pdf`]: `wi` of the sample is
    /// a world direction above the surface.
    #[inline(always)]
    #[must_use]
    pub fn sample(&self, bsdf: &Bsdf, tables: &Tables, u: [f32; 3]) -> Option<BsdfSample> {
        let sample = bsdf.sample(tables, self.wo_local, u)?;
        let mut wi = self.frame.to_world(sample.wi);
        if !self.folds(bsdf) {
            return seen(self.geometric, BsdfSample { wi, ..sample });
        }
        let other = folded(self.geometric, wi);
        // `wi` becomes the one of the two that lies above; its twin in the frame.
        let twin = if wi.dot(self.geometric) > 0.0 {
            self.frame.to_local(other)
        } else {
            wi = other;
            sample.wi
        };
        if sample.delta || twin.z <= 0.0 {
            return seen(self.geometric, BsdfSample { wi, ..sample });
        }
        // Drawn as either: weighed by the density of both.
        let (f_cos, pdf) = self.eval_pdf(bsdf, tables, wi);
        (pdf > 0.0).then(|| BsdfSample {
            wi,
            weight: f_cos * (1.0 / pdf),
            pdf,
            delta: false,
        })
    }
}

/// The sample, unless its direction lies under the surface, where there is
/// nothing to be lit by. NaN goes on, to be counted as a bad sample.
#[inline]
fn seen(geometric: Vec3, sample: BsdfSample) -> Option<BsdfSample> {
    if sample.wi.dot(geometric) <= 0.0 {
        None
    } else {
        Some(sample)
    }
}
