//! OBJ meshes.

use super::mtl::read_mtl;
use super::normals::{smooth_normals, triangle_normal};
use super::obj_reader::{FaceKind, Named, ObjReader};
use super::triangulate::{Cut, triangulate};
use super::vertices::{Points, Vertices};
use super::{Assets, LoadNotes, MtlMaterial};
use glam::{DVec3, Vec2, Vec3};
use shearwater_shared::scene::references::{LogicalLine, logical_lines, resolve};
use shearwater_shared::scene::{Mesh, Normals, SceneError};
use std::collections::{BTreeMap, HashMap};

/// Name in [`LoadedMesh::materials`] of the faces that stand before any
/// `usemtl`; no file can give this name.
pub const UNNAMED_MATERIAL: &str = "";

/// A mesh as triangles with vertices that are split only where normals or
/// texture coordinates differ.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadedMesh {
    /// Positions in the mesh's own space, finite; one per vertex.
    pub positions: Vec<Vec3>,
    /// Shading normals, unit length; one per vertex.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, finite, v upwards; one per vertex, or none at all.
    pub uvs: Vec<Vec2>,
    /// Vertices of each triangle, counter-clockwise seen from outside; no
    /// triangle has zero area.
    pub triangles: Vec<[u32; 3]>,
    /// Index into `materials` of each triangle.
    pub material_of: Vec<u16>,
    /// Names of the materials as in the OBJ, in the order of first use there;
    /// [`UNNAMED_MATERIAL`] comes last if it is needed.
    pub materials: Vec<String>,
    /// Line of the OBJ where each of `materials` is named first; 0 for unnamed.
    pub material_lines: Vec<usize>,
    /// Materials that the MTL files define, by name.
    pub mtl: BTreeMap<String, MtlMaterial>,
    /// Whether any face has texture coordinates.
    pub has_uv: bool,
}

/// Triangles by point, before vertices are made.
#[derive(Default)]
struct Soup {
    points: Points,
    triangles: Vec<[u32; 3]>,
    material_of: Vec<u16>,
    /// Texture coordinates of each triangle; empty until some are there.
    uvs: Vec<[Vec2; 3]>,
    /// Normals of the file of each triangle, zero where it has none; empty
    /// until some are there.
    normals: Vec<[Vec3; 3]>,
}

/// Read an OBJ and the MTL files that it names.
///
/// `file` is the asset's name; every file comes from `assets`, by name.
///
/// # Errors
/// A missing file, a line that does not parse, an index of nothing, more
/// triangles than allowed, or no triangle at all: file, line and what was
/// expected.
pub fn load_mesh(
    file: &str,
    mesh: &Mesh,
    assets: &Assets,
) -> Result<(LoadedMesh, LoadNotes), SceneError> {
    let bytes = assets.get(file).ok_or_else(|| {
        SceneError::new(file, ".", "the mesh file is missing from the scene's files")
    })?;
    let mut reader = ObjReader::new(file, logical_lines(bytes));
    let models = parse(&mut reader)?;
    let mut notes = reader.notes.clone();
    let named = std::mem::take(&mut reader.materials);
    let mtl = load_libraries(file, &reader.libraries, assets)?;

    let mut soup = Soup::default();
    for model in models {
        add_model(&mut soup, &model.mesh, named.len(), &mut notes);
    }
    if soup.triangles.is_empty() {
        let left_out = if notes.is_empty() {
            String::new()
        } else {
            format!(" ({notes})")
        };
        let message = format!("no triangles{left_out}: expected an OBJ file with faces");
        return Err(SceneError::new(file, ".", message));
    }
    let mut loaded = finish(soup, mesh);
    loaded.mtl = mtl;
    (loaded.materials, loaded.material_lines) = named.into_iter().map(|n| (n.name, n.line)).unzip();
    if notes.unnamed_material_faces > 0 {
        loaded.materials.push(UNNAMED_MATERIAL.to_owned());
        loaded.material_lines.push(0);
    }
    Ok((loaded, notes))
}

/// Let `tobj` read floats and indices.
fn parse<'a, I>(reader: &mut ObjReader<'a, I>) -> Result<Vec<tobj::Model>, SceneError>
where
    I: Iterator<Item = LogicalLine<'a>>,
{
    let options = tobj::LoadOptions {
        single_index: false,
        triangulate: false,
        ignore_points: true,
        ignore_lines: true,
    };
    // The reader announces each kind of face as a material whose name is a
    // number; that number is all that a "library" holds.
    let parsed = tobj::load_obj_buf(reader, &options, |code| {
        let name = code.to_string_lossy().into_owned();
        let number = name.parse().map_err(|_| tobj::LoadError::GenericFailure)?;
        Ok((Vec::new(), HashMap::from([(name, number)])))
    });
    match parsed {
        Ok((models, _)) => Ok(models),
        Err(error) => Err(reader
            .error
            .take()
            .unwrap_or_else(|| reader.fail(describe(error)))),
    }
}

fn describe(error: tobj::LoadError) -> String {
    let expected = match error {
        tobj::LoadError::PositionParseError => "expected three decimal numbers after `v`",
        tobj::LoadError::TexcoordParseError => "expected decimal numbers after `vt`",
        tobj::LoadError::NormalParseError => "expected three decimal numbers after `vn`",
        tobj::LoadError::ScalingByZeroError => "expected a weight other than 0 after `v x y z`",
        tobj::LoadError::ReadError => "expected text",
        _ => "not readable as OBJ",
    };
    expected.to_owned()
}

fn load_libraries(
    file: &str,
    libraries: &[Named],
    assets: &Assets,
) -> Result<BTreeMap<String, MtlMaterial>, SceneError> {
    let mut materials = BTreeMap::new();
    for library in libraries {
        let name = resolve(file, &library.name);
        let Some(bytes) = assets.get(&name) else {
            let message = format!(
                "the MTL file is missing; line {} of {file} names it",
                library.line
            );
            return Err(SceneError::new(name, ".", message));
        };
        read_mtl(&name, bytes, &mut materials)?;
    }
    Ok(materials)
}

/// The arrays of one parsed model with safe access.
struct ModelView<'a> {
    mesh: &'a tobj::Mesh,
    kind: FaceKind,
}

impl ModelView<'_> {
    fn position(&self, corner: usize) -> Vec3 {
        let at = self.mesh.indices.get(corner).map(|&i| i as usize * 3);
        at.and_then(|at| self.mesh.positions.get(at..at + 3))
            .map_or(Vec3::NAN, Vec3::from_slice)
    }

    fn uv(&self, corner: usize) -> Vec2 {
        let at = self
            .mesh
            .texcoord_indices
            .get(corner)
            .map(|&i| i as usize * 2);
        at.and_then(|at| self.mesh.texcoords.get(at..at + 2))
            .map_or(Vec2::ZERO, Vec2::from_slice)
    }

    /// Unit normal of the file, or zero where it is of no use.
    fn normal(&self, corner: usize) -> Vec3 {
        let at = self
            .mesh
            .normal_indices
            .get(corner)
            .map(|&i| i as usize * 3);
        at.and_then(|at| self.mesh.normals.get(at..at + 3))
            .map_or(DVec3::ZERO, |n| Vec3::from_slice(n).as_dvec3())
            .normalize_or_zero()
            .as_vec3()
    }
}

fn add_model(soup: &mut Soup, mesh: &tobj::Mesh, unnamed: usize, notes: &mut LoadNotes) {
    let kind = FaceKind::decode(mesh.material_id.unwrap_or_default());
    let view = ModelView { mesh, kind };
    // Below MATERIALS_MAX, which fits.
    let material = kind.material.unwrap_or(unnamed) as u16;
    notes.non_finite_vertices += mesh
        .positions
        .chunks_exact(3)
        .filter(|p| !p.iter().all(|x| x.is_finite()))
        .count();
    let mut scratch = (Vec::new(), Vec::new());
    let mut start = 0;
    // Without arities every face is a triangle.
    let triangles = mesh.indices.len() / 3;
    let faces = if mesh.face_arities.is_empty() {
        triangles
    } else {
        mesh.face_arities.len()
    };
    for face in 0..faces {
        let corners = mesh.face_arities.get(face).map_or(3, |&n| n as usize);
        add_face(
            soup,
            &view,
            start..start + corners,
            material,
            &mut scratch,
            notes,
        );
        start += corners;
    }
}

fn add_face(
    soup: &mut Soup,
    view: &ModelView<'_>,
    range: std::ops::Range<usize>,
    material: u16,
    (corners, cut): &mut (Vec<DVec3>, Vec<[usize; 3]>),
    notes: &mut LoadNotes,
) {
    corners.clear();
    cut.clear();
    let start = range.start;
    corners.extend(range.map(|corner| view.position(corner).as_dvec3()));
    if !corners.iter().all(|p| p.is_finite()) {
        notes.non_finite_faces += 1;
        return;
    }
    if triangulate(corners, cut) == Cut::Fan {
        notes.fanned_faces += 1;
    }
    for triangle in cut.iter() {
        let at = triangle.map(|k| start + k);
        let shape = at.map(|corner| view.position(corner));
        if triangle_normal(shape) == DVec3::ZERO {
            notes.degenerate_faces += 1;
        } else {
            add_triangle(soup, view, at, shape, material, notes);
        }
    }
}

fn add_triangle(
    soup: &mut Soup,
    view: &ModelView<'_>,
    at: [usize; 3],
    shape: [Vec3; 3],
    material: u16,
    notes: &mut LoadNotes,
) {
    let before = soup.triangles.len();
    soup.triangles.push(shape.map(|p| soup.points.intern(p)));
    soup.material_of.push(material);
    if view.kind.uvs {
        soup.uvs.resize(before, [Vec2::ZERO; 3]);
        soup.uvs.push(at.map(|corner| {
            let uv = view.uv(corner);
            if uv.is_finite() {
                // One bit pattern for both zeros.
                uv + Vec2::ZERO
            } else {
                notes.bad_uvs += 1;
                Vec2::ZERO
            }
        }));
    }
    if view.kind.normals {
        soup.normals.resize(before, [Vec3::ZERO; 3]);
        let normals = at.map(|corner| view.normal(corner));
        notes.bad_normals += normals.iter().filter(|&&n| n == Vec3::ZERO).count();
        soup.normals.push(normals);
    }
}

/// Give every corner its normal and share vertices between equal corners.
fn finish(mut soup: Soup, mesh: &Mesh) -> LoadedMesh {
    let count = soup.triangles.len();
    let points = std::mem::take(&mut soup.points.positions);
    soup.points = Points::default();
    let has_uv = !soup.uvs.is_empty();
    if has_uv {
        soup.uvs.resize(count, [Vec2::ZERO; 3]);
    }
    soup.normals.resize(count, [Vec3::ZERO; 3]);
    let made = match mesh.normals {
        Normals::Flat => soup
            .triangles
            .iter()
            .map(|t| [triangle_normal(t.map(|p| points[p as usize])).as_vec3(); 3])
            .collect(),
        Normals::Smooth if soup.normals.as_flattened().contains(&Vec3::ZERO) => {
            smooth_normals(&points, &soup.triangles, mesh.crease_angle_deg)
        }
        Normals::Smooth => Vec::new(),
    };
    let mut vertices = Vertices::new(points.len(), has_uv);
    for (t, triangle) in soup.triangles.iter_mut().enumerate() {
        for (k, corner) in triangle.iter_mut().enumerate() {
            let given = soup.normals[t][k];
            let normal = match made.get(t) {
                Some(made) if mesh.normals == Normals::Flat || given == Vec3::ZERO => made[k],
                _ => given,
            };
            let uv = soup.uvs.get(t).map_or(Vec2::ZERO, |uvs| uvs[k]);
            *corner = vertices.add(*corner, points[*corner as usize], normal, uv);
        }
    }
    LoadedMesh {
        positions: vertices.positions,
        normals: vertices.normals,
        uvs: vertices.uvs,
        triangles: soup.triangles,
        material_of: soup.material_of,
        has_uv,
        ..LoadedMesh::default()
    }
}
