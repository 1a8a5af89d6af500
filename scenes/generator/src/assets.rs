//! The files of a scene: their names and bytes, made from nothing.

use crate::image_files::{self, EncodeError};
use crate::obj::{mtl_text, obj_text};
use crate::vec3::Vec3;
use crate::{bridge, composition, land, livery, plane, sky};

/// One file of a scene.
pub struct Asset {
    /// Path relative to the scene's folder.
    pub path: &'static str,
    /// Contents.
    pub bytes: Vec<u8>,
}

/// The four skies of `scenes/skies`: noon, overcast, sunset, night.
///
/// # Errors
/// When the image encoder refuses.
pub fn skies() -> Result<Vec<Asset>, EncodeError> {
    /// Half of the golden-gate sky's: 0.35 degrees a pixel.
    const ROWS: usize = 512;
    /// Stars want to be small.
    const ROWS_AT_NIGHT: usize = 1024;
    let sky = |path, rows, radiance: &dyn Fn(Vec3) -> [f64; 3]| {
        let pixels = sky::map(2 * rows, rows, radiance);
        let bytes = image_files::exr(&pixels, 2 * rows, rows)?;
        Ok(Asset { path, bytes })
    };
    let to_sun = composition::to_sun();
    Ok(vec![
        sky("assets/noon.exr", ROWS, &sky::noon::radiance)?,
        sky("assets/overcast.exr", ROWS, &sky::overcast::radiance)?,
        sky("assets/sunset.exr", ROWS, &|towards| {
            sky::radiance(towards, to_sun)
        })?,
        sky("assets/night.exr", ROWS_AT_NIGHT, &sky::night::radiance)?,
    ])
}

/// All files of the golden-gate scene but its README.
///
/// # Errors
/// When an image encoder refuses.
pub fn golden_gate() -> Result<Vec<Asset>, EncodeError> {
    let plane_title =
        "Shearwater: twin-engined plane; nose towards -z, origin at the centre of mass";
    let propeller_title = "Shearwater: propeller about its own axis z, spinner towards -z";
    let bridge_title = "Shearwater: suspension bridge; x along it, origin on the water at mid-span";
    let land_title = "Shearwater: headlands in the scene's own coordinates";
    let text = |path, text: String| Asset {
        path,
        bytes: text.into_bytes(),
    };
    let side = plane::atlas::SIZE;
    Ok(vec![
        text("scene.json", composition::scene_json()),
        text("without-bloom.json", composition::without_bloom_json()),
        text(
            "assets/plane.obj",
            obj_text(plane_title, "plane.mtl", &plane::mesh(), 4),
        ),
        text("assets/plane.mtl", mtl_text(plane_title, &plane::MATERIALS)),
        text(
            "assets/propeller.obj",
            obj_text(
                propeller_title,
                "propeller.mtl",
                &plane::propeller_mesh(),
                4,
            ),
        ),
        text(
            "assets/propeller.mtl",
            mtl_text(propeller_title, &plane::PROPELLER_MATERIALS),
        ),
        text(
            "assets/bridge.obj",
            obj_text(bridge_title, "bridge.mtl", &bridge::mesh(), 3),
        ),
        text(
            "assets/bridge.mtl",
            mtl_text(bridge_title, &bridge::MATERIALS),
        ),
        text(
            "assets/headland.obj",
            obj_text(land_title, "headland.mtl", &land::mesh(), 1),
        ),
        text(
            "assets/headland.mtl",
            mtl_text(land_title, &land::MATERIALS),
        ),
        Asset {
            path: "assets/livery.png",
            bytes: image_files::png(&livery::pixels(), side, side)?,
        },
        Asset {
            path: "assets/sky.exr",
            bytes: image_files::exr(&sky::pixels(composition::to_sun()), sky::WIDTH, sky::HEIGHT)?,
        },
    ])
}
