//! Shading normals from the shape alone.

use glam::{DVec3, Vec3};

/// Most corners at one point that are smoothed: every pair of them is compared.
/// A finer fan is faceted, at angles that nobody sees.
const SMOOTHED_CORNERS_MAX: usize = 1024;

/// Unit normal of a triangle; zero if it has no area.
pub(super) fn triangle_normal([a, b, c]: [Vec3; 3]) -> DVec3 {
    let [a, b, c] = [a, b, c].map(Vec3::as_dvec3);
    (b - a).cross(c - a).normalize_or_zero()
}

/// Triangles around each point, in their order.
pub(super) struct Corners {
    /// Start of each point's run in `corners`; one more than there are points.
    starts: Vec<u32>,
    /// `3 * triangle + corner`.
    corners: Vec<u32>,
}

/// Sort the corners of all triangles by their point.
pub(super) fn corners_by_point(points: usize, triangles: &[[u32; 3]]) -> Corners {
    let mut starts = vec![0_u32; points + 2];
    for &point in triangles.as_flattened() {
        starts[point as usize + 2] += 1;
    }
    for i in 2..starts.len() {
        starts[i] += starts[i - 1];
    }
    let mut corners = vec![0_u32; triangles.len() * 3];
    for (corner, &point) in triangles.as_flattened().iter().enumerate() {
        let next = &mut starts[point as usize + 1];
        corners[*next as usize] = corner as u32;
        *next += 1;
    }
    starts.pop();
    Corners { starts, corners }
}

/// The normal at every corner: the mean of the normals of the triangles around
/// its point that meet its own at less than the crease angle, weighted by their
/// angle there (Thuermer and Wuethrich 1998), so that the cut of a face into
/// triangles does not show. Corners that smooth over the same triangles get the
/// same bits, because the sum runs in the order of the triangles.
pub(super) fn smooth_normals(
    points: &[Vec3],
    triangles: &[[u32; 3]],
    crease_angle_deg: f64,
) -> Vec<[Vec3; 3]> {
    let shape = |t: &[u32; 3]| t.map(|p| points[p as usize]);
    let faces: Vec<DVec3> = triangles
        .iter()
        .map(|t| triangle_normal(shape(t)))
        .collect();
    // The bound is a hair wide, so that 90 degrees smooths a cube.
    let cos_crease = libm::cos(crease_angle_deg.to_radians()) - 1e-6;
    let around = corners_by_point(points.len(), triangles);
    let mut normals: Vec<[Vec3; 3]> = faces.iter().map(|n| [n.as_vec3(); 3]).collect();
    let mut weighted: Vec<(DVec3, DVec3)> = Vec::new();
    for run in around.starts.windows(2) {
        let corners = &around.corners[run[0] as usize..run[1] as usize];
        if corners.len() > SMOOTHED_CORNERS_MAX {
            continue;
        }
        weighted.clear();
        weighted.extend(corners.iter().map(|&corner| {
            let (t, k) = (corner as usize / 3, corner as usize % 3);
            (faces[t], faces[t] * corner_angle(shape(&triangles[t]), k))
        }));
        for (&corner, &(own, _)) in corners.iter().zip(&weighted) {
            let mut sum = DVec3::ZERO;
            for &(face, share) in &weighted {
                if own.dot(face) >= cos_crease {
                    sum += share;
                }
            }
            let normal = sum.normalize_or_zero();
            if normal != DVec3::ZERO {
                normals[corner as usize / 3][corner as usize % 3] = normal.as_vec3();
            }
        }
    }
    normals
}

/// Angle of a triangle at its corner `k` in radians.
fn corner_angle(triangle: [Vec3; 3], k: usize) -> f64 {
    let [at, next, last] = [k, (k + 1) % 3, (k + 2) % 3].map(|i| triangle[i].as_dvec3());
    let (a, b) = (next - at, last - at);
    libm::atan2(a.cross(b).length(), a.dot(b))
}
