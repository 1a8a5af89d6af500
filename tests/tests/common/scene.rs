//! A small scene with one of everything, written where a test wants it.

use std::path::{Path, PathBuf};

/// Picture size and samples of [`write`]: 8 tiles of 2 blocks, so that leases,
/// kills and restarts fall into the middle of it.
pub(crate) const WIDTH: u32 = 256;
/// See [`WIDTH`].
pub(crate) const HEIGHT: u32 = 128;
/// See [`WIDTH`].
pub(crate) const SAMPLES: u32 = 256;

const SCENE: &str = r#"{
  "version": 1,
  "name": "small",
  "image": { "width": WIDTH, "height": HEIGHT },
  "job": { "samples": SAMPLES },
  "camera": {
    "position_m": [3, 2, 6],
    "target_m": [0, 0.7, 0],
    "vertical_fov_deg": 35,
    "shutter_s": 0.02
  },
  "materials": { "red": { "type": "ggx", "base_color": [0.8, 0.1, 0.05], "roughness": 0.4 } },
  "meshes": { "cube": { "file": "models/cube.obj", "normals": "flat" } },
  "instances": [
    { "mesh": "cube", "translate_m": [0, 0.8, 0], "rotate_deg": [10, 30, 0] },
    { "mesh": "cube", "translate_m": [-2, 0.5, -1], "scale": [0.5, 0.8, 0.5], "material": "red" }
  ],
  "sky": { "type": "constant", "radiance": [0.4, 0.55, 0.8] },
  "sun": { "azimuth_deg": 40, "elevation_deg": 30, "angular_radius_deg": 0.5, "radiance": [9000, 8000, 6000] },
  "water": {
    "type": "tessendorf", "grid": 32, "tile_m": 20, "wind_speed_mps": 6, "cutoff_m": 0.5,
    "velocity_mps": [1, 2]
  },
  "clouds": [{
    "type": "particles", "formation": {"type": "radial",
      "centre_m": [1, 0, -3], "radii_m": [1, 0.4, 0.6], "direction": [1, 0.2, 0], "length_m": 2},
    "count": 12, "particle_radius_m": [0.2, 0.5], "opacity": [0.2, 0.7], "seed": 3
  }]
}
"#;

const CUBE: &str = "\
mtllib cube.mtl
v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1
usemtl paint
f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 1 5 8 4
";

const PAINT: &str = "newmtl paint\nKd 0.7 0.6 0.3\n";

/// Write the scene into `folder`; the path of its scene.json.
pub(crate) fn write(folder: &Path) -> PathBuf {
    let models = folder.join("models");
    std::fs::create_dir_all(&models).expect("folder");
    std::fs::write(models.join("cube.obj"), CUBE).expect("cube.obj");
    std::fs::write(models.join("cube.mtl"), PAINT).expect("cube.mtl");
    let scene = SCENE
        .replace("WIDTH", &WIDTH.to_string())
        .replace("HEIGHT", &HEIGHT.to_string())
        .replace("SAMPLES", &SAMPLES.to_string());
    let path = folder.join("scene.json");
    std::fs::write(&path, scene).expect("scene.json");
    path
}

/// Change the text of a file.
pub(crate) fn edit(path: &Path, from: &str, to: &str) {
    let text = std::fs::read_to_string(path).expect("file");
    assert!(text.contains(from), "`{from}` in {}", path.display());
    std::fs::write(path, text.replace(from, to)).expect("file");
}
