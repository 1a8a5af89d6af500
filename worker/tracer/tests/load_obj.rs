//! OBJ and MTL as the world writes them, and as nobody should.
#![allow(missing_docs, clippy::unwrap_used)]

use glam::{Vec2, Vec3};
use shearwater_shared::scene::{Mesh, Normals, SceneError};
use shearwater_tracer::load::{Assets, LoadNotes, LoadedMesh, load_mesh, resolve_materials};
use std::collections::BTreeMap;
use std::sync::Arc;

fn mesh(normals: Normals, crease_angle_deg: f64) -> Mesh {
    Mesh {
        file: "m/a.obj".to_owned(),
        normals,
        crease_angle_deg,
        materials: BTreeMap::new(),
    }
}

fn assets(files: &[(&str, &str)]) -> Assets {
    files
        .iter()
        .map(|(name, text)| ((*name).to_owned(), Arc::from(text.as_bytes())))
        .collect()
}

fn load_files(files: &[(&str, &str)]) -> Result<(LoadedMesh, LoadNotes), SceneError> {
    load_mesh("m/a.obj", &mesh(Normals::Smooth, 40.0), &assets(files))
}

fn load(obj: &str) -> Result<(LoadedMesh, LoadNotes), SceneError> {
    load_files(&[("m/a.obj", obj)])
}

fn fails(obj: &str, path: &str, message: &str) {
    let error = load(obj).unwrap_err();
    assert_eq!(
        (error.file.as_str(), error.path.as_str()),
        ("m/a.obj", path),
        "{error}"
    );
    assert!(
        error.message.contains(message),
        "{error} should say {message}"
    );
}

/// The corners of a cube of side 2, its faces outwards, as quads.
const CUBE: &str = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 1 5 8 4\n";

fn area(mesh: &LoadedMesh) -> f32 {
    let corner = |i: u32| mesh.positions[i as usize];
    mesh.triangles
        .iter()
        .map(|&[a, b, c]| {
            (corner(b) - corner(a))
                .cross(corner(c) - corner(a))
                .length()
                / 2.0
        })
        .sum()
}

#[test]
fn a_cube_of_quads_is_faceted_or_round_by_the_crease_angle() {
    let files = assets(&[("m/a.obj", CUBE)]);
    let at = |crease| {
        load_mesh("m/a.obj", &mesh(Normals::Smooth, crease), &files)
            .unwrap()
            .0
    };
    let sharp = at(89.0);
    assert_eq!((sharp.triangles.len(), sharp.positions.len()), (12, 24));
    assert!((area(&sharp) - 24.0).abs() < 1e-5);
    for normal in &sharp.normals {
        assert!((normal.abs().max_element() - 1.0).abs() < 1e-6, "{normal}");
    }
    let round = at(90.0);
    assert_eq!(round.positions.len(), 8);
    for (position, normal) in round.positions.iter().zip(&round.normals) {
        // Weighted by angle, the three faces of a corner count the same,
        // however their quads were cut.
        assert!(
            (*normal - position.normalize()).length() < 1e-6,
            "{position} {normal}"
        );
    }
    let flat = load_mesh("m/a.obj", &mesh(Normals::Flat, 180.0), &files)
        .unwrap()
        .0;
    assert_eq!(flat.normals, sharp.normals);
}

#[test]
fn line_ends_signs_continuations_and_parts_do_not_matter() {
    let plain = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.25 0.5\nvn 0 0 2\nf 1/1/1 2/1/1 3/1/1\n";
    let odd = "\u{feff}# café\r\no My Thing\r\n  v 0 0 0 1\r\nv\t1 0 \\\r\n 0\r\nv 0 1 0 0.1 0.2 0.3\r\n\
        vt 0.25 0.5 9\r\nvn 0 0 2\r\ng a b\r\ns off\r\nf -3/-1/-1 -2/-1/+1 \\\r\n -1/-1/-1 # f\r\nunknown x";
    let (mesh, notes) = load(plain).unwrap();
    let (other, _) = load(odd).unwrap();
    assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(mesh.normals, [Vec3::Z; 3]);
    assert_eq!(mesh.uvs, [Vec2::new(0.25, 0.5); 3]);
    assert!(mesh.has_uv);
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
    assert_eq!(
        (&mesh.materials[..], &mesh.material_of[..]),
        (&["".to_owned()][..], &[0][..])
    );
    assert_eq!(notes.unnamed_material_faces, 1);
    assert_eq!(mesh, other);
}

#[test]
fn faces_with_and_without_parts_mix() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0.5\nvn 1 0 0\nf 1 2 3\nf 2/1/1 4/1/1 3/1/1\n\
        f 3//1 2//1 1//1\nf 3/1 2/1 4\nf 2/1 4/1 3/1\nf 1//1 2 3\n";
    let (mesh, _) = load(text).unwrap();
    let corner = |t: usize, k: usize| mesh.triangles[t][k] as usize;
    assert_eq!(mesh.triangles.len(), 6);
    for k in 0..3 {
        let uv = |t| mesh.uvs[corner(t, k)];
        assert_eq!(
            [0, 1, 2, 3, 4].map(uv),
            [0.0, 0.5, 0.0, 0.0, 0.5].map(|u| Vec2::new(u, 0.0))
        );
        let normal = |t| mesh.normals[corner(t, k)];
        assert_eq!(
            [0, 1, 2, 4].map(normal),
            [Vec3::Z, Vec3::X, Vec3::X, Vec3::Z]
        );
        assert_eq!([3, 5].map(normal), [Vec3::Z; 2]);
    }
}

#[test]
fn dented_polygons_are_cut_inside() {
    // An L of area 3: a fan from its first corner would cover more.
    let text = "v 2 1 0\nv 2 0 0\nv 0 0 0\nv 0 2 0\nv 1 2 0\nv 1 1 0\nf 1 2 3 4 5 6\n";
    let (mesh, _) = load(text).unwrap();
    assert_eq!(mesh.triangles.len(), 4);
    assert!((area(&mesh) - 3.0).abs() < 1e-6, "{}", area(&mesh));
    assert!(mesh.normals.iter().all(|n| *n == Vec3::NEG_Z));
}

#[test]
fn what_is_broken_is_dropped_counted_and_leaves_no_trace() {
    let broken = format!(
        "v nan 0 0\nv 0 inf 0\nv 0 0 -nan(ind)\nv 1e999 0 0\nv 1 1.#QNAN 0\n{}\
         f -1 -2 1\nf 2 -1 -2 -3\nf -1 -1 -2\nf -8 -7 -7\nf 9 9 9\nf -1 -2\nl 1 2\np 1\n\
         v 0 0 0\nv 1 1 1\nv 2 2 2\nf -1 -2 -3\nf 3 -1 -2\nf 4 -1 -2\nf 5 -1 -2\n",
        CUBE.replace(
            "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 1 5 8 4\n",
            "f 6 9 8 7\nf 10 11 12 13\nf 6 7 11 10\nf 8 9 13 12\nf 7 8 12 11\nf 6 10 13 9\n"
        )
    );
    let (mesh, notes) = load(&broken).unwrap();
    let (clean, _) = load(CUBE).unwrap();
    assert_eq!(mesh, clean);
    assert_eq!(
        (notes.non_finite_vertices, notes.non_finite_faces),
        (5, 5),
        "{notes}"
    );
    assert_eq!(
        (notes.degenerate_faces, notes.points_and_lines),
        (5, 2),
        "{notes}"
    );
    assert!(
        notes.to_string().contains("5 faces without area left out"),
        "{notes}"
    );
}

#[test]
fn bad_normals_are_recomputed_and_bad_uvs_zero() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt nan 1\nvt 1 1\nvn 0 0 0\nvn nan 0 1\nvn 0 1 1e-30\n\
        f 1/1/1 2/2/2 3/2/3\n";
    let (mesh, notes) = load(text).unwrap();
    assert_eq!(mesh.normals, [Vec3::Z, Vec3::Z, Vec3::new(0.0, 1.0, 1e-30)]);
    assert_eq!(mesh.uvs, [Vec2::ZERO, Vec2::ONE, Vec2::ONE]);
    assert_eq!((notes.bad_normals, notes.bad_uvs), (2, 1));
}

#[test]
fn normals_are_unit_length_at_every_scale() {
    for scale in [1e-18_f32, 1e-6, 1.0, 1e6, 1e18] {
        let text = format!("v 0 0 0\nv {scale} 0 0\nv 0 {scale} {scale}\nf 1 2 3\n");
        let (mesh, notes) = load(&text).unwrap();
        assert_eq!(notes.degenerate_faces, 0);
        assert!((mesh.normals[0].length() - 1.0).abs() < 1e-6, "{scale}");
    }
}

#[test]
fn errors_name_the_line() {
    fails(
        "v 0 0 0\nf 1 2 3\n",
        "line 2",
        "vertex 2 in a face: only 1 stand above it",
    );
    fails("v 0 0 0\nf 0 1 1\n", "line 2", "vertex 0 in a face");
    fails("v 0 0 0\nf -2 1 1\n", "line 2", "vertex -2 in a face");
    fails(
        "v 0 0 0\n\\\n\nf 1/1 1 1\n",
        "line 4",
        "texture coordinate 1",
    );
    fails(
        "v 0 0 0\nf 1//1 1 1\n",
        "line 2",
        "normal 1 in a face: only 0",
    );
    fails(
        "v 0 0 0\nvt 0\nvn 0 0 1\nf 1/1/1/1 1 1\n",
        "line 4",
        "1/1/1/1",
    );
    fails(
        "v 0 0 0\nf 99999999999999999999 1 1\n",
        "line 2",
        "expected a whole number",
    );
    fails(
        "v 0 0 0\nf 999999999999999999 1 1\n",
        "line 2",
        "only 1 stand above it",
    );
    fails(
        "v 0 0 0\nf -999999999999999999 1 1\n",
        "line 2",
        "only 1 stand above it",
    );
    fails("v 0 0 0\nf a b c\n", "line 2", "`a` in a face");
    fails("v 0 0 0\nf /1 1 1\n", "line 2", "expected v, v/vt");
    fails("v 0 0\n", "line 1", "2 numbers after `v`: expected 3");
    fails(
        "# x\nv 0 zero 0\n",
        "line 2",
        "three decimal numbers after `v`",
    );
    fails("v 0 0 0 0\n", "line 1", "weight other than 0");
    fails("vt x\n", "line 1", "decimal numbers after `vt`");
    fails("vn 1 2\n", "line 1", "expected 3");
    fails("usemtl\n", "line 1", "`usemtl` without a name");
    fails("", ".", "no triangles: expected an OBJ file with faces");
    fails(
        "v nan 0 0\nf 1 1 1\n",
        ".",
        "no triangles (1 vertices that are not finite",
    );
    let error = load_files(&[]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "m/a.obj: .: the mesh file is missing from the scene's files"
    );
    let error = load_mesh(
        "m/a.obj",
        &mesh(Normals::Smooth, 40.0),
        &BTreeMap::from([("m/a.obj".to_owned(), Arc::from(&b"v 0 0 \xff\nf 1 1 1"[..]))]),
    );
    assert!(
        error
            .unwrap_err()
            .to_string()
            .contains("m/a.obj: line 1: expected text")
    );
}

/// Every pair of corners at a point is compared, so their number is bounded:
/// beyond it a corner keeps its triangle's normal.
#[test]
fn a_fan_of_many_thousand_corners_is_faceted() {
    use std::fmt::Write;
    let mut text = String::from("v 0 0 1\n");
    for i in 0..60_000 {
        let angle = f64::from(i) * 1e-4;
        writeln!(text, "v {} {} 0", libm::cos(angle), libm::sin(angle)).unwrap();
    }
    for i in 2..60_000 {
        writeln!(text, "f 1 {i} {}", i + 1).unwrap();
    }
    let (mesh, _) = load(&text).unwrap();
    assert_eq!(mesh.triangles.len(), 59_998);
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| mesh.positions[i as usize].as_dvec3());
        let own = (b - a).cross(c - a).normalize().as_vec3();
        assert!((mesh.normals[triangle[0] as usize] - own).length() < 1e-6);
    }
}

#[test]
fn random_damage_never_panics() {
    let obj = format!(
        "mtllib a.mtl\nvt 0 1\nvn 0 0 1\n{CUBE}usemtl a b\nf 1/1/1 2/1/1 3/1/1 4//1\nf -1 -2 -3\n"
    );
    let mtl = "newmtl a b\nKd 0.1 0.2 0.3\nKs 1 1 1\nNs 3\nmap_Kd -o 1 2 3 x.png\n";
    let mut state = 1_u64;
    let mut random = move |below: usize| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let letters = b"0123456789-+./\\ \r\nvfntuse#\xff\0eia";
    let mut loaded = 0;
    for _ in 0..20_000 {
        let mut texts = [obj.clone().into_bytes(), mtl.as_bytes().to_vec()];
        for _ in 0..=random(3) {
            let text = &mut texts[usize::from(random(4) == 0)];
            let (at, letter) = (random(text.len()), letters[random(letters.len())]);
            match random(4) {
                0 => text[at] = letter,
                1 => text.insert(at, letter),
                2 if text.len() > 1 => drop(text.remove(at)),
                _ => text.truncate(at.max(1)),
            }
        }
        let [obj, mtl] = texts.map(|text| Arc::from(text.as_slice()));
        let files = BTreeMap::from([("m/a.obj".to_owned(), obj), ("m/a.mtl".to_owned(), mtl)]);
        let described = mesh(Normals::Smooth, 40.0);
        if let Ok((mesh, _)) = load_mesh("m/a.obj", &described, &files) {
            loaded += 1;
            let vertices = mesh.positions.len();
            assert_eq!(vertices, mesh.normals.len());
            assert_eq!(mesh.triangles.len(), mesh.material_of.len());
            assert!(mesh.uvs.len() == if mesh.has_uv { vertices } else { 0 });
            assert!(
                mesh.triangles
                    .as_flattened()
                    .iter()
                    .all(|&i| (i as usize) < vertices)
            );
            assert!(
                mesh.material_of
                    .iter()
                    .all(|&m| usize::from(m) < mesh.materials.len())
            );
            assert!(mesh.positions.iter().all(|p| p.is_finite()));
            assert!(mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-5));
            let _ = resolve_materials("m/a.obj", &described, &mesh, &BTreeMap::new(), &files);
        }
    }
    assert!(loaded > 1000, "{loaded}");
}
