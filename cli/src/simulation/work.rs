//! The job of a simulation: as many units as were asked for, in small pictures.

use crate::exit::CliError;
use crate::scene_files::{self, Bundle};
use serde_json::json;
use shearwater_shared::api::SettingsOverride;
use shearwater_shared::job::RenderSettings;
use shearwater_shared::limits;
use shearwater_shared::plan::Plan;
use shearwater_shared::stop::Stop;
use std::path::Path;

/// Most units of a simulation: two bits of memory each.
pub(crate) const UNITS_MAX: u64 = 1 << 30;
/// Samples per pixel of one block of a plan.
const BLOCK_SAMPLES: u64 = 128;

/// The settings of a job of at least `units` units.
///
/// # Errors
/// No job has so many units in so many frames of this size.
pub(crate) fn settings(
    units: u64,
    frames: u32,
    width: u32,
    height: u32,
) -> Result<RenderSettings, CliError> {
    let of = |samples| RenderSettings {
        width,
        height,
        samples,
        seed: 0,
        frames,
        first_frame: 0,
        stop: Stop::default(),
    };
    let tiles = u64::from(Plan::new(&of(2)).tiles()).max(1);
    let blocks = units.div_ceil(u64::from(frames.max(1)) * tiles).max(1);
    let samples = blocks.saturating_mul(BLOCK_SAMPLES);
    let settings = of(u32::try_from(samples).unwrap_or(u32::MAX - 1));
    let fits = settings
        .validate()
        .map_err(|e| e.to_string())
        .and_then(|()| match Plan::new(&settings).units_per_frame() {
            per_frame if per_frame > limits::FRAME_UNITS_MAX => Err(format!(
                "{per_frame} units of a frame, at most {}",
                limits::FRAME_UNITS_MAX
            )),
            _ => Ok(()),
        });
    fits.map_err(|why| {
        CliError::Simulation(format!(
            "{units} units in {frames} frames: {why}; take more frames"
        ))
    })?;
    Ok(settings)
}

/// The settings as a submission names them.
pub(crate) fn to_override(settings: &RenderSettings) -> SettingsOverride {
    SettingsOverride {
        width: Some(settings.width),
        height: Some(settings.height),
        samples: Some(settings.samples),
        frames: Some(settings.frames),
        ..SettingsOverride::default()
    }
}

/// A scene of nothing but sky, written into `folder`.
pub(crate) fn scene(folder: &Path) -> Result<Bundle, CliError> {
    let scene = json!({
        "version": 1,
        "name": "simulated",
        "image": { "width": 1, "height": 1 },
        "animation": { "fps": 25, "frames": 1 },
        "camera": { "position_m": [0, 1, 0], "target_m": [0, 1, -1], "vertical_fov_deg": 40 },
        "sky": { "type": "constant", "radiance": [0.03, 0.03, 0.03] },
    });
    let file = folder.join("scene.json");
    std::fs::write(&file, scene.to_string()).map_err(CliError::io(&file))?;
    scene_files::collect(&file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_job_has_the_units_that_were_asked_for() {
        let units = |units, frames, width, height| {
            let settings = settings(units, frames, width, height).expect("fits");
            Plan::new(&settings).units_per_frame() * u64::from(settings.frames)
        };
        assert_eq!(units(1_000_000, 10_000, 640, 1), 1_000_000);
        assert_eq!(units(2_000, 20, 640, 1), 2_000);
        assert_eq!(units(1, 1, 1, 1), 1);
        assert_eq!(units(7, 2, 65, 1), 8);
        for (count, frames) in [(UNITS_MAX, 1), (1, 0)] {
            assert!(settings(count, frames, 640, 1).is_err(), "{count} {frames}");
        }
    }

    #[test]
    fn the_scene_is_one() {
        let folder = tempfile::tempdir().expect("folder");
        let bundle = scene(folder.path()).expect("scene");
        assert_eq!((bundle.sources.len(), bundle.manifest.files.len()), (1, 0));
    }
}
