//! From what a submission overrides and what its scene says to the settings of
//! the job.

use super::problem::ApiError;
use shearwater_shared::api::SettingsOverride;
use shearwater_shared::job::RenderSettings;
use shearwater_shared::limits;
use shearwater_shared::plan::{LEVEL_SAMPLES_MIN, Plan};
use shearwater_shared::scene::SceneDescription;
use shearwater_shared::stop::{Cuts, Stop};

/// Most samples per pixel of a job that names a time or an error, and no samples:
/// a hundred times what a finished picture usually has.
const SAMPLES_WITH_STOP: u32 = 16_384;

/// The settings of a job, checked.
pub(super) fn merged(
    given: &SettingsOverride,
    scene: &SceneDescription,
) -> Result<RenderSettings, ApiError> {
    let first_frame = given.first_frame.unwrap_or(0);
    let animated = scene.animation.map(|animation| animation.frames);
    let settings = RenderSettings {
        width: given.width.unwrap_or(scene.image.width),
        height: given.height.unwrap_or(scene.image.height),
        samples: samples(given, scene),
        seed: given.seed.unwrap_or(0),
        frames: frames(given, first_frame, animated)?,
        first_frame,
        stop: Stop {
            error: given.error.or(scene.job.error),
            seconds: given.seconds.or(scene.job.seconds),
            cuts: Cuts::NONE,
        },
    };
    let settings = cut_for_stops(settings)?;
    settings
        .validate()
        .map_err(|e| ApiError::Invalid(e.to_string()))?;
    let units = Plan::new(&settings).units_per_frame();
    if units > limits::FRAME_UNITS_MAX {
        return Err(ApiError::Invalid(format!(
            "settings: {units} units of work per frame, at most {}; fewer samples or pixels",
            limits::FRAME_UNITS_MAX
        )));
    }
    Ok(settings)
}

/// Samples per pixel: the most of them when a stop rule is given without.
fn samples(given: &SettingsOverride, scene: &SceneDescription) -> u32 {
    let stops = given.error.is_some() || given.seconds.is_some();
    let default = if stops {
        SAMPLES_WITH_STOP
    } else {
        scene.job.samples
    };
    given.samples.unwrap_or(default)
}

/// Blocks of a job with a time stop begin this small, in samples of each half: every
/// tile has its first block before any has its second, however short the time is.
const FIRST_BLOCKS_TIMED: [u32; 3] = [8, 16, 32];

/// Where blocks must end for the stop rules. A job with an error target decides
/// first at [`LEVEL_SAMPLES_MIN`] samples.
fn cut_for_stops(mut settings: RenderSettings) -> Result<RenderSettings, ApiError> {
    let level = settings.stop.error.map(|_| LEVEL_SAMPLES_MIN / 2);
    let timed = settings.stop.seconds.map(|_| FIRST_BLOCKS_TIMED);
    let ends = level.into_iter().chain(timed.into_iter().flatten());
    for end in ends.filter(|&end| end < settings.samples / 2) {
        let cuts = settings.stop.cuts.with(end);
        settings.stop.cuts = cuts.map_err(|e| ApiError::Invalid(e.to_string()))?;
    }
    Ok(settings)
}

fn frames(
    given: &SettingsOverride,
    first_frame: u32,
    animated: Option<u32>,
) -> Result<u32, ApiError> {
    let still = |field: &str, value: u32, only: u32| {
        Err(ApiError::Invalid(format!(
            "settings.{field} is {value}: the scene has no `animation`, so that all its frames \
             would be one picture; expected {only}, or add `animation` to the scene"
        )))
    };
    match (animated, given.frames) {
        (None, _) if first_frame > 0 => still("first_frame", first_frame, 0),
        (None, Some(frames)) if frames > 1 => still("frames", frames, 1),
        (_, Some(frames)) => Ok(frames),
        (None, None) => Ok(1),
        (Some(animated), None) if first_frame < animated => Ok(animated - first_frame),
        (Some(animated), None) => Err(ApiError::Invalid(format!(
            "settings.first_frame is {first_frame}: the scene's animation has frames 0 to {}; \
             name settings.frames to go beyond its end",
            animated.saturating_sub(1)
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shearwater_shared::scene::{self, Animation};

    const STILL: &str = r#"{
      "version": 1, "name": "n", "image": { "width": 96, "height": 80 },
      "camera": { "position_m": [0, 0, 5], "target_m": [0, 0, 0], "vertical_fov_deg": 40 }
    }"#;

    fn settings(
        frames: Option<u32>,
        first_frame: Option<u32>,
        animated: Option<u32>,
    ) -> Result<(u32, u32), String> {
        let mut scene = scene::parse(STILL.as_bytes()).expect("scene");
        scene.animation = animated.map(|frames| Animation {
            fps: 24.0,
            frames,
            start_s: 0.0,
        });
        let given = SettingsOverride {
            frames,
            first_frame,
            ..SettingsOverride::default()
        };
        merged(&given, &scene)
            .map(|settings| (settings.first_frame, settings.frames))
            .map_err(|e| e.to_string())
    }

    #[test]
    fn a_still_has_one_frame() {
        assert_eq!(settings(None, None, None), Ok((0, 1)));
        assert_eq!(settings(Some(1), Some(0), None), Ok((0, 1)));
        for (frames, first, field) in [
            (Some(2), None, "settings.frames is 2"),
            (None, Some(1), "settings.first_frame is 1"),
            (Some(1), Some(1), "settings.first_frame is 1"),
        ] {
            let error = settings(frames, first, None).expect_err("no animation");
            assert!(
                error.contains(field) && error.contains("no `animation`"),
                "{error}"
            );
        }
    }

    #[test]
    fn an_animation_gives_its_frames_and_may_be_cut() {
        let animated = Some(72);
        assert_eq!(settings(None, None, animated), Ok((0, 72)));
        assert_eq!(settings(None, Some(70), animated), Ok((70, 2)));
        assert_eq!(settings(Some(3), Some(80), animated), Ok((80, 3)));
        let error = settings(None, Some(72), animated).expect_err("beyond the end");
        assert!(error.contains("frames 0 to 71"), "{error}");
        for (frames, first) in [
            (Some(0), None),
            (Some(limits::FRAMES_MAX + 1), None),
            (Some(2), Some(limits::FRAMES_MAX - 1)),
            (Some(2), Some(u32::MAX)),
        ] {
            let error = settings(frames, first, animated).expect_err("out of range");
            assert!(error.contains("expected"), "{error}");
        }
    }
}
