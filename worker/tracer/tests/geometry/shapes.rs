//! Test bodies and a small generator of repeatable numbers.

use glam::{Affine3A, Vec3};
use shearwater_tracer::geometry::{Geometry, Instance, TriMesh};

/// SplitMix64 (Steele, Lea, Flood 2014).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In [0, 1).
    pub(crate) fn unit(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1 << 24) as f32
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    /// In the cube [-1, 1)^3.
    pub(crate) fn cube(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }

    pub(crate) fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.cube();
            let l = v.length_squared();
            if l > 1e-4 && l < 1.0 {
                return v.normalize();
            }
        }
    }
}

pub(crate) type Mesh = (Vec<Vec3>, Vec<[u32; 3]>);

/// A closed bumpy ball: a cube's faces of `n * n` quads, blown up.
pub(crate) fn ball(n: u32, centre: Vec3, radius: f32) -> Mesh {
    let mut index = std::collections::BTreeMap::new();
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    let mut vertex = |c: [i32; 3]| {
        *index.entry(c).or_insert_with(|| {
            let v = Vec3::new(c[0] as f32, c[1] as f32, c[2] as f32) / n as f32;
            let bump = 1.0 + 0.15 * ((c[0] * 7 + c[1] * 13 + c[2] * 5) % 11) as f32 / 11.0;
            positions.push(centre + v.normalize() * radius * bump);
            positions.len() as u32 - 1
        })
    };
    let n = n as i32;
    for axis in 0..3 {
        for side in [-n, n] {
            for i in 0..n {
                for j in 0..n {
                    let mut at = |a: i32, b: i32| {
                        let mut c = [0; 3];
                        c[axis] = side;
                        c[(axis + 1) % 3] = 2 * a - n;
                        c[(axis + 2) % 3] = 2 * b - n;
                        vertex(c)
                    };
                    let q = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                    let (a, b) = ([q[0], q[1], q[2]], [q[0], q[2], q[3]]);
                    let flip = |t: [u32; 3]| if side > 0 { t } else { [t[0], t[2], t[1]] };
                    triangles.extend([flip(a), flip(b)]);
                }
            }
        }
    }
    (positions, triangles)
}

/// A convex body of few large faces: an octahedron.
pub(crate) fn octahedron(centre: Vec3, size: f32) -> Mesh {
    let p = [
        Vec3::X,
        Vec3::Y,
        Vec3::Z,
        Vec3::NEG_X,
        Vec3::NEG_Y,
        Vec3::NEG_Z,
    ]
    .map(|v| centre + v * size);
    let t = vec![
        [0, 1, 2],
        [1, 3, 2],
        [3, 4, 2],
        [4, 0, 2],
        [1, 0, 5],
        [3, 1, 5],
        [4, 3, 5],
        [0, 4, 5],
    ];
    (p.to_vec(), t)
}

/// Triangles anywhere in the unit cube, of many sizes and shapes.
pub(crate) fn soup(count: usize, seed: u64) -> Mesh {
    let mut r = Random(seed);
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for _ in 0..count {
        let at = r.cube();
        let size = 0.01 + 0.3 * r.unit() * r.unit();
        // One in four is a sliver.
        let slim = if r.below(4) == 0 { 0.01 } else { 1.0 };
        let first = positions.len() as u32;
        let long = r.cube() * size * if slim < 1.0 { 4.0 } else { 1.0 };
        positions.extend([at, at + long, at + long * 0.4 + r.cube() * size * slim]);
        triangles.push([first, first + 1, first + 2]);
    }
    (positions, triangles)
}

/// One mesh where it is.
pub(crate) fn alone(mesh: &Mesh) -> Geometry {
    let mesh = TriMesh::build(&mesh.0, &mesh.1).unwrap();
    let instance = Instance::new(0, Affine3A::IDENTITY).unwrap();
    Geometry::build(vec![mesh], vec![instance], None, None).unwrap()
}

/// An uneven, mirrored placement.
pub(crate) fn skew(seed: u64) -> Affine3A {
    let mut r = Random(seed);
    let turn =
        glam::Quat::from_xyzw(r.unit(), r.unit() - 0.5, r.unit(), r.unit() + 0.1).normalize();
    let sign = if r.below(2) == 0 { -1.0 } else { 1.0 };
    let scale = Vec3::new(
        sign * (0.3 + r.unit()),
        0.3 + r.unit(),
        0.3 + 2.0 * r.unit(),
    );
    Affine3A::from_scale_rotation_translation(scale, turn, r.cube() * 3.0)
}
