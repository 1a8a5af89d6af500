//! The mesh all parts are written into: shared positions, texture
//! coordinates, and named parts of triangles and quadrilaterals.

use crate::vec3::Vec3;

/// Marks a corner without texture coordinates.
pub const NO_UV: u32 = u32::MAX;

/// One corner of a face: an index of a position and of a UV (or [`NO_UV`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Corner {
    /// Index into [`Mesh::positions`].
    pub position: u32,
    /// Index into [`Mesh::uvs`], or [`NO_UV`].
    pub uv: u32,
}

/// A triangle or a quadrilateral, anticlockwise seen from outside.
#[derive(Clone, Copy, Debug)]
pub struct Face {
    corners: [Corner; 4],
    count: usize,
}

impl Face {
    /// The three or four corners in order.
    #[must_use]
    pub fn corners(&self) -> &[Corner] {
        &self.corners[..self.count]
    }
}

/// Faces under one name and one material.
#[derive(Clone, Debug)]
pub struct Part {
    /// Group name, unique in its mesh.
    pub name: String,
    /// Material name (`usemtl`).
    pub material: String,
    /// The faces, in the order they were made.
    pub faces: Vec<Face>,
}

/// A mesh under construction.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Positions in metres.
    pub positions: Vec<Vec3>,
    /// Texture coordinates in [0, 1], v upwards.
    pub uvs: Vec<[f64; 2]>,
    /// The parts, in the order they were begun.
    pub parts: Vec<Part>,
}

impl Mesh {
    /// Opens a part; faces added from now on belong to it.
    pub fn begin(&mut self, name: &str, material: &str) {
        self.parts.push(Part {
            name: name.to_owned(),
            material: material.to_owned(),
            faces: Vec::new(),
        });
    }

    /// Adds a position and returns its index.
    pub fn vertex(&mut self, position: Vec3) -> u32 {
        self.positions.push(position);
        index(self.positions.len() - 1)
    }

    /// Adds texture coordinates and returns their index.
    pub fn uv(&mut self, uv: [f64; 2]) -> u32 {
        self.uvs.push(uv);
        index(self.uvs.len() - 1)
    }

    /// Adds a face of positions without texture.
    pub fn face(&mut self, positions: &[u32]) {
        let mut corners = [Corner {
            position: 0,
            uv: NO_UV,
        }; 4];
        for (corner, &position) in corners.iter_mut().zip(positions) {
            corner.position = position;
        }
        self.push(corners, positions.len());
    }

    /// Adds a face of (position, uv) pairs.
    pub fn face_uv(&mut self, pairs: &[(u32, u32)]) {
        let mut corners = [Corner {
            position: 0,
            uv: NO_UV,
        }; 4];
        for (corner, &(position, uv)) in corners.iter_mut().zip(pairs) {
            *corner = Corner { position, uv };
        }
        self.push(corners, pairs.len());
    }

    /// Faces with fewer than three different positions are left out: a
    /// collapsed quadrilateral becomes the triangle it is.
    fn push(&mut self, corners: [Corner; 4], count: usize) {
        let mut kept = [corners[0]; 4];
        let mut size = 0;
        for (i, corner) in corners.iter().take(count.min(4)).enumerate() {
            let next = corners[(i + 1) % count.min(4)];
            if corner.position != next.position {
                kept[size] = *corner;
                size += 1;
            }
        }
        if size >= 3
            && let Some(part) = self.parts.last_mut()
        {
            part.faces.push(Face {
                corners: kept,
                count: size,
            });
        }
    }

    /// Number of triangles after every quadrilateral is cut in two.
    #[must_use]
    pub fn triangles(&self) -> usize {
        self.parts
            .iter()
            .flat_map(|part| &part.faces)
            .map(|face| face.count - 2)
            .sum()
    }

    /// Volume enclosed by the faces of the named part, in cubic metres;
    /// positive when the part is closed and wound outwards.
    #[must_use]
    pub fn signed_volume(&self, part: &str) -> f64 {
        let faces = self
            .parts
            .iter()
            .filter(|p| p.name == part)
            .flat_map(|p| &p.faces);
        faces
            .flat_map(|face| {
                let corners = face.corners();
                (1..corners.len() - 1).map(move |i| [corners[0], corners[i], corners[i + 1]])
            })
            .map(|[a, b, c]| {
                let at = |corner: Corner| self.positions[corner.position as usize];
                at(a).dot(at(b).cross(at(c))) / 6.0
            })
            .sum()
    }
}

/// Indices fit 32 bits: no mesh here nears four thousand million vertices.
fn index(value: usize) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}
