//! Leaving a surface without meeting it again.

use glam::Vec3;

/// Bound on the relative error of `n` roundings (Higham 2002, "Accuracy and
/// stability of numerical algorithms", lemma 3.1).
pub(super) fn gamma(n: u32) -> f32 {
    let unit = f32::EPSILON * 0.5;
    let nu = n as f32 * unit;
    nu / (1.0 - nu)
}

/// The origin of a ray that leaves the point `p` in direction `w`.
///
/// `error` bounds the distance of `p` from the true surface along each axis, as
/// `SurfacePoint` gives it; `n_geometric` is the unit normal, either side. The
/// origin moves along the normal until it is on the side of `w` whatever the
/// roundings, and then one float further (Pharr, Jakob, Humphreys 2023, "Physically
/// based rendering", section 6.8.6).
pub fn offset_origin(p: Vec3, error: Vec3, n_geometric: Vec3, w: Vec3) -> Vec3 {
    let distance = n_geometric.abs().dot(error);
    let side = if w.dot(n_geometric) < 0.0 {
        -n_geometric
    } else {
        n_geometric
    };
    let moved = p + side * distance;
    Vec3::new(
        away(moved.x, side.x),
        away(moved.y, side.y),
        away(moved.z, side.z),
    )
}

fn away(x: f32, side: f32) -> f32 {
    if side > 0.0 {
        x.next_up()
    } else if side < 0.0 {
        x.next_down()
    } else {
        x
    }
}
