//! The scenes of `scenes/clouds` that are made of parts: the composition of
//! golden-gate with other clouds.

use crate::assets::Asset;
use crate::composition;
use crate::cumulus::{CUMULUS, HEIGHT, TOWERS, WIDTH};
use crate::image_files::{self, EncodeError};

/// Where both methods put their clouds: between the planes, and over the sea.
const FORMATIONS: [&str; 2] = [
    r#""formation": {"type": "radial", "centre_m": [2, 19, -72], "radii_m": [34, 7, 18], "direction": [1, 0.12, -0.2], "length_m": 26}"#,
    r#""formation": {"type": "radial", "centre_m": [-330, 8, -760], "radii_m": [200, 52, 80], "direction": [-1, -0.05, 0.2], "length_m": 90}"#,
];

/// Fields of the clouds beside their formation; `{}` is particle or sprite.
const PARTICLES: [&str; 2] = [
    r#""count": 9000, "particle_radius_m": [0.5, 1.9], "stretch_x": [1, 1.6], "opacity": [0.01, 0.05], "albedo": [0.97, 0.97, 0.97], "seed": 21"#,
    r#""count": 9000, "particle_radius_m": [3, 11], "stretch_x": [1, 1.6], "opacity": [0.01, 0.06], "albedo": [0.97, 0.97, 0.97], "seed": 22"#,
];
const SPRITES: [&str; 2] = [
    r#""count": 9000, "sprite_radius_m": [0.7, 2.7], "opacity": [0.03, 0.16], "albedo": [0.97, 0.97, 0.97], "g": 0.3, "seed": 21"#,
    r#""count": 9000, "sprite_radius_m": [4, 15], "opacity": [0.03, 0.18], "albedo": [0.97, 0.97, 0.97], "g": 0.3, "seed": 22"#,
];

/// Clouds by a picture: file, place, size, and what they are made of.
const IMAGES: [&str; 4] = [
    r#"{"type": "particles", "formation": {"type": "image", "file": "assets/cumulus.png", "centre_m": [-15, 27, -105], "width_m": 74, "depth_m": 22, "rotate_deg": [0, 12, 0]}, "count": 22000, "particle_radius_m": [0.35, 1.3], "stretch_x": [1, 1.4], "opacity": [0.03, 0.1], "albedo": [0.97, 0.97, 0.97], "seed": 31}"#,
    r#"{"type": "particles", "formation": {"type": "image", "file": "assets/towers.png", "centre_m": [300, 90, -900], "width_m": 440, "depth_m": 120, "rotate_deg": [0, -18, 0]}, "count": 22000, "particle_radius_m": [2.2, 7.5], "stretch_x": [1, 1.4], "opacity": [0.03, 0.1], "albedo": [0.97, 0.97, 0.97], "seed": 32}"#,
    r#"{"type": "sprites", "formation": {"type": "image", "file": "assets/towers.png", "centre_m": [-520, 90, -1250], "width_m": 520, "height_m": 190, "depth_m": 140, "rotate_deg": [0, 20, 0]}, "count": 15000, "sprite_radius_m": [4, 14], "opacity": [0.05, 0.2], "albedo": [0.97, 0.97, 0.97], "g": 0.3, "seed": 33}"#,
    r#"{"type": "sprites", "formation": {"type": "image", "file": "assets/cumulus.png", "centre_m": [20, 160, -1500], "width_m": 330, "height_m": 110, "depth_m": 90, "rotate_deg": [0, 180, 0]}, "count": 8000, "sprite_radius_m": [4, 11], "opacity": [0.05, 0.2], "albedo": [0.97, 0.97, 0.97], "g": 0.3, "seed": 34}"#,
];

/// The generated files of `scenes/clouds`.
///
/// # Errors
/// When an image encoder refuses.
pub fn clouds() -> Result<Vec<Asset>, EncodeError> {
    let of_parts = |kind: &str, fields: [&str; 2]| -> Vec<String> {
        FORMATIONS
            .iter()
            .zip(fields)
            .map(|(formation, fields)| format!("{{\"type\": \"{kind}\", {formation}, {fields}}}"))
            .collect()
    };
    let scene = |path, name, clouds: &[String]| Asset {
        path,
        bytes: composition::with_clouds(name, clouds).into_bytes(),
    };
    let picture = |path, pixels: Vec<u8>| {
        image_files::png(&pixels, WIDTH, HEIGHT).map(|bytes| Asset { path, bytes })
    };
    Ok(vec![
        scene(
            "particles.json",
            "particles",
            &of_parts("particles", PARTICLES),
        ),
        scene("sprites.json", "sprites", &of_parts("sprites", SPRITES)),
        scene("image.json", "image", &IMAGES.map(str::to_owned)),
        picture("assets/cumulus.png", CUMULUS.pixels())?,
        picture("assets/towers.png", TOWERS.pixels())?,
    ])
}
