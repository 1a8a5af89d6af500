//! `shearwater water`.

use crate::exit::CliError;
use crate::output;
use crate::scene_files;
use clap::Args;
use serde_json::json;
use shearwater_shared::scene::Water as SceneWater;
use shearwater_worker::water::height_pictures;
use std::path::PathBuf;

/// Write the height map of a scene's water as pictures
///
/// NAME-water.png has 16-bit heights from the lowest (black) to the highest
/// (white); NAME-water.exr has heights in metres and both slopes.
///
/// Example: shearwater water scenes/golden-gate/scene.json -o out
#[derive(Args, Debug)]
pub(crate) struct Water {
    /// scene.json, or the folder that holds it
    scene: PathBuf,
    /// Folder to write to; made if need be
    #[arg(short, long, value_name = "DIR", default_value = "out")]
    output: PathBuf,
}

pub(crate) fn run(args: &Water, json: bool) -> Result<(), CliError> {
    let scene = scene_files::collect(&args.scene)?.description;
    let Some(SceneWater::Tessendorf(sea)) = &scene.water else {
        let message = "scene.json: water: there is none; add it to see its height map";
        return Err(CliError::Scene(message.to_owned()));
    };
    let pictures = height_pictures(sea).map_err(|e| CliError::Scene(e.to_string()))?;
    std::fs::create_dir_all(&args.output).map_err(CliError::io(&args.output))?;
    let mut files = Vec::new();
    for (ending, bytes) in [("png", &pictures.png), ("exr", &pictures.exr)] {
        let path = args.output.join(format!("{}-water.{ending}", scene.name));
        std::fs::write(&path, bytes).map_err(CliError::io(&path))?;
        files.push(path);
    }
    if json {
        output::object(&json!({
            "grid": sea.grid,
            "tile_m": sea.tile_m,
            "lowest_m": pictures.lowest_m,
            "highest_m": pictures.highest_m,
            "files": files,
        }));
        return Ok(());
    }
    output::line(format_args!(
        "heights {:.3} m to {:.3} m over {} m ({}x{})",
        pictures.lowest_m, pictures.highest_m, sea.tile_m, sea.grid, sea.grid
    ));
    for file in files {
        output::line(file.display());
    }
    Ok(())
}
