//! From a hit to a place where light scatters.

use super::vertex::{Scattering, Vertex};
use crate::bsdf::Bsdf;
use crate::bsdf::shading_frame::{bend_normal, face_viewer};
use crate::geometry::{Hit, HitKind, Ray};
use crate::math::frame::Frame;
use crate::scene::Scene;
use crate::uses::{PARTICLES, SURROUNDINGS};
use glam::Vec3;

/// What lies at a hit, for a ray that is `footprint_m` wide there.
#[inline]
pub(super) fn interaction<const USES: u8>(
    scene: &Scene,
    ray: &Ray,
    hit: &Hit,
    footprint_m: f32,
) -> Vertex {
    let point = scene.geometry.surface_point_of::<USES>(ray, hit);
    let wo = -ray.d;
    let (n_shading, bsdf) = match hit.kind {
        HitKind::Triangle {
            instance,
            prim,
            u,
            v,
        } => scene.surface::<USES>(instance, prim, u, v, point.n_geometric, ray.time_s),
        HitKind::Particle { prim, .. } if USES & PARTICLES != 0 => {
            (point.n_geometric, scene.particle_bsdf(prim))
        }
        HitKind::Sprite { prim } if USES & PARTICLES != 0 => {
            return Vertex::without_surface(point, wo, scene.sprite_phase(prim));
        }
        HitKind::Water if USES & SURROUNDINGS != 0 => {
            scene.water_surface(point.p, ray.time_s, footprint_m)
        }
        _ => (point.n_geometric, Bsdf::Lambert { albedo: Vec3::ZERO }),
    };
    let (n_shading, n_geometric) = face_viewer(n_shading, point.n_geometric, wo);
    let bent = if n_shading == n_geometric {
        n_shading
    } else {
        bend_normal(n_shading, n_geometric, wo)
    };
    let frame = Frame::from_normal(bent);
    Vertex {
        point,
        n_geometric,
        frame,
        wo_local: frame.to_local(wo),
        scattering: Scattering::Surface(bsdf),
    }
}
