//! What a path meets next: a surface, something inside a volume, or the sky.

use super::interaction::interaction;
use super::vertex::Vertex;
use crate::geometry::{Hit, Ray, SurfacePoint};
use crate::medium::{Collision, GaveUp};
use crate::sampler::SampleStream;
use crate::scene::Scene;
use crate::uses;
use glam::Vec3;

/// What a ray through a volume is for: each draws by itself.
#[derive(Clone, Copy)]
pub(super) enum Purpose {
    /// The path's own next segment.
    Flight,
    /// A shadow ray towards the sun.
    ToSun,
    /// A shadow ray towards the sky.
    ToSky,
}

/// Key of a ray's draws in volumes, at scattering `depth`; 0 in a scene without any.
#[inline]
pub(super) fn volume_key<const USES: u8>(
    stream: &SampleStream,
    depth: u32,
    purpose: Purpose,
) -> u64 {
    if USES & uses::MEDIA == 0 {
        return 0;
    }
    // Apart from the segment's own key, which judges particles.
    stream.segment_key(depth) ^ (0xF11D_E5C0_77E2_0001 + purpose as u64)
}

/// The nearest collision in a volume before `limit`.
#[inline]
pub(super) fn collide<const USES: u8>(
    scene: &Scene,
    ray: &Ray,
    limit: f32,
    key: u64,
) -> Result<Option<Collision>, GaveUp> {
    if USES & uses::MEDIA == 0 {
        return Ok(None);
    }
    scene.common.media.collide(ray, limit, key)
}

/// The share of light that volumes let through. One that gives up lets none
/// through, and `gave_up` is set.
#[inline]
pub(super) fn passed_by_volumes<const USES: u8>(
    scene: &Scene,
    ray: &Ray,
    key: u64,
    gave_up: &mut bool,
) -> f32 {
    if USES & uses::MEDIA == 0 {
        return 1.0;
    }
    match scene.common.media.transmittance(ray, key) {
        Ok(passed) => passed,
        Err(GaveUp) => {
            *gave_up = true;
            0.0
        }
    }
}

/// The nearest thing on a ray.
#[derive(Clone, Copy)]
pub(super) enum Met {
    /// On a surface.
    Surface(Hit),
    /// Inside a volume.
    Volume(Collision),
}

impl Met {
    /// The nearer of the two; a surface at equal distance.
    #[inline]
    pub(super) fn nearer(hit: Option<Hit>, collision: Option<Collision>) -> Option<Self> {
        match (hit, collision) {
            (hit, None) => hit.map(Self::Surface),
            (Some(hit), Some(collision)) if hit.t <= collision.t => Some(Self::Surface(hit)),
            (_, Some(collision)) => Some(Self::Volume(collision)),
        }
    }

    /// Distance along the ray, metres.
    #[inline]
    pub(super) fn t(&self) -> f32 {
        match self {
            Self::Surface(hit) => hit.t,
            Self::Volume(collision) => collision.t,
        }
    }

    /// The place where light scatters, for a ray that is `footprint_m` wide there.
    #[inline]
    pub(super) fn vertex<const USES: u8>(
        &self,
        scene: &Scene,
        ray: &Ray,
        footprint_m: f32,
    ) -> Vertex {
        match self {
            Self::Surface(hit) => interaction::<USES>(scene, ray, hit, footprint_m),
            Self::Volume(collision) => {
                let point = SurfacePoint {
                    p: ray.at(collision.t),
                    error: Vec3::ZERO,
                    n_geometric: -ray.d,
                };
                Vertex::without_surface(point, -ray.d, collision.phase)
            }
        }
    }
}
