//! The picture's composition: where everything stands, as `scene.json`.

use crate::plane::shape::{ENGINE_X, ENGINE_Y, PROPELLER_Z};
use crate::sky;
use crate::vec3::{Vec3, vec3};
use std::fmt::Write as _;

/// Bearing of the sun, degrees clockwise from -z.
const SUN_AZIMUTH_DEG: f64 = -6.0;
/// Height of the sun, degrees.
const SUN_ELEVATION_DEG: f64 = 5.0;

/// Direction to the sun.
#[must_use]
pub fn to_sun() -> Vec3 {
    sky::direction(SUN_AZIMUTH_DEG, SUN_ELEVATION_DEG)
}

/// Where a plane flies: position, (pitch, yaw, roll) in degrees as the scene's
/// `rotate_deg`, and the turn of its two propellers.
struct Pose {
    place: Vec3,
    rotate_deg: (f64, f64, f64),
    propellers_deg: [f64; 2],
}

const PLANES: [Pose; 2] = [
    Pose {
        place: vec3(6.0, 10.4, -27.5),
        rotate_deg: (1.0, 138.0, 8.0),
        propellers_deg: [12.0, 47.0],
    },
    Pose {
        place: vec3(-14.5, 12.0, -53.0),
        rotate_deg: (1.0, 141.0, 10.0),
        propellers_deg: [70.0, 25.0],
    },
];

/// Turned as the scene turns instances: Ry Rx Rz.
fn rotated(p: Vec3, (rx, ry, rz): (f64, f64, f64)) -> Vec3 {
    p.rotated_z(rz.to_radians())
        .rotated_x(rx.to_radians())
        .rotated_y(ry.to_radians())
}

fn instance(out: &mut String, mesh: &str, place: Vec3, (rx, ry, rz): (f64, f64, f64)) {
    let comma = if out.is_empty() { "" } else { ",\n" };
    let _ = write!(
        out,
        "{comma}    {{\"mesh\": \"{mesh}\", \"translate_m\": [{:.4}, {:.4}, {:.4}], \
         \"rotate_deg\": [{rx:.2}, {ry:.2}, {rz:.2}], \"scale\": [1, 1, 1]}}",
        place.x, place.y, place.z
    );
}

fn instances() -> String {
    let mut out = String::new();
    instance(
        &mut out,
        "bridge",
        vec3(230.0, 0.0, -1000.0),
        (0.0, 35.0, 0.0),
    );
    instance(&mut out, "headland", Vec3::default(), (0.0, 0.0, 0.0));
    for plane in &PLANES {
        instance(&mut out, "plane", plane.place, plane.rotate_deg);
        for (side, turn) in [-1.0, 1.0].into_iter().zip(plane.propellers_deg) {
            let hub = vec3(side * ENGINE_X, ENGINE_Y, PROPELLER_Z);
            let (rx, ry, rz) = plane.rotate_deg;
            instance(
                &mut out,
                "propeller",
                plane.place + rotated(hub, plane.rotate_deg),
                (rx, ry, rz + turn),
            );
        }
    }
    out
}

/// The glow around the sun and its glitter.
const BLOOM: &str =
    r#""bloom": {"threshold": 4.0, "strength": 0.003, "radius": 0.05, "passes": 3}, "#;

/// The text of `scene.json`.
#[must_use]
pub fn scene_json() -> String {
    with_post("golden-gate", BLOOM)
}

/// The same scene without its bloom.
#[must_use]
pub fn without_bloom_json() -> String {
    with_post("golden-gate-without-bloom", "")
}

/// The same scene, one folder further, with other clouds: one JSON object each.
#[must_use]
pub fn with_clouds(name: &str, clouds: &[String]) -> String {
    let whole = with_post(name, BLOOM).replace("\"assets/", "\"../golden-gate/assets/");
    let (before, rest) = whole.split_once("  \"clouds\": [").unwrap_or((&whole, ""));
    let after = rest.split_once("\n  ],").map_or("", |(_, after)| after);
    let list = clouds.join(",\n    ");
    format!("{before}  \"clouds\": [\n    {list}\n  ],{after}")
}

fn with_post(name: &str, bloom: &str) -> String {
    include_str!("scene.template.json")
        .replace("@NAME@", name)
        .replace("@BLOOM@", bloom)
        .replace("@INSTANCES@", &instances())
        .replace("@SUN_AZIMUTH@", &format!("{SUN_AZIMUTH_DEG:.2}"))
        .replace("@SUN_ELEVATION@", &format!("{SUN_ELEVATION_DEG:.2}"))
}
