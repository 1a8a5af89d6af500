//! What a loader left out or made up.

use std::fmt;

/// Counts of what was odd in a mesh file but did not stop it from loading.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LoadNotes {
    /// Vertices with NaN or infinity that a face uses.
    pub non_finite_vertices: usize,
    /// Faces left out because of such a vertex.
    pub non_finite_faces: usize,
    /// Triangles and faces left out because they have no area.
    pub degenerate_faces: usize,
    /// Corners whose normal in the file was zero or not finite: recomputed.
    pub bad_normals: usize,
    /// Corners whose texture coordinates were not finite: set to 0.
    pub bad_uvs: usize,
    /// Faces before any `usemtl`: they take the default material.
    pub unnamed_material_faces: usize,
    /// Faces with dents and too many corners to cut properly: cut as a fan.
    pub fanned_faces: usize,
    /// Points and lines, which have no area: left out.
    pub points_and_lines: usize,
}

impl LoadNotes {
    /// Whether nothing was odd.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Every count with its meaning, in a fixed order.
    fn entries(&self) -> [(usize, &'static str); 8] {
        [
            (self.non_finite_vertices, "vertices that are not finite"),
            (self.non_finite_faces, "faces with such vertices left out"),
            (self.degenerate_faces, "faces without area left out"),
            (self.bad_normals, "unusable normals recomputed"),
            (
                self.bad_uvs,
                "texture coordinates that are not finite set to 0",
            ),
            (
                self.unnamed_material_faces,
                "faces without a material given the default grey",
            ),
            (self.fanned_faces, "large dented faces cut into a plain fan"),
            (self.points_and_lines, "points and lines left out"),
        ]
    }
}

/// One line: `3 faces without area left out, 1 unusable normals recomputed`.
impl fmt::Display for LoadNotes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut between = "";
        for (count, what) in self.entries() {
            if count > 0 {
                write!(f, "{between}{count} {what}")?;
                between = ", ";
            }
        }
        Ok(())
    }
}
