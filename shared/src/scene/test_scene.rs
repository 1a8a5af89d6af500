//! A scene for tests, and ways to break it.

use crate::scene::parse;
use serde_json::{Value, json};

/// A scene that uses every part of the format.
pub(super) fn full() -> Value {
    json!({
        "version": 1, "name": "all of it",
        "image": {"width": 64, "height": 32}, "job": {"samples": 16},
        "camera": {"position_m": [0, 2, 10], "target_m": [0, 1, 0], "up": [0, 1, 0],
            "vertical_fov_deg": 40, "shutter_s": 0.5, "lens_radius_m": 0.01, "focus_distance_m": 9,
            "velocity_mps": [0, 0, 1], "path": [{"time_s": 0, "offset_m": [0, 1, 0]}, {"time_s": 2, "target_offset_m": [0, 1, 0]}]},
        "materials": {
            "clay": {"type": "lambert", "albedo": [0.5, 0.5, 0.5], "albedo_texture": "tex/clay.png"},
            "gloss": {"type": "phong", "kd": [0.9, 0.5, 0.5], "ks": [0.1, 0.1, 0.1], "exponent": 50},
            "livery": {"roughness": 0.3, "type": "ggx", "metalness": 0.5, "model": "report"},
            "chrome": {"type": "ggx", "roughness": 0.5, "roughness_texture": {"file": "tex/orm.png", "channel": "g"},
                "metalness_texture": {"file": "tex/orm.png", "channel": "b"},
                "conductor": {"n": [1.5, 1, 0.6], "k": [7.8, 6.7, 5.5]},
                "coat": {"weight": 0.5, "roughness": 0.1, "ior": 1.5}},
            "tinted": {"type": "ggx", "roughness": 0.1, "f82": [1, 0.9, 0.8]}
        },
        "meshes": {"plane": {"file": "models/plane.obj", "normals": "flat", "crease_angle_deg": 30,
            "materials": {"Body 1": "livery"}}},
        "animation": {"fps": 2, "frames": 3, "start_s": 1},
        "instances": [{"mesh": "plane", "name": "first", "velocity_mps": [1, 0, 0]}, {"mesh": "plane", "translate_m": [1, 2, 3],
            "rotate_deg": [0, 90, 0], "scale": [1, -1, 2], "material": "clay", "parent": "first", "name": "second",
            "spin": {"axis": [0, 0, 1], "rpm": 1400, "pivot_m": [1, 0, 0]},
            "path": [{"time_s": 0, "offset_m": [1, 0, 0]}, {"time_s": 1, "turn_deg": [0, 90, 0]}]}],
        "sky": {"type": "map", "file": "sky.exr", "rotation_deg": 10, "intensity": 2},
        "sun": {"azimuth_deg": 10, "elevation_deg": 3, "radiance": [9, 8, 7]},
        "water": {"type": "tessendorf", "tile_m": 50, "wind_speed_mps": 8,
            "loop_s": 3, "shutter_fields": 2, "whitecaps": {"choppiness": 1.5}},
        "clouds": [{"type": "particles", "formation": {"type": "radial", "centre_m": [0, 0, 0],
            "radii_m": [1, 1, 1], "direction": [0, 0, 1], "length_m": 5}, "count": 10, "particle_radius_m": [0.1, 0.2], "opacity": [0.1, 0.9]},
            {"type": "sprites", "formation": {"type": "image", "file": "clouds/cumulus.png", "centre_m": [0, 9, 0], "width_m": 20,
            "height_m": 8, "depth_m": 3, "rotate_deg": [0, 30, 0]}, "count": 20, "sprite_radius_m": [0.5, 1], "opacity": [0.1, 0.4], "softness": 0.5},
            {"type": "volume", "shape": {"type": "ellipsoid", "centre_m": [0, 9, 0], "radii_m": [3, 2, 1],
                "edge": 0.4, "resolution": 32, "noise": {"scale_m": 2, "amplitude": 0.9, "coverage": 0.4,
                    "octaves": 4, "lacunarity": 2.1, "gain": 0.6, "seed": 5}}, "sigma_t_per_m": 0.5,
                "albedo": [1, 0.9, 0.8], "g": -0.3, "method": {"type": "march", "step_m": 0.1}},
            {"shape": {"size_m": [1, 2, 3], "type": "grid", "centre_m": [0, 9, 0], "rotate_y_deg": 20,
                "file": "cloud.vol"}, "sigma_t_per_m": 0.5, "type": "volume", "method": {"type": "tracking"}}],
        "sampling": {"sampler": "independent", "sobol_scatterings": 4, "mis": "balance", "map_compensation": false,
            "sky_sampling": "any_sky", "faint_share": 0.1,
            "roulette": {"rule": "albedo", "from": 2, "survival_min": 0.1}},
        "post": {"exposure_ev": 1, "bloom": {"strength": 0.2, "radius": 0.05}, "view": "standard"}
    })
}

/// Set a place of [`full`] (a JSON pointer); `null` as value removes it.
pub(super) fn with(pointer: &str, value: Value) -> String {
    let mut scene = full();
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    match scene.pointer_mut(parent).unwrap() {
        Value::Object(map) if value.is_null() => {
            map.remove(key);
        }
        Value::Object(map) => {
            map.insert(key.to_owned(), value);
        }
        Value::Array(list) => list[key.parse::<usize>().unwrap()] = value,
        _ => panic!("{pointer}"),
    }
    scene.to_string()
}

pub(super) fn fails(text: &str, path: &str, message: &str) {
    let error = parse(text.as_bytes()).unwrap_err();
    assert_eq!(
        (error.file.as_str(), error.path.as_str()),
        ("scene.json", path),
        "{error}"
    );
    assert!(
        error.message.contains(message),
        "{error} should say {message}"
    );
}
