//! `shearwater export` writes every file that it names.

mod common;

use common::process::run;
use common::scene;
use std::path::Path;

#[test]
fn an_export_has_what_another_renderer_needs() {
    let place = tempfile::tempdir().expect("folder");
    let (scene, folder) = (scene::write(place.path()), place.path().join("export"));
    let (from, to) = (scene.as_os_str(), folder.as_os_str());
    let said = run([
        "export".as_ref(),
        from,
        "-o".as_ref(),
        to,
        "--json".as_ref(),
    ]);
    let files = said.ok().json()["files"].clone();
    let files: Vec<&str> = files
        .as_array()
        .expect("files")
        .iter()
        .filter_map(|f| f.as_str())
        .collect();
    assert!(
        files.iter().all(|file| Path::new(file).is_file()),
        "{files:?}"
    );

    let text = std::fs::read(folder.join("export.json")).expect("export.json");
    let scene: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
    let mesh = &scene["meshes"][0];
    let ply = std::fs::read(folder.join(mesh["file"].as_str().expect("a name"))).expect("a PLY");
    assert!(ply.starts_with(b"ply\nformat binary_little_endian 1.0\n"));
    // A cube, and what only the scene's water, clouds and lights have.
    assert_eq!(mesh["triangles"], 12);
    let rows = scene["particles"]["count"].as_u64().expect("a count");
    let bytes = std::fs::metadata(folder.join("particles.f32"))
        .expect("particles")
        .len();
    assert!(rows > 0 && bytes == rows * 10 * 4);
    assert_eq!(scene["water"]["normals"]["points"], 32);
    assert_eq!(scene["sun"]["angular_radius_deg"], 0.5);
    assert!(folder.join("sky.exr").is_file());
}
