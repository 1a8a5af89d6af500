//! One scene of everything, and the same elsewhere and of another size.

use serde_json::{Value, json};
use shearwater_shared::scene::{
    Cloud, Formation, SceneDescription, VolumeMethod, VolumeShape, Water, parse,
};
use shearwater_tracer::Assets;
use std::sync::Arc;

/// Kinds of water in [`scene`].
pub(crate) const WATERS: [&str; 4] = ["none", "tessendorf", "gerstner", "flat"];

/// How far [`moved`] worlds are: 2,000 tiles of the sea, 10,000 of its texture, whole waves.
pub(crate) const FAR_M: [f64; 3] = [1e5, 1e4, -1e5];

/// Where the vertices of the far meshes lie, metres.
const FAR_VERTICES_M: [f64; 3] = [1e5, -2e4, 1e5];

/// A house with a roof, so that there are contact shadows and edges in all directions.
const HOUSE: [[f64; 3]; 10] = [
    [-1.0, 0.0, -1.3],
    [1.0, 0.0, -1.3],
    [1.0, 0.0, 1.3],
    [-1.0, 0.0, 1.3],
    [-1.0, 1.1, -1.3],
    [1.0, 1.1, -1.3],
    [1.0, 1.1, 1.3],
    [-1.0, 1.1, 1.3],
    [0.0, 1.9, -1.3],
    [0.0, 1.9, 1.3],
];
const HOUSE_FACES: &str =
    "f 1 2 6 9 5\nf 3 4 8 10 7\nf 2 3 7 6\nf 4 1 5 8\nf 5 9 10 8\nf 6 7 10 9\n";
const GROUND: [[f64; 3]; 4] = [
    [-30.0, 0.0, -30.0],
    [-30.0, 0.0, 30.0],
    [30.0, 0.0, 30.0],
    [30.0, 0.0, -30.0],
];

fn obj(vertices: &[[f64; 3]], faces: &str, by: [f64; 3]) -> Vec<u8> {
    let line = |v: &[f64; 3]| {
        let [x, y, z] = [v[0] + by[0], v[1] + by[1], v[2] + by[2]];
        format!("v {x:.9} {y:.9} {z:.9}\n")
    };
    let text: String = vertices.iter().map(line).collect();
    (text + faces).into_bytes()
}

/// Two tiles of blue and white.
fn texture() -> Vec<u8> {
    let image = image::RgbImage::from_fn(8, 8, |x, y| {
        image::Rgb([if (x / 2 + y / 2) % 2 == 0 { 250 } else { 60 }, 200, 90])
    });
    let mut bytes = std::io::Cursor::new(Vec::new());
    image
        .write_to(&mut bytes, image::ImageFormat::Png)
        .expect("a PNG");
    bytes.into_inner()
}

/// The files of [`scene`]; the far mesh is the house 100 km from its own origin.
pub(crate) fn assets(far_mesh: bool) -> Assets {
    let by = if far_mesh { FAR_VERTICES_M } else { [0.0; 3] };
    let files = [
        ("house.obj", obj(&HOUSE, HOUSE_FACES, by)),
        ("ground.obj", obj(&GROUND, "f 1 2 3 4\n", by)),
        ("tiles.png", texture()),
    ];
    files
        .map(|(name, bytes)| (name.to_owned(), Arc::from(bytes)))
        .into()
}

fn water(kind: &str) -> Value {
    let look =
        json!({"height_m": 0.1, "velocity_mps": [2.0, -1.0], "body_color": [0.1, 0.25, 0.3]});
    let mut water = match kind {
        "tessendorf" => {
            json!({"grid": 128, "tile_m": 50.0, "wind_speed_mps": 5.0, "time_s": 2.0, "cutoff_m": 0.5})
        }
        "gerstner" => json!({"waves": [
            {"amplitude_m": 0.06, "wavelength_m": 4.0, "direction_deg": 90.0},
            {"amplitude_m": 0.02, "wavelength_m": 1.25, "direction_deg": 0.0, "phase_deg": 70.0}
        ]}),
        "flat" => json!({"texture": "tiles.png", "texture_size_m": 10.0, "roughness": 0.2}),
        _ => return Value::Null,
    };
    water["type"] = json!(kind);
    for (key, value) in look.as_object().expect("an object") {
        water[key] = value.clone();
    }
    water
}

fn clouds() -> Value {
    let radial = |centre: [f64; 3]| json!({"type": "radial", "centre_m": centre, "radii_m": [2.0, 0.8, 1.5], "direction": [1, 0.2, 0], "length_m": 1.0});
    json!([
        {"type": "particles", "formation": radial([-4.0, 4.0, -6.0]), "count": 60, "particle_radius_m": [0.2, 0.6], "opacity": [0.2, 0.6]},
        {"type": "sprites", "formation": radial([1.0, 4.5, -9.0]), "count": 40, "sprite_radius_m": [0.3, 0.8], "opacity": [0.2, 0.6]},
        {"type": "volume", "shape": {"type": "ellipsoid", "centre_m": [5.0, 4.0, -7.0], "radii_m": [2.0, 1.0, 1.5],
            "edge": 0.5, "resolution": 32, "noise": {"scale_m": 1.3, "seed": 4}}, "sigma_t_per_m": 3.0, "g": 0.5},
        {"type": "volume", "shape": {"type": "ellipsoid", "centre_m": [2.5, 1.0, -1.0], "radii_m": [0.8, 0.8, 0.8]},
            "sigma_t_per_m": 1.0, "albedo": [0.8, 0.9, 1.0], "method": {"type": "march", "step_m": 0.3}}
    ])
}

/// Houses at rest and in motion before clouds, under a sun and an even sky, with a lens
/// and an open shutter, over ground or `water`.
pub(crate) fn scene(kind: &str) -> SceneDescription {
    let mut instances = json!([
        {"mesh": "house", "material": "matt", "translate_m": [-2.0, 0.0, -3.0], "rotate_deg": [0.0, 25.0, 0.0]},
        {"mesh": "house", "material": "gloss", "name": "turning", "translate_m": [2.2, 0.4, -4.5], "scale": [0.7, 0.9, 0.7],
            "velocity_mps": [3.0, 0.0, 1.0], "spin": {"axis": [0, 1, 0], "rpm": 60.0}},
        {"mesh": "house", "material": "matt", "parent": "turning", "translate_m": [0.0, 2.4, 0.0], "scale": [0.3, 0.3, 0.3],
            "velocity_mps": [0.0, 1.0, 0.0]}
    ]);
    if kind == "none" {
        let ground = json!({"mesh": "ground", "material": "matt"});
        instances.as_array_mut().expect("a list").push(ground);
    }
    let mut described = json!({
        "version": 1, "name": "worlds", "image": {"width": 48, "height": 24},
        "camera": {"position_m": [0.3, 2.2, 7.0], "target_m": [0.2, 1.6, -3.0], "vertical_fov_deg": 38.0, "shutter_s": 0.1,
            "lens_radius_m": 0.05, "velocity_mps": [0.5, 0.0, 0.0]},
        "materials": {
            "matt": {"type": "lambert", "albedo": [0.6, 0.5, 0.4]},
            "gloss": {"type": "ggx", "base_color": [0.7, 0.3, 0.2], "roughness": 0.35}
        },
        "meshes": {"house": {"file": "house.obj"}, "ground": {"file": "ground.obj"}},
        "instances": instances, "clouds": clouds(),
        "sky": {"type": "constant", "radiance": [0.4, 0.5, 0.7]},
        "sun": {"azimuth_deg": 130.0, "elevation_deg": 25.0, "angular_radius_deg": 2.0, "radiance": [500.0, 450.0, 350.0]}
    });
    let water = water(kind);
    if !water.is_null() {
        described["water"] = water;
    }
    parse(described.to_string().as_bytes()).expect("a valid scene")
}

fn add(to: &mut [f64; 3], by: [f64; 3]) {
    for (to, by) in to.iter_mut().zip(by) {
        *to += by;
    }
}

/// The scene with everything somewhere else. Waves lie in the water as they did, since
/// `by` is a multiple of their tile and lengths.
pub(crate) fn moved(scene: &SceneDescription, by: [f64; 3]) -> SceneDescription {
    let mut scene = scene.clone();
    add(&mut scene.camera.position_m, by);
    add(&mut scene.camera.target_m, by);
    for instance in scene.instances.iter_mut().filter(|i| i.parent.is_none()) {
        add(&mut instance.translate_m, by);
    }
    for cloud in &mut scene.clouds {
        match cloud {
            Cloud::Particles(cloud) => move_formation(&mut cloud.formation, by),
            Cloud::Sprites(cloud) => move_formation(&mut cloud.formation, by),
            Cloud::Volume(cloud) => match &mut cloud.shape {
                VolumeShape::Ellipsoid(shape) => add(&mut shape.centre_m, by),
                VolumeShape::Grid(shape) => add(&mut shape.centre_m, by),
            },
        }
    }
    match &mut scene.water {
        Some(Water::Tessendorf(water)) => water.height_m += by[1],
        Some(Water::Gerstner(water)) => water.height_m += by[1],
        Some(Water::Flat(water)) => water.height_m += by[1],
        None => {}
    }
    scene
}

fn move_formation(formation: &mut Formation, by: [f64; 3]) {
    match formation {
        Formation::Radial(radial) => add(&mut radial.centre_m, by),
        Formation::Image(image) => add(&mut image.centre_m, by),
    }
}

/// The scene whose meshes lie far from their origin, and instances that bring them back.
pub(crate) fn with_far_vertices(scene: &SceneDescription) -> SceneDescription {
    let mut described = serde_json::to_value(scene).expect("JSON");
    let back = FAR_VERTICES_M.map(|x| -x);
    let instances = described["instances"].as_array_mut().expect("a list");
    // Each instance in the space of a carrier that stands where it stood: the carrier
    // is hidden far below.
    for instance in instances.iter_mut() {
        let scale: [f64; 3] = serde_json::from_value(instance["scale"].clone()).expect("three");
        let turned = instance["rotate_deg"] != json!([0.0, 0.0, 0.0]);
        let at: [f64; 3] = serde_json::from_value(instance["translate_m"].clone()).expect("three");
        let mut reach = std::array::from_fn(|k| back[k] * scale[k]);
        if turned {
            let degrees = instance["rotate_deg"][1].as_f64().expect("a number");
            let (sin, cos) = (
                libm::sin(degrees.to_radians()),
                libm::cos(degrees.to_radians()),
            );
            let [x, y, z] = reach;
            reach = [cos * x + sin * z, y, cos * z - sin * x];
        }
        if instance["spin"].is_object() {
            // The turn is about the place where the house stands in its mesh.
            instance["spin"]["pivot_m"] = json!(FAR_VERTICES_M);
        }
        if instance["parent"].is_string() {
            // The parent's space begins at its mesh's origin.
            add(&mut reach, FAR_VERTICES_M);
        }
        instance["translate_m"] = json!([at[0] + reach[0], at[1] + reach[1], at[2] + reach[2]]);
    }
    serde_json::from_value(described).expect("a scene")
}

/// The scene with every length times `by`. Speeds and durations go with its root, as
/// waves do; extinction goes with its inverse.
pub(crate) fn scaled(scene: &SceneDescription, by: f64) -> SceneDescription {
    let mut scene = scene.clone();
    let root = libm::sqrt(by);
    let grow = |v: &mut [f64; 3]| *v = v.map(|x| x * by);
    let speed = |v: &mut [f64; 3]| *v = v.map(|x| x * root);
    let camera = &mut scene.camera;
    grow(&mut camera.position_m);
    grow(&mut camera.target_m);
    speed(&mut camera.velocity_mps);
    camera.shutter_s *= root;
    camera.lens_radius_m *= by;
    for instance in &mut scene.instances {
        // A child's numbers are in its parent's space, which grows with the parent.
        if instance.parent.is_none() {
            grow(&mut instance.translate_m);
            grow(&mut instance.scale);
            speed(&mut instance.velocity_mps);
        } else {
            instance.velocity_mps = instance.velocity_mps.map(|x| x / root);
        }
        if let Some(spin) = &mut instance.spin {
            spin.rpm /= root;
        }
    }
    for cloud in &mut scene.clouds {
        scale_cloud(cloud, by);
    }
    match &mut scene.water {
        Some(Water::Tessendorf(water)) => {
            water.height_m *= by;
            water.tile_m *= by;
            water.cutoff_m *= by;
            water.wind_speed_mps *= root;
            water.time_s *= root;
            water.velocity_mps = water.velocity_mps.map(|x| x * root);
        }
        Some(Water::Gerstner(water)) => {
            water.height_m *= by;
            water.time_s *= root;
            water.velocity_mps = water.velocity_mps.map(|x| x * root);
            for wave in &mut water.waves {
                wave.amplitude_m *= by;
                wave.wavelength_m *= by;
            }
        }
        Some(Water::Flat(water)) => {
            water.height_m *= by;
            water.texture_size_m *= by;
            water.velocity_mps = water.velocity_mps.map(|x| x * root);
        }
        None => {}
    }
    scene
}

fn scale_cloud(cloud: &mut Cloud, by: f64) {
    let grow = |v: &mut [f64; 3]| *v = v.map(|x| x * by);
    let formation = |formation: &mut Formation| {
        if let Formation::Radial(radial) = formation {
            grow(&mut radial.centre_m);
            grow(&mut radial.radii_m);
            radial.length_m *= by;
        }
    };
    match cloud {
        Cloud::Particles(cloud) => {
            formation(&mut cloud.formation);
            cloud.particle_radius_m = cloud.particle_radius_m.map(|x| x * by);
        }
        Cloud::Sprites(cloud) => {
            formation(&mut cloud.formation);
            cloud.sprite_radius_m = cloud.sprite_radius_m.map(|x| x * by);
        }
        Cloud::Volume(cloud) => {
            cloud.sigma_t_per_m /= by;
            if let VolumeShape::Ellipsoid(shape) = &mut cloud.shape {
                grow(&mut shape.centre_m);
                grow(&mut shape.radii_m);
                if let Some(noise) = &mut shape.noise {
                    noise.scale_m *= by;
                }
            }
            if let VolumeMethod::March(march) = &mut cloud.method {
                march.step_m *= by;
            }
        }
    }
}
