//! Triangles as binary PLY (Turk 1994, "The PLY Polygon File Format").

use glam::{Vec2, Vec3};

/// Triangles with what shading needs; one normal and one `uv` for each position.
#[derive(Clone, Debug, Default)]
pub(super) struct Faces {
    pub(super) positions: Vec<Vec3>,
    pub(super) normals: Vec<Vec3>,
    pub(super) uvs: Vec<Vec2>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// The file: little endian, eight floats a vertex, three indices a face.
pub(super) fn ply(faces: &Faces) -> Vec<u8> {
    let mut file = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\n\
         property float x\nproperty float y\nproperty float z\n\
         property float nx\nproperty float ny\nproperty float nz\n\
         property float u\nproperty float v\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        faces.positions.len(),
        faces.triangles.len()
    )
    .into_bytes();
    let vertices = faces.positions.iter().zip(&faces.normals).zip(&faces.uvs);
    for ((p, n), uv) in vertices {
        for value in [p.x, p.y, p.z, n.x, n.y, n.z, uv.x, uv.y] {
            file.extend(value.to_le_bytes());
        }
    }
    for triangle in &faces.triangles {
        file.push(3);
        for index in triangle {
            file.extend(index.to_le_bytes());
        }
    }
    file
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// What follows the header.
    pub(in super::super) fn body(file: &[u8]) -> &[u8] {
        let end = b"end_header\n";
        let at = file.windows(end.len()).position(|w| w == end);
        &file[at.expect("a header") + end.len()..]
    }

    /// Float number `i` of a body.
    pub(in super::super) fn float(body: &[u8], i: usize) -> f32 {
        f32::from_le_bytes(body[4 * i..4 * i + 4].try_into().expect("four bytes"))
    }

    #[test]
    fn header_and_body_agree() {
        let faces = Faces {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(1.0, 2.0, 3.0)],
            normals: vec![Vec3::Z; 4],
            uvs: vec![Vec2::new(0.25, 0.5); 4],
            triangles: vec![[0, 1, 2], [1, 2, 3]],
        };
        let file = ply(&faces);
        let text = String::from_utf8_lossy(&file[..file.len() - body(&file).len()]).into_owned();
        assert!(text.contains("element vertex 4\n") && text.contains("element face 2\n"));
        let body = body(&file);
        assert_eq!(body.len(), 4 * 32 + 2 * 13);
        assert_eq!(float(body, 3 * 8 + 2), 3.0);
        assert_eq!(float(body, 7), 0.5);
        assert_eq!(body[4 * 32 + 13 + 1..][..4], 1_u32.to_le_bytes());
    }
}
