//! scene.json: read, checked, written again, and if it is small, built and looked at.

use super::pixel;
use serde_json::Value;
use shearwater_shared::scene::{
    self, Cloud, Material, RouletteRule, SceneDescription, Sky, VolumeMethod, VolumeShape, Water,
};

/// Bounds of what is built: a scene may be large and right, and then only takes time.
const GRID_MAX: u32 = 64;
const PARTS_MAX: u32 = 2_000;
const VOXELS_SIDE_MAX: u32 = 24;
const VOLUMES_MAX: usize = 4;
const MESHES_MAX: usize = 8;
const INSTANCES_MAX: usize = 100;
/// Longest way through a volume, in mean free paths and in steps.
const WAY_MAX: f64 = 300.0;

/// The files that a scene finds beside it.
const FILES: &[(&str, &[u8])] = &[
    ("a.obj", b"mtllib a.mtl\nv -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0.5 1\nvt 0 0\nvt 1 1\nusemtl m\nf 1/1 2/2 3/1 4/2\nusemtl n\nf 4 3 2\n"),
    ("a.mtl", b"newmtl m\nKd 0.5 0.4 0.3\nmap_Kd a.png\nnewmtl n\nKs 0.4\nNs 20\n"),
    ("a.png", include_bytes!("../../../scenes/checks/assets/hot.png")),
    ("a.vol", b"VOL\x03\x01\0\0\0\x02\0\0\0\x01\0\0\0\x01\0\0\0\x01\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x80\x3f\0\0\0\x40"),
];

/// The text of a scene.json.
pub fn scene(data: &[u8]) {
    let Ok(scene) = scene::parse(data) else {
        return;
    };
    let _ = scene.doubts();
    let written = serde_json::to_value(&scene).expect("what was read can be written");
    match scene::parse(written.to_string().as_bytes()) {
        Ok(again) => {
            let again = serde_json::to_value(&again).expect("the same");
            assert!(is_same(&written, &again), "{written} {again}");
        }
        // A number at the end of its range may be read as the next one.
        Err(error) => assert!(error.message.contains("expected"), "{error}"),
    }
    if is_small(&scene) && (!needs_tables(&scene) || pixel::may_need_tables(data)) {
        let last = scene.animation.map_or(0, |animation| animation.frames - 1);
        let assets = pixel::assets(FILES);
        for frame in [0, last] {
            if pixel::render(&scene, &assets, frame).is_err() || frame == last {
                break;
            }
        }
    }
}

/// Whether two scenes are equal but for the last bit of a number: serde_json reads
/// some decimals as the neighbour of the nearest double.
fn is_same(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => {
            let (x, y) = (a.as_f64().unwrap_or(0.0), b.as_f64().unwrap_or(0.0));
            a == b || (x - y).abs() <= 4.0 * f64::EPSILON * x.abs()
        }
        (Value::Array(a), Value::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| is_same(a, b))
        }
        (Value::Object(a), Value::Object(b)) => {
            let values = a.iter().zip(b);
            a.len() == b.len()
                && values
                    .into_iter()
                    .all(|(a, b)| a.0 == b.0 && is_same(a.1, b.1))
        }
        _ => a == b,
    }
}

fn needs_tables(scene: &SceneDescription) -> bool {
    let mut materials = scene.materials.values();
    scene.water.is_some() || materials.any(|m| matches!(m, Material::Ggx(_)))
}

fn is_small(scene: &SceneDescription) -> bool {
    let mut parts = 0u32;
    let mut volumes = 0;
    for cloud in &scene.clouds {
        match cloud {
            Cloud::Particles(cloud) => parts = parts.saturating_add(cloud.count),
            Cloud::Sprites(cloud) => parts = parts.saturating_add(cloud.count),
            Cloud::Volume(cloud) => {
                volumes += 1;
                let longest = cloud.shape.longest_m();
                let is_coarse = match &cloud.shape {
                    VolumeShape::Ellipsoid(shape) => shape.resolution <= VOXELS_SIDE_MAX,
                    VolumeShape::Grid(_) => true,
                };
                let steps = match &cloud.method {
                    VolumeMethod::Tracking(_) => 0.0,
                    VolumeMethod::March(march) => longest / march.step_m,
                };
                if !is_coarse || longest * cloud.sigma_t_per_m > WAY_MAX || steps > WAY_MAX {
                    return false;
                }
            }
        }
    }
    let is_calm = match &scene.water {
        Some(Water::Tessendorf(water)) => water.grid <= GRID_MAX,
        _ => true,
    };
    // A sky from physics takes half a second.
    let is_quick = !matches!(scene.sky, Some(Sky::Atmosphere(_)))
        && scene.sampling.roulette.rule != RouletteRule::None;
    let are_few = scene.meshes.len() <= MESHES_MAX && scene.instances.len() <= INSTANCES_MAX;
    is_calm && is_quick && are_few && parts <= PARTS_MAX && volumes <= VOLUMES_MAX
}
