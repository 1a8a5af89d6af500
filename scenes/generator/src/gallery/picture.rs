//! One picture of the gallery.

use super::{GalleryError, Listed, Measured, error};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ImageEncoder, ImageReader};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Render a picture and put it into `folder`.
pub(super) fn render(
    binary: &Path,
    listed: &Listed,
    folder: &Path,
) -> Result<Measured, GalleryError> {
    let output = std::env::temp_dir().join(format!("shearwater-gallery-{}", std::process::id()));
    let mut args = vec![listed.command.clone(), listed.scene.clone()];
    args.extend(listed.args.iter().cloned());
    let started = std::time::Instant::now();
    let run = Command::new(binary)
        .args(&args)
        .arg("--json")
        .arg("-o")
        .arg(&output)
        .output()
        .map_err(|e| error(binary, format!("{e}; build it first")))?;
    if !run.status.success() {
        let text = String::from_utf8_lossy(&run.stderr);
        return Err(error(Path::new(&listed.scene), text));
    }
    let said: serde_json::Value =
        serde_json::from_slice(&run.stdout).map_err(|e| error(binary, e))?;
    let whole_s = started.elapsed().as_secs_f64();
    let rendered = said["files"]
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(|file| file.as_str())
        .find(|file| file.ends_with(".png"))
        .map(PathBuf::from)
        .ok_or_else(|| error(&output, "no PNG was written"))?;
    compress(&rendered, &folder.join(format!("{}.png", listed.name)))?;
    std::fs::remove_dir_all(&output).map_err(|e| error(&output, e))?;
    Ok(Measured {
        args,
        seconds: said["seconds"].as_f64().unwrap_or(whole_s),
        nmse: said["nmse"].as_f64(),
        film_hash: said["film_hash"].as_str().unwrap_or_default().to_owned(),
    })
}

// The same pixels in fewer bytes: this takes longer than a render wants to wait.
fn compress(from: &Path, to: &Path) -> Result<(), GalleryError> {
    let image = ImageReader::open(from)
        .map_err(|e| error(from, e))?
        .decode()
        .map_err(|e| error(from, e))?
        .to_rgb8();
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive)
        .write_image(
            image.as_raw(),
            image.width(),
            image.height(),
            image::ExtendedColorType::Rgb8,
        )
        .map_err(|e| error(to, e))?;
    std::fs::write(to, bytes).map_err(|e| error(to, e))
}
