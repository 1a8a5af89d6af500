//! Where a hit is, and how well that is known.

use glam::{Affine3A, Mat3, Vec3};

use super::instance::Instance;
use super::offset::{gamma, offset_origin};
use super::particles::Ellipsoid;
use super::ray::{Hit, HitKind, Ray};
use super::scene::Geometry;
use super::sprites::Sprite;
use crate::uses::{MOTION, PARTICLES, SURROUNDINGS};

/// A point on a surface, computed from the surface rather than along the ray: the
/// error is that of the surface's coordinates, not of the ray's length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The point, world space, metres.
    pub p: Vec3,
    /// Bound on its error along each axis, metres, with the roundings that a ray
    /// back to this surface undergoes.
    pub error: Vec3,
    /// Unit normal of the surface itself: of a triangle by its winding in mesh
    /// space, of a particle outwards, of the water upwards,
    /// of a sprite to the camera.
    pub n_geometric: Vec3,
}

impl SurfacePoint {
    /// The origin of a ray that leaves this point in direction `w`.
    pub fn origin_towards(&self, w: Vec3) -> Vec3 {
        offset_origin(self.p, self.error, self.n_geometric, w)
    }
}

impl Geometry {
    /// The point of a hit that a query of this geometry with this ray gave.
    pub fn surface_point(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        self.surface_point_of::<{ MOTION | PARTICLES | SURROUNDINGS }>(ray, hit)
    }

    /// The same, for a hit of a query with these `USES`.
    #[inline]
    pub(crate) fn surface_point_of<const USES: u8>(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        match hit.kind {
            HitKind::Water if USES & SURROUNDINGS != 0 => {
                water_point(self.water_y().unwrap_or(0.0), ray, hit.t)
            }
            HitKind::Triangle {
                instance,
                prim,
                u,
                v,
            } => match self.instances().get(instance as usize) {
                Some(i) => triangle_point::<USES>(
                    i,
                    self.meshes()[i.mesh() as usize].corners(prim),
                    u,
                    v,
                    ray,
                ),
                None => along(ray, hit.t),
            },
            HitKind::Sprite { prim } if USES & PARTICLES != 0 => match self
                .sprites
                .as_ref()
                .and_then(|f| f.sprites.sprites().get(prim as usize).zip(Some(f.eye)))
            {
                Some((s, eye)) => sprite_point(s, eye, ray, hit.t),
                None => along(ray, hit.t),
            },
            HitKind::Particle { prim, .. } if USES & PARTICLES != 0 => match self
                .particles()
                .and_then(|p| p.ellipsoids().get(prim as usize))
            {
                Some(e) => ellipsoid_point(e, ray, hit.t),
                None => along(ray, hit.t),
            },
            _ => along(ray, hit.t),
        }
    }
}

/// For a hit of another geometry: a point on the ray.
fn along(ray: &Ray, t: f32) -> SurfacePoint {
    let p = ray.at(t);
    SurfacePoint {
        p,
        error: gamma(4) * (ray.o.abs() + p.abs()),
        n_geometric: -ray.d,
    }
}

/// The height is exact, so one float above it is above it.
fn water_point(height: f32, ray: &Ray, t: f32) -> SurfacePoint {
    let p = ray.at(t);
    let error = gamma(4) * (ray.o.abs() + p.abs());
    SurfacePoint {
        p: Vec3::new(p.x, height, p.z),
        error: Vec3::new(error.x, 0.0, error.z),
        n_geometric: Vec3::Y,
    }
}

/// Errors of the weighted sum, of the plane distance that a ray back computes
/// (proportional to the edges), and of both ways through the transform.
fn triangle_point<const USES: u8>(
    instance: &Instance,
    corners: [Vec3; 3],
    u: f32,
    v: f32,
    ray: &Ray,
) -> SurfacePoint {
    let [v0, v1, v2] = corners;
    let w = 1.0 - u - v;
    let local = w * v0 + u * v1 + v * v2;
    let (e1, e2) = (v1 - v0, v2 - v0);
    let sum_error = gamma(7) * ((w * v0).abs() + (u * v1).abs() + (v * v2).abs());
    let local_error = sum_error + gamma(3) * e1.abs().max(e2.abs());
    let n = unit_cross(e1, e2);
    // What moves is undone at the ray's time as exactly as what stands still.
    let moving = instance.motion.as_ref().filter(|_| USES & MOTION != 0);
    let moved = moving.map(|m| m.both_ways(ray.time_s));
    let (world, inverse) = match &moved {
        Some((forth, back)) => (forth, back),
        None => (&instance.world_from_local, &instance.local_from_world),
    };
    if *world == Affine3A::IDENTITY {
        return SurfacePoint {
            p: local,
            error: local_error,
            n_geometric: n.unwrap_or(-ray.d),
        };
    }
    let p = world.transform_point3(local);
    let (forth, back) = (absolute(world), absolute(inverse));
    let there = gamma(4) * (forth * local.abs() + Vec3::from(world.translation).abs());
    let back_again = gamma(4) * (back * p.abs() + Vec3::from(inverse.translation).abs());
    let error = (1.0 + gamma(4)) * (forth * (local_error + back_again)) + there;
    let n = n.and_then(|n| (Mat3::from(inverse.matrix3).transpose() * n).try_normalize());
    SurfacePoint {
        p,
        error,
        n_geometric: n.unwrap_or(-ray.d),
    }
}

/// The unit normal, if there is one; scaled first, so that nothing overflows.
fn unit_cross(e1: Vec3, e2: Vec3) -> Option<Vec3> {
    let scaled = |e: Vec3| e / e.abs().max_element();
    scaled(e1).cross(scaled(e2)).try_normalize()
}

fn absolute(a: &Affine3A) -> Mat3 {
    Mat3::from(a.matrix3).abs()
}

/// The point is put on the unit sphere and from there on the ellipsoid.
fn ellipsoid_point(e: &Ellipsoid, ray: &Ray, t: f32) -> SurfacePoint {
    let unit = ((ray.at(t) - e.centre) / e.radii).normalize_or(-ray.d);
    let reach = unit * e.radii;
    SurfacePoint {
        p: e.centre + reach,
        // The discriminant's roundings are relative to the radius.
        error: gamma(5) * e.centre.abs() + gamma(12) * e.radii,
        n_geometric: (unit / e.radii).normalize_or(unit),
    }
}

/// The point is put into the disc's plane. A ray back computes its height over
/// that plane with errors in proportion to the radius.
fn sprite_point(s: &Sprite, eye: Vec3, ray: &Ray, t: f32) -> SurfacePoint {
    let n = (eye - s.centre).normalize_or(-ray.d);
    let reach = ray.at(t) - s.centre;
    let reach = reach - n * n.dot(reach);
    SurfacePoint {
        p: s.centre + reach,
        error: gamma(3) * s.centre.abs() + Vec3::splat(gamma(24) * s.radius),
        n_geometric: n,
    }
}
