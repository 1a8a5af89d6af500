//! Meshes and their materials.

use super::pixel;
use shearwater_shared::scene::{self, references};
use shearwater_tracer::load::load_mesh;
use std::sync::Arc;

/// What stands between the OBJ and the MTL of an input.
const BETWEEN: &[u8] = b"\n===\n";
/// A picture of one texel, for every texture.
const TEXTURE: &[u8] = include_bytes!("../../../scenes/checks/assets/white.png");
/// Libraries and textures that are looked up; more names teach nothing.
const FILES_MAX: usize = 20;

/// An OBJ, and behind a line of three equals signs the MTL that each of its
/// libraries is. An even length asks for smooth normals, an odd one for flat ones.
pub fn obj_mtl(data: &[u8]) {
    let at = data.windows(BETWEEN.len()).position(|w| w == BETWEEN);
    let (obj, mtl) = at.map_or((data, &b""[..]), |at| {
        (&data[..at], &data[at + BETWEEN.len()..])
    });
    let mut assets = pixel::assets(&[("m.obj", obj)]);
    // What a client would send along.
    let libraries = references::obj_libraries(obj);
    let textures = references::mtl_textures(mtl);
    if libraries.len() > FILES_MAX || textures.len() > FILES_MAX {
        return;
    }
    for library in &libraries {
        let library = references::resolve("m.obj", library);
        for texture in &textures {
            let texture = references::resolve(&library, texture);
            assets.entry(texture).or_insert_with(|| TEXTURE.into());
        }
        let mtl: Arc<[u8]> = mtl.into();
        assets.entry(library).or_insert(mtl);
    }
    let flat = data.len() % 2 == 1;
    let normals = if flat { "flat" } else { "smooth" };
    let scene = format!(
        r#"{{
            "version": 1, "name": "mesh", "image": {{ "width": 8, "height": 8 }},
            "camera": {{ "position_m": [0.1, 0.2, 5], "target_m": [0, 0, 0], "vertical_fov_deg": 40 }},
            "sky": {{ "type": "constant", "radiance": [1, 1, 1] }},
            "meshes": {{ "m": {{ "file": "m.obj", "normals": "{normals}" }} }},
            "instances": [{{ "mesh": "m" }}, {{ "mesh": "m", "rotate_deg": [0, 90, 0] }}]
        }}"#
    );
    let scene = scene::parse(scene.as_bytes()).expect("ours");
    if let Ok((mesh, _)) = load_mesh("m.obj", &scene.meshes["m"], &assets) {
        check(&mesh);
    }
    let needs_tables = [b"Pr", b"Pm"]
        .iter()
        .any(|word| mtl.windows(2).any(|w| w == *word));
    if needs_tables && !pixel::may_need_tables(data) {
        return;
    }
    if let Err(error) = pixel::render(&scene, &assets, 0) {
        // Whoever bundles a scene and whoever builds it mean the same files.
        let text = error.to_string();
        assert!(!text.contains("is missing"), "{text}");
    }
}

/// What the rest of the tracer takes for granted.
fn check(mesh: &shearwater_tracer::load::LoadedMesh) {
    let vertices = mesh.positions.len();
    assert_eq!(mesh.normals.len(), vertices);
    assert!(mesh.uvs.is_empty() || mesh.uvs.len() == vertices);
    assert!(mesh.positions.iter().all(|p| p.is_finite()));
    assert!(mesh.uvs.iter().all(|uv| uv.is_finite()));
    assert!(mesh.normals.iter().all(|n| n.is_normalized()));
    assert!(!mesh.triangles.is_empty());
    assert_eq!(mesh.material_of.len(), mesh.triangles.len());
    let mut corners = mesh.triangles.as_flattened().iter();
    assert!(corners.all(|&corner| (corner as usize) < vertices));
    let mut materials = mesh.material_of.iter();
    assert!(materials.all(|&m| usize::from(m) < mesh.materials.len()));
    assert_eq!(mesh.material_lines.len(), mesh.materials.len());
}
