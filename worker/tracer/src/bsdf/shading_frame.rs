//! Two normals at one point: the geometric one decides what can be seen, the
//! shading one (interpolated or bumped) how it reflects.
//!
//! Order at a hit: [`face_viewer`], then [`bend_normal`] for shiny surfaces,
//! then a [`crate::math::frame::Frame`] from the result; light from the far
//! side ([`same_side`]) counts nothing, however the shading normal leans.

use glam::Vec3;

/// A mirror direction is lifted to at least this sine above the surface (or to
/// 0.9 of the viewer's own, if that is lower: a flat mirror must stay as it is).
const LIFT_MIN: f32 = 0.01;
const LIFT_SHARE: f32 = 0.9;
/// Half vectors shorter than this (squared) have no direction left in f32.
const HALF_LENGTH2_MIN: f32 = 1e-12;

/// Both normals turned: the geometric one to the side of `wo`, then the shading
/// one to the side of that. Returns `(shading, geometric)`; all unit vectors.
#[inline]
#[must_use]
pub fn face_viewer(shading: Vec3, geometric: Vec3, wo: Vec3) -> (Vec3, Vec3) {
    let geometric = if geometric.dot(wo) < 0.0 {
        -geometric
    } else {
        geometric
    };
    let shading = if shading.dot(geometric) < 0.0 {
        -shading
    } else {
        shading
    };
    (shading, geometric)
}

/// The shading normal, bent just so far that the mirror image of `wo` about it
/// stays above the geometric surface and `wo` stays above the normal's horizon.
/// Where that holds already, the normal comes back unchanged, bit for bit.
///
/// Expects [`face_viewer`] to have been applied. The image below the surface is
/// raised straight along the geometric normal, and the new normal is the half
/// vector of that direction and `wo` (an idea of Keller et al. 2017, "The Iray
/// Light Transport Simulation and Rendering System", appendix).
#[inline]
#[must_use]
pub fn bend_normal(shading: Vec3, geometric: Vec3, wo: Vec3) -> Vec3 {
    let view_height = wo.dot(geometric);
    let image = shading * (2.0 * wo.dot(shading)) - wo;
    let height = image.dot(geometric);
    let wanted = LIFT_MIN.min(LIFT_SHARE * view_height);
    if height >= wanted {
        return shading;
    }
    let lifted = image + geometric * (wanted - height);
    let half = wo + lifted.normalize_or_zero();
    if half.length_squared() > HALF_LENGTH2_MIN {
        half.normalize()
    } else {
        geometric
    }
}

/// Whether two directions leave on the same side of the geometric surface.
/// Otherwise the surface itself stands between them and nothing is reflected,
/// whatever the shading normal says.
#[inline]
#[must_use]
pub fn same_side(geometric: Vec3, wo: Vec3, wi: Vec3) -> bool {
    wo.dot(geometric) * wi.dot(geometric) > 0.0
}
