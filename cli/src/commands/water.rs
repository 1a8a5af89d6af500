//! `shearwater water`.

use crate::exit::CliError;
use crate::output;
use crate::scene_files;
use clap::Args;
use serde_json::json;
use shearwater_worker::water::water_pictures;
use std::path::PathBuf;

/// Write the height map and the normal map of a scene's water as pictures
///
/// NAME-height.png has 16-bit heights from the lowest (black) to the highest (white),
/// NAME-height.exr heights in metres and both slopes. NAME-normal.png is a normal
/// map (red right, green up, blue out of the water), NAME-normal.exr has unit normals.
///
/// Example: shearwater water scenes/golden-gate/scene.json --time 2.5 -o out
#[derive(Args, Debug)]
pub(crate) struct Water {
    /// scene.json, or the folder that holds it
    scene: PathBuf,
    /// Folder to write to; made if need be
    #[arg(short, long, value_name = "DIR", default_value = "out")]
    output: PathBuf,
    /// Time of the scene, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, allow_hyphen_values = true, value_parser = seconds)]
    time: f64,
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.abs() <= 1e6 => Ok(value),
        _ => Err("expected -1000000 to 1000000 s".to_owned()),
    }
}

pub(crate) fn run(args: &Water, json: bool) -> Result<(), CliError> {
    let scene = scene_files::collect(&args.scene)?.description;
    let Some(water) = &scene.water else {
        let message = "scene.json: water: there is none; add it to see its height map";
        return Err(CliError::Scene(message.to_owned()));
    };
    let pictures = water_pictures(water, args.time)
        .map_err(|e| CliError::Scene(format!("scene.json: water: {e}")))?;
    std::fs::create_dir_all(&args.output).map_err(CliError::io(&args.output))?;
    let mut files = Vec::new();
    for (ending, bytes) in [
        ("height.png", &pictures.height_png),
        ("height.exr", &pictures.height_exr),
        ("normal.png", &pictures.normal_png),
        ("normal.exr", &pictures.normal_exr),
    ] {
        let path = args.output.join(format!("{}-{ending}", scene.name));
        std::fs::write(&path, bytes).map_err(CliError::io(&path))?;
        files.push(path);
    }
    if json {
        output::object(&json!({
            "points": pictures.points,
            "side_m": pictures.side_m,
            "lowest_m": pictures.lowest_m,
            "highest_m": pictures.highest_m,
            "files": files,
        }));
        return Ok(());
    }
    output::line(format_args!(
        "heights {:.3} m to {:.3} m over {} m ({}x{})",
        pictures.lowest_m, pictures.highest_m, pictures.side_m, pictures.points, pictures.points
    ));
    for file in files {
        output::line(file.display());
    }
    Ok(())
}
