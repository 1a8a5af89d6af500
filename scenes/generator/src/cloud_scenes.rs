//! The scenes of `scenes/clouds`, the composition of golden-gate with other clouds:
//! those made of parts here, those of volumes in `volume_scenes`.

use crate::assets::Asset;
use crate::composition;
use crate::cumulus::{CUMULUS, HEIGHT, TOWERS, WIDTH};
use crate::image_files::{self, EncodeError};
use crate::volume_scenes;

/// Where both methods put their clouds: about the planes, and over the sea.
const FORMATIONS: [&str; 3] = [
    r#""formation": {"type": "radial", "centre_m": [14, 12, -64], "radii_m": [24, 4.5, 12], "direction": [1, 0.1, -0.2], "length_m": 16}"#,
    r#""formation": {"type": "radial", "centre_m": [-330, 60, -860], "radii_m": [150, 46, 70], "direction": [-1, -0.1, 0.2], "length_m": 60}"#,
    r#""formation": {"type": "radial", "centre_m": [430, 110, -1000], "radii_m": [130, 60, 70], "direction": [0.5, 1, 0], "length_m": 70}"#,
];

/// Fields of the clouds beside their formation: what is as large as what stands
/// in the other scene in the same place.
const PARTICLES: [&str; 3] = [
    r#""count": 6000, "particle_radius_m": [0.5, 1.8], "stretch_x": [1, 1.6], "opacity": [0.01, 0.06], "albedo": [0.98, 0.98, 0.98], "seed": 21"#,
    r#""count": 12000, "particle_radius_m": [3, 10], "stretch_x": [1, 1.6], "opacity": [0.02, 0.12], "albedo": [0.98, 0.98, 0.98], "seed": 22"#,
    r#""count": 12000, "particle_radius_m": [3, 10], "stretch_x": [1, 1.6], "opacity": [0.02, 0.12], "albedo": [0.98, 0.98, 0.98], "seed": 23"#,
];
const SPRITES: [&str; 3] = [
    r#""count": 6000, "sprite_radius_m": [0.7, 2.7], "opacity": [0.03, 0.2], "albedo": [0.98, 0.98, 0.98], "g": 0.5, "seed": 21"#,
    r#""count": 12000, "sprite_radius_m": [4, 14], "opacity": [0.06, 0.36], "albedo": [0.98, 0.98, 0.98], "g": 0.5, "seed": 22"#,
    r#""count": 12000, "sprite_radius_m": [4, 14], "opacity": [0.06, 0.36], "albedo": [0.98, 0.98, 0.98], "g": 0.5, "seed": 23"#,
];

/// Clouds by a picture: file, place, size, and what they are made of.
const IMAGES: [&str; 4] = [
    r#"{"type": "particles", "formation": {"type": "image", "file": "assets/cumulus.png", "centre_m": [-300, 150, -800], "width_m": 470, "height_m": 170, "depth_m": 130, "rotate_deg": [0, 12, 0]}, "count": 20000, "particle_radius_m": [2.5, 8], "stretch_x": [1, 1.4], "opacity": [0.01, 0.05], "albedo": [0.98, 0.98, 0.98], "seed": 31}"#,
    r#"{"type": "particles", "formation": {"type": "image", "file": "assets/towers.png", "centre_m": [420, 120, -950], "width_m": 460, "height_m": 260, "depth_m": 130, "rotate_deg": [0, -18, 0]}, "count": 20000, "particle_radius_m": [2.5, 8], "stretch_x": [1, 1.4], "opacity": [0.01, 0.05], "albedo": [0.98, 0.98, 0.98], "seed": 32}"#,
    r#"{"type": "sprites", "formation": {"type": "image", "file": "assets/cumulus.png", "centre_m": [110, 330, -1500], "width_m": 420, "height_m": 130, "depth_m": 110, "rotate_deg": [0, 180, 0]}, "count": 8000, "sprite_radius_m": [5, 14], "opacity": [0.03, 0.12], "albedo": [0.98, 0.98, 0.98], "g": 0.5, "seed": 33}"#,
    r#"{"type": "sprites", "formation": {"type": "image", "file": "assets/towers.png", "centre_m": [-250, 60, -2600], "width_m": 1500, "height_m": 220, "depth_m": 260}, "count": 12000, "sprite_radius_m": [10, 30], "opacity": [0.03, 0.12], "albedo": [0.98, 0.98, 0.98], "g": 0.5, "seed": 34}"#,
];

/// The generated files of `scenes/clouds`.
///
/// # Errors
/// When an image encoder refuses.
pub fn clouds() -> Result<Vec<Asset>, EncodeError> {
    let of_parts = |kind: &str, fields: [&str; 3]| -> Vec<String> {
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
    let mut files = vec![
        scene(
            "particles.json",
            "particles",
            &of_parts("particles", PARTICLES),
        ),
        scene("sprites.json", "sprites", &of_parts("sprites", SPRITES)),
        scene("image.json", "image", &IMAGES.map(str::to_owned)),
        picture("assets/cumulus.png", CUMULUS.pixels())?,
        picture("assets/towers.png", TOWERS.pixels())?,
    ];
    files.extend(volume_scenes::volumes());
    Ok(files)
}
