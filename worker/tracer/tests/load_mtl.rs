//! Materials of MTL files, and which material a name in an OBJ means.
#![allow(missing_docs, clippy::unwrap_used)]

use shearwater_shared::scene::{LambertMaterial, Material, Mesh, Normals, SceneError};
use shearwater_tracer::load::{
    Assets, LoadNotes, LoadedMesh, UNNAMED_MATERIAL, load_mesh, resolve_materials,
};
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

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[test]
fn mtl_materials_become_ours() {
    let obj = format!(
        "mtllib my lib.mtl ../b.mtl\r\n{TRIANGLE}usemtl Body 1\r\nf 1 2 3\r\nusemtl gloss\nf 1 2 3\n\
        usemtl metal\nf 1 2 3\nusemtl Body 1\nf 3 2 1\nusemtl grey\nf 1 2 3\n"
    );
    let mtl = "# c\nKd 9 9 9\nnewmtl Body 1\r\nKd 0.25 0.5 1\r\nmap_Kd -s 1 1 1 ..\\tex\\my livery.png\r\nnewmtl gloss\n\
        Kd 1 0.5 0.5\nKs 1 1 1\nNs 50\nillum 2\n";
    let other = "newmtl metal\nKd 0.5\nPr 0.2\nPm 1\nnewmtl Body 1\nKd 0 0 0\nnewmtl grey\nKs 1 1 1\nillum 1";
    let files = [
        ("m/a.obj", obj.as_str()),
        ("m/my lib.mtl", mtl),
        ("b.mtl", other),
        ("tex/my livery.png", ""),
    ];
    let described = mesh(Normals::Smooth, 40.0);
    let (loaded, notes) = load_files(&files).unwrap();
    assert!(notes.is_empty(), "{notes}");
    assert_eq!(loaded.materials, ["Body 1", "gloss", "metal", "grey"]);
    assert_eq!(loaded.material_of, [0, 1, 2, 0, 3]);
    let resolve = |files: &[(&str, &str)], scene: &BTreeMap<String, Material>| {
        resolve_materials("m/a.obj", &described, &loaded, scene, &assets(files))
    };
    let none = BTreeMap::new();
    let ours = resolve(&files, &none).unwrap();
    let Material::Lambert(body) = &ours[0] else {
        panic!("{ours:?}")
    };
    assert_eq!(body.albedo, [0.25, 0.5, 1.0]);
    assert_eq!(body.albedo_texture.as_deref(), Some("tex/my livery.png"));
    let Material::Phong(gloss) = &ours[1] else {
        panic!("{ours:?}")
    };
    assert_eq!(
        (gloss.kd, gloss.ks, gloss.exponent),
        ([0.5, 0.25, 0.25], [0.5; 3], 50.0)
    );
    let Material::Ggx(metal) = &ours[2] else {
        panic!("{ours:?}")
    };
    assert_eq!(
        (metal.base_color, metal.roughness, metal.metalness()),
        ([0.5; 3], 0.2, 1.0)
    );
    assert!(matches!(&ours[3], Material::Lambert(m) if m.albedo == [0.5; 3]));

    // The scene's own material of that name comes first, a mapping before it.
    let scene = BTreeMap::from([
        ("gloss".to_owned(), ours[2].clone()),
        ("x".to_owned(), ours[3].clone()),
    ]);
    assert_eq!(resolve(&files, &scene).unwrap()[1], ours[2]);
    let mut mapped = described.clone();
    mapped.materials.insert("gloss".to_owned(), "x".to_owned());
    let got = resolve_materials("m/a.obj", &mapped, &loaded, &scene, &assets(&files)).unwrap();
    assert_eq!(got[1], ours[3]);

    let error = resolve(&files[..3], &none).unwrap_err();
    assert_eq!(
        error.to_string(),
        "tex/my livery.png: .: the texture is missing; line 5 of m/my lib.mtl names it"
    );
    let error = load_files(&files[..2]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "b.mtl: .: the MTL file is missing; line 1 of m/a.obj names it"
    );
}

#[test]
fn unknown_and_absent_materials() {
    let obj = format!("{TRIANGLE}f 1 2 3\nusemtl never\nusemtl lost\nf 1 2 3\n");
    let files = assets(&[("m/a.obj", obj.as_str())]);
    let described = mesh(Normals::Smooth, 40.0);
    let (loaded, notes) = load_mesh("m/a.obj", &described, &files).unwrap();
    assert_eq!(loaded.materials, ["never", "lost", UNNAMED_MATERIAL]);
    assert_eq!(loaded.material_of, [2, 1]);
    assert_eq!(notes.unnamed_material_faces, 1);
    let clay: Material = Material::Lambert(LambertMaterial {
        albedo: [0.1; 3],
        albedo_texture: None,
    });
    let mut scene = BTreeMap::from([("clay".to_owned(), clay.clone())]);
    let error = resolve_materials("m/a.obj", &described, &loaded, &scene, &files).unwrap_err();
    assert_eq!(
        error.to_string(),
        "m/a.obj: line 6: `lost`: no material of that name; the scene has `clay`, the MTL files have none"
    );
    scene.insert("lost".to_owned(), clay.clone());
    let ours = resolve_materials("m/a.obj", &described, &loaded, &scene, &files).unwrap();
    assert_eq!(ours[1], clay);
    assert!(matches!(&ours[2], Material::Lambert(m) if m.albedo == [0.5; 3]));
}

#[test]
fn hostile_mtl_files_are_errors() {
    let obj = format!("mtllib a.mtl\n{TRIANGLE}usemtl a\nf 1 2 3\n");
    for (mtl, message) in [
        (
            "newmtl a\nKd 0.5 0.5\n",
            "line 2: `Kd 0.5 0.5`: expected one or three numbers",
        ),
        ("newmtl a\nKd\n", "line 2"),
        ("newmtl a\nKd spectral x.rfl\n", "line 2"),
        (
            "newmtl a\nKd nan 0 0\n",
            "line 2: `Kd nan`: expected a number",
        ),
        ("newmtl a\n\nNs x\n", "line 3: `Ns x`"),
        ("newmtl\n", "line 1: `newmtl` without a name"),
    ] {
        let error = load_files(&[("m/a.obj", &obj), ("m/a.mtl", mtl)]).unwrap_err();
        assert_eq!(error.file, "m/a.mtl");
        assert!(error.to_string().contains(message), "{error}");
    }
    // What is not used may be anything.
    let (loaded, _) = load_files(&[
        ("m/a.obj", &obj),
        ("m/a.mtl", "newmtl a\nKe x\nmap_Kd\nmap_Bump\n\u{0}"),
    ])
    .unwrap();
    assert_eq!(loaded.mtl["a"].map_kd, None);
}
