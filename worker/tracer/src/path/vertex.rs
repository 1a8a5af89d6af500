//! A place where light scatters: on a surface, or without one.

use crate::bsdf::leaning::Leaning;
use crate::bsdf::{Bsdf, Tables};
use crate::geometry::SurfacePoint;
use crate::math::frame::Frame;
use crate::medium::Phase;
use crate::uses;
use glam::Vec3;

/// The effects that scatter light without a surface normal. A scene with none of
/// them has no code for it.
const WITHOUT_SURFACE: u8 = uses::PARTICLES | uses::MEDIA;

/// How light scatters at a vertex.
#[derive(Clone, Copy, Debug)]
pub(super) enum Scattering {
    /// By a surface, to its own side only.
    Surface(Bsdf),
    /// By a cloud: to all sides, no normal, no cosine.
    Phase(Phase),
}

/// A point where light scatters, seen from `wo`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    /// Where, with error bounds and the surface's own normal.
    pub point: SurfacePoint,
    /// The surface's own normal on the side of `wo`; without a surface, `wo`.
    pub n_geometric: Vec3,
    /// Shading frame, its normal on the side of `wo`; without a surface, about
    /// `wo`.
    pub frame: Frame,
    /// `wo` in the shading frame.
    pub wo_local: Vec3,
    /// How it scatters.
    pub scattering: Scattering,
}

/// One sampled continuation of a path.
#[derive(Clone, Copy, Debug)]
pub(super) struct ScatterSample {
    /// The direction the light comes from, world space.
    pub wi: Vec3,
    /// Scattered radiance over density.
    pub weight: Vec3,
    /// Density of `wi` per steradian.
    pub pdf: f32,
    /// Whether `wi` is the one direction of a perfect mirror.
    pub delta: bool,
}

impl Vertex {
    /// A vertex without a surface, seen from `wo`. Rays leave it from
    /// `point.origin_towards`: a sprite's point has an error and a normal so that
    /// they do not meet it again, a point of a volume has no error.
    #[inline]
    pub(super) fn without_surface(point: SurfacePoint, wo: Vec3, phase: Phase) -> Self {
        Self {
            point,
            n_geometric: wo,
            frame: Frame::from_normal(wo),
            wo_local: Vec3::Z,
            scattering: Scattering::Phase(phase),
        }
    }

    /// A colour for the albedo image.
    #[inline]
    pub(super) fn albedo(&self) -> Vec3 {
        match &self.scattering {
            Scattering::Surface(bsdf) => bsdf.albedo(),
            Scattering::Phase(phase) => phase.albedo,
        }
    }

    /// Whether no light sampling can find what the vertex scatters.
    #[inline]
    pub(super) fn is_delta<const USES: u8>(&self) -> bool {
        match &self.scattering {
            Scattering::Surface(bsdf) => bsdf.is_delta(),
            Scattering::Phase(_) => false,
        }
    }

    /// Whether sampling the whole sky finds more than the vertex's own directions.
    #[inline]
    pub(super) fn light_sampling_pays<const USES: u8>(&self) -> bool {
        match &self.scattering {
            Scattering::Surface(bsdf) => bsdf.light_sampling_pays(),
            Scattering::Phase(_) => USES & WITHOUT_SURFACE != 0,
        }
    }

    #[inline]
    fn leaning<const USES: u8>(&self) -> Leaning {
        Leaning {
            frame: self.frame,
            geometric: self.n_geometric,
            wo_local: self.wo_local,
            water: USES & uses::SURROUNDINGS != 0,
        }
    }

    /// Radiance scattered from `wi` (with the cosine of a surface) for light of
    /// density 1 per steradian, and the density with which [`Vertex::sample`]
    /// makes `wi`. Zero where nothing is scattered.
    #[inline]
    pub(super) fn eval_pdf<const USES: u8>(&self, tables: &Tables, wi: Vec3) -> (Vec3, f32) {
        match &self.scattering {
            Scattering::Phase(phase) if USES & WITHOUT_SURFACE != 0 => {
                let pdf = phase.pdf(self.frame.normal, wi);
                (phase.albedo * pdf, pdf)
            }
            Scattering::Phase(_) => (Vec3::ZERO, 0.0),
            Scattering::Surface(bsdf) => self.leaning::<USES>().eval_pdf(bsdf, tables, wi),
        }
    }

    /// The next direction; `None` when the light is absorbed.
    #[inline]
    pub(super) fn sample<const USES: u8>(
        &self,
        tables: &Tables,
        u: [f32; 3],
    ) -> Option<ScatterSample> {
        match &self.scattering {
            Scattering::Phase(phase) if USES & WITHOUT_SURFACE != 0 => {
                let sample = phase.sample(self.frame.normal, [u[1], u[2]]);
                Some(ScatterSample {
                    wi: sample.wi,
                    weight: phase.albedo,
                    pdf: sample.pdf,
                    delta: false,
                })
            }
            Scattering::Surface(bsdf) => {
                let sample = self.leaning::<USES>().sample(bsdf, tables, u)?;
                Some(ScatterSample {
                    wi: sample.wi,
                    weight: sample.weight,
                    pdf: sample.pdf,
                    delta: sample.delta,
                })
            }
            Scattering::Phase(_) => None,
        }
    }
}
