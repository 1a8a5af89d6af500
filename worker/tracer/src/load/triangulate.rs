//! Polygons into triangles.

use glam::DVec3;

/// Most corners of a dented polygon that is cut ear by ear: the search takes
/// the cube of this in the worst case. Larger ones become a fan.
pub(super) const EAR_CORNERS_MAX: usize = 256;

/// How a polygon was cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cut {
    /// Properly.
    Clean,
    /// As a fan although it is dented.
    Fan,
}

/// Cut a polygon into `corners.len() - 2` triangles of indices into `corners`,
/// appended to `triangles`, with the polygon's winding. Convex polygons become
/// fans, dented ones are cut ear by ear (Meisters 1975) in the plane of their
/// Newell normal.
pub(super) fn triangulate(corners: &[DVec3], triangles: &mut Vec<[usize; 3]>) -> Cut {
    let n = corners.len();
    if n < 3 {
        return Cut::Clean;
    }
    let flat = project(corners);
    if n == 3 || is_convex(&flat) {
        triangles.extend((1..n - 1).map(|i| [0, i, i + 1]));
        return Cut::Clean;
    }
    if n > EAR_CORNERS_MAX {
        triangles.extend((1..n - 1).map(|i| [0, i, i + 1]));
        return Cut::Fan;
    }
    cut_ears(&flat, triangles);
    Cut::Clean
}

/// Corners in the plane's coordinates, counter-clockwise.
fn project(corners: &[DVec3]) -> Vec<[f64; 2]> {
    let mut normal = DVec3::ZERO;
    let origin = corners[0];
    for (i, &a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        normal += (a - origin).cross(b - origin);
    }
    // Drop the axis that the normal is nearest to; swap where that mirrors.
    let size = normal.abs();
    let axes = if size.x >= size.y && size.x >= size.z {
        if normal.x >= 0.0 { [1, 2] } else { [2, 1] }
    } else if size.y >= size.z {
        if normal.y >= 0.0 { [2, 0] } else { [0, 2] }
    } else if normal.z >= 0.0 {
        [0, 1]
    } else {
        [1, 0]
    };
    corners.iter().map(|p| axes.map(|axis| p[axis])).collect()
}

/// Twice the signed area of a triangle.
fn area([ax, ay]: [f64; 2], [bx, by]: [f64; 2], [cx, cy]: [f64; 2]) -> f64 {
    (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
}

/// Whether a fan from corner 0 stays inside: no corner turns right and every
/// triangle of the fan turns left (a pentagram turns left everywhere).
fn is_convex(flat: &[[f64; 2]]) -> bool {
    let n = flat.len();
    let turns = (0..n).all(|i| area(flat[i], flat[(i + 1) % n], flat[(i + 2) % n]) >= 0.0);
    turns && (1..n - 1).all(|i| area(flat[0], flat[i], flat[i + 1]) >= 0.0)
}

fn cut_ears(flat: &[[f64; 2]], triangles: &mut Vec<[usize; 3]>) {
    let mut left: Vec<usize> = (0..flat.len()).collect();
    let mut at = 0;
    while left.len() > 3 {
        let n = left.len();
        // Where no corner is an ear (the polygon crosses itself), cut any.
        let ear = (0..n)
            .map(|step| (at + step) % n)
            .find(|&i| is_ear(flat, &left, i))
            .unwrap_or(at % n);
        triangles.push([left[(ear + n - 1) % n], left[ear], left[(ear + 1) % n]]);
        left.remove(ear);
        at = ear;
    }
    triangles.push([left[0], left[1], left[2]]);
}

/// Whether the triangle at corner `i` turns left and holds no other corner.
fn is_ear(flat: &[[f64; 2]], left: &[usize], i: usize) -> bool {
    let n = left.len();
    let [a, b, c] = [left[(i + n - 1) % n], left[i], left[(i + 1) % n]].map(|k| flat[k]);
    if area(a, b, c) <= 0.0 {
        return false;
    }
    left.iter().map(|&k| flat[k]).all(|p| {
        p == a
            || p == b
            || p == c
            || area(a, b, p) < 0.0
            || area(b, c, p) < 0.0
            || area(c, a, p) < 0.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(points: &[[f64; 3]]) -> (Vec<[usize; 3]>, Cut) {
        let corners: Vec<DVec3> = points.iter().map(|&p| DVec3::from(p)).collect();
        let mut triangles = Vec::new();
        let how = triangulate(&corners, &mut triangles);
        assert_eq!(triangles.len(), points.len() - 2);
        // Every triangle has the polygon's winding, and areas add up.
        let mut total = DVec3::ZERO;
        let mut sum = 0.0;
        for i in 1..corners.len() - 1 {
            total += (corners[i] - corners[0]).cross(corners[i + 1] - corners[0]);
        }
        for [a, b, c] in &triangles {
            let cross = (corners[*b] - corners[*a]).cross(corners[*c] - corners[*a]);
            assert!(how == Cut::Fan || cross.dot(total) >= 0.0, "{triangles:?}");
            sum += cross.length();
        }
        assert!(
            how == Cut::Fan || (sum - total.length()).abs() < 1e-9,
            "{triangles:?}"
        );
        (triangles, how)
    }

    #[test]
    fn dented_polygons_keep_their_area_in_every_plane() {
        let arrow = [[0.0, 0.0], [4.0, -2.0], [1.0, 0.0], [4.0, 2.0]];
        let comb = [
            [0.0, 0.0],
            [5.0, 0.0],
            [5.0, 3.0],
            [4.0, 1.0],
            [3.0, 3.0],
            [2.0, 1.0],
            [1.0, 3.0],
            [0.5, 1.0],
        ];
        for shape in [&arrow[..], &comb[..]] {
            for start in 0..shape.len() {
                for axis in 0..3 {
                    for mirror in [false, true] {
                        let points: Vec<[f64; 3]> = (0..shape.len())
                            .map(|i| {
                                let i = if mirror { shape.len() - 1 - i } else { i };
                                let [x, y] = shape[(i + start) % shape.len()];
                                let mut p = [x, y, 0.3 * x + 0.1 * y];
                                p.rotate_right(axis);
                                p
                            })
                            .collect();
                        cut(&points);
                    }
                }
            }
        }
    }

    #[test]
    fn odd_polygons_end() {
        // Crossing itself, all corners equal, on a line, not finite, too large.
        let bow = [[0.0; 3], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mut triangles = Vec::new();
        triangulate(&bow.map(DVec3::from), &mut triangles);
        triangulate(&[DVec3::ONE; 7], &mut triangles);
        triangulate(&[DVec3::NAN; 7], &mut triangles);
        let line: Vec<DVec3> = (0..9).map(|i| DVec3::splat(f64::from(i))).collect();
        triangulate(&line, &mut triangles);
        assert_eq!(triangles.len(), 2 + 5 + 5 + 7);
        let star: Vec<[f64; 3]> = (0..600)
            .map(|i| [f64::from(i), f64::from(i % 2), 0.0])
            .chain([[300.0, 900.0, 0.0]])
            .collect();
        assert_eq!(cut(&star).1, Cut::Fan);
    }
}
