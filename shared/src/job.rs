//! Jobs: what a user asks for, and where a job stands.

use crate::hash::ContentHash;
use crate::limits;
use crate::plan::LEVEL_SAMPLES_MIN;
use crate::stop::Stop;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

/// A job's number, given by the store; unique for ever within one store.
#[derive(
    Clone,
    Copy,
    Debug,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    Serialize,
    Deserialize,
    schemars::JsonSchema,
    utoipa::ToSchema,
)]
#[serde(transparent)]
pub struct JobId(pub i64);

impl fmt::Display for JobId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// One file of a scene: its content and size.
#[derive(
    Clone, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema, utoipa::ToSchema,
)]
#[serde(deny_unknown_fields)]
pub struct AssetRef {
    /// blake3 of the bytes.
    pub hash: ContentHash,
    /// Length in bytes.
    pub size: u64,
}

/// The files of a scene: the bytes of scene.json by hash, and every asset by
/// the name that the scene uses. Names are keys, never paths of any machine.
#[derive(
    Clone, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema, utoipa::ToSchema,
)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// blake3 of the bytes of scene.json, uploaded like any asset.
    pub scene: ContentHash,
    /// Asset name as written in the scene (`assets/plane.obj`) to content.
    #[serde(default)]
    pub files: BTreeMap<String, AssetRef>,
}

impl Manifest {
    /// A name for scene and assets together: equal for equal content, so a
    /// built scene can be kept under it.
    #[must_use]
    pub fn key(&self) -> ContentHash {
        let mut hasher = blake3::Hasher::new();
        hasher.update(b"shearwater manifest 1");
        hasher.update(self.scene.as_bytes());
        for (name, asset) in &self.files {
            hasher.update(&(name.len() as u64).to_le_bytes());
            hasher.update(name.as_bytes());
            hasher.update(asset.hash.as_bytes());
        }
        ContentHash::from_bytes(*hasher.finalize().as_bytes())
    }
}

/// What is to be rendered, resolved: every number a worker or the film needs.
/// A job's pixels are a function of its [`Manifest`] and this alone.
#[derive(
    Clone,
    Copy,
    Debug,
    PartialEq,
    Eq,
    Serialize,
    Deserialize,
    schemars::JsonSchema,
    utoipa::ToSchema,
)]
#[serde(deny_unknown_fields)]
pub struct RenderSettings {
    /// Picture width in pixels.
    pub width: u32,
    /// Picture height in pixels.
    pub height: u32,
    /// Samples per pixel over both halves; even, at least 2.
    pub samples: u32,
    /// Seed of the whole job; another seed gives an independent picture.
    #[serde(default)]
    pub seed: u64,
    /// Number of frames. Rows, runs and films of a job number them from 0; what
    /// is rendered is frame `first_frame + n` of the scene
    /// ([`RenderSettings::absolute_frame`]).
    #[serde(default = "one")]
    pub frames: u32,
    /// Number of the first frame in the scene. A frame's film is a function of
    /// its absolute number, whatever other frames the job has.
    #[serde(default)]
    pub first_frame: u32,
    /// What ends it earlier.
    #[serde(default, skip_serializing_if = "Stop::is_default")]
    pub stop: Stop,
}

const fn one() -> u32 {
    1
}

/// A render setting out of its range.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("settings.{field} is {value}: expected {expected}")]
pub struct SettingsError {
    /// Which field.
    pub field: &'static str,
    /// What it was.
    pub value: u64,
    /// What it may be.
    pub expected: String,
}

impl RenderSettings {
    /// Check every field against [`limits`].
    ///
    /// # Errors
    /// Names the first field that is out of range and its range.
    pub fn validate(&self) -> Result<(), SettingsError> {
        let fail = |field, value: u64, expected: String| {
            Err(SettingsError {
                field,
                value,
                expected,
            })
        };
        let side = limits::IMAGE_SIDE_MAX;
        if !(1..=side).contains(&self.width) {
            return fail("width", self.width.into(), format!("1 to {side} pixels"));
        }
        if !(1..=side).contains(&self.height) {
            return fail("height", self.height.into(), format!("1 to {side} pixels"));
        }
        let pixels = u64::from(self.width) * u64::from(self.height);
        if pixels > limits::IMAGE_PIXELS_MAX {
            return fail(
                "width",
                self.width.into(),
                format!("at most {} pixels in all", limits::IMAGE_PIXELS_MAX),
            );
        }
        if !(2..=limits::SAMPLES_MAX).contains(&self.samples) || !self.samples.is_multiple_of(2) {
            return fail(
                "samples",
                self.samples.into(),
                format!("an even number, 2 to {}", limits::SAMPLES_MAX),
            );
        }
        if !(1..=limits::FRAMES_MAX).contains(&self.frames) {
            return fail(
                "frames",
                self.frames.into(),
                format!("1 to {}", limits::FRAMES_MAX),
            );
        }
        let first_max = limits::FRAMES_MAX - self.frames;
        if self.first_frame > first_max {
            return fail(
                "first_frame",
                self.first_frame.into(),
                format!(
                    "0 to {first_max}: with frames = {} the last frame is at most {}",
                    self.frames,
                    limits::FRAMES_MAX - 1
                ),
            );
        }
        if self.stop.error.is_some() && self.samples < LEVEL_SAMPLES_MIN {
            return fail(
                "samples",
                self.samples.into(),
                format!("at least {LEVEL_SAMPLES_MIN} with an error target"),
            );
        }
        if let Some(seconds) = self.stop.seconds
            && !(1..=limits::STOP_SECONDS_MAX).contains(&seconds)
        {
            return fail(
                "stop.seconds",
                seconds.into(),
                format!("1 to {} seconds", limits::STOP_SECONDS_MAX),
            );
        }
        if let Some(&last) = self.stop.cuts.ends().last()
            && last >= self.samples / 2
        {
            return fail(
                "stop.cuts",
                last.into(),
                format!("cuts below {}, the samples of each half", self.samples / 2),
            );
        }
        Ok(())
    }

    /// The scene's number of the job's frame `frame` (from 0). Settings that
    /// were checked cannot overflow.
    #[must_use]
    pub const fn absolute_frame(&self, frame: u32) -> u32 {
        self.first_frame.saturating_add(frame)
    }

    /// The job's number (from 0) of the scene's frame `absolute`; `None` when
    /// the job does not render it.
    #[must_use]
    pub const fn job_frame(&self, absolute: u32) -> Option<u32> {
        match absolute.checked_sub(self.first_frame) {
            Some(frame) if frame < self.frames => Some(frame),
            _ => None,
        }
    }

    /// The scene's number of the job's last frame.
    #[must_use]
    pub const fn last_frame(&self) -> u32 {
        self.absolute_frame(self.frames.saturating_sub(1))
    }
}

/// Where a job stands. Derived from unit states when it is asked for; only
/// `Paused`, `Cancelled` and `Failed` are stored, since nobody could derive them.
#[derive(
    Clone,
    Copy,
    Debug,
    PartialEq,
    Eq,
    Serialize,
    Deserialize,
    schemars::JsonSchema,
    utoipa::ToSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum JobState {
    /// No unit is done and none is leased.
    Queued,
    /// Some unit is leased or done.
    Running,
    /// Halted by a user: nothing of it is handed out before it is resumed. What is
    /// leased may still come and is counted.
    Paused,
    /// Every unit is counted; the film is final.
    Done,
    /// Stopped by a user.
    Cancelled,
    /// Cannot be rendered; the reason is with the job.
    Failed,
}

impl JobState {
    /// No further unit will be handed out.
    #[must_use]
    pub const fn is_final(self) -> bool {
        matches!(self, Self::Done | Self::Cancelled | Self::Failed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: RenderSettings = RenderSettings {
        width: 64,
        height: 32,
        samples: 4,
        seed: 0,
        frames: 1,
        first_frame: 0,
        stop: Stop::NONE,
    };

    #[test]
    fn settings_out_of_range_are_named() {
        assert_eq!(GOOD.validate(), Ok(()));
        let cases = [
            (RenderSettings { width: 0, ..GOOD }, "width"),
            (
                RenderSettings {
                    width: 20_000,
                    ..GOOD
                },
                "width",
            ),
            (
                RenderSettings {
                    width: 16_384,
                    height: 16_384,
                    ..GOOD
                },
                "width",
            ),
            (RenderSettings { height: 0, ..GOOD }, "height"),
            (RenderSettings { samples: 3, ..GOOD }, "samples"),
            (RenderSettings { samples: 0, ..GOOD }, "samples"),
            (RenderSettings { frames: 0, ..GOOD }, "frames"),
            (
                RenderSettings {
                    frames: limits::FRAMES_MAX + 1,
                    ..GOOD
                },
                "frames",
            ),
            (
                RenderSettings {
                    first_frame: limits::FRAMES_MAX,
                    ..GOOD
                },
                "first_frame",
            ),
            (
                RenderSettings {
                    first_frame: limits::FRAMES_MAX - 2,
                    frames: 3,
                    ..GOOD
                },
                "first_frame",
            ),
        ];
        for (settings, field) in cases {
            assert_eq!(settings.validate().map_err(|e| e.field), Err(field));
        }
    }

    #[test]
    fn stop_rules_out_of_range_are_named() {
        let with = |seconds, cuts: Vec<u32>| RenderSettings {
            stop: Stop {
                seconds,
                cuts: cuts.try_into().expect("cuts"),
                ..Stop::NONE
            },
            ..GOOD
        };
        assert_eq!(with(Some(1), vec![1]).validate(), Ok(()));
        let field = |settings: RenderSettings| settings.validate().map_err(|e| e.field);
        assert_eq!(field(with(Some(0), vec![])), Err("stop.seconds"));
        assert_eq!(field(with(None, vec![2])), Err("stop.cuts"));
    }

    #[test]
    fn frames_of_a_job_and_of_its_scene() {
        let last = RenderSettings {
            first_frame: limits::FRAMES_MAX - 3,
            frames: 3,
            ..GOOD
        };
        assert_eq!(last.validate(), Ok(()));
        assert_eq!(last.last_frame(), limits::FRAMES_MAX - 1);
        let some = RenderSettings {
            first_frame: 7,
            frames: 3,
            ..GOOD
        };
        assert_eq!(some.absolute_frame(2), 9);
        let found: Vec<Option<u32>> = (6..11).map(|frame| some.job_frame(frame)).collect();
        assert_eq!(found, [None, Some(0), Some(1), Some(2), None]);
    }

    #[test]
    fn settings_of_before_there_was_a_first_frame_are_read() {
        let old = r#"{"width":64,"height":32,"samples":4,"seed":0,"frames":1}"#;
        assert_eq!(serde_json::from_str(old).ok(), Some(GOOD));
    }

    #[test]
    fn manifest_key_follows_content_and_names() {
        let asset = |bytes: &[u8]| AssetRef {
            hash: ContentHash::of(bytes),
            size: bytes.len() as u64,
        };
        let base = Manifest {
            scene: ContentHash::of(b"{}"),
            files: [("a".to_owned(), asset(b"1"))].into(),
        };
        let mut renamed = base.clone();
        renamed.files = [("b".to_owned(), asset(b"1"))].into();
        let mut changed = base.clone();
        changed.files = [("a".to_owned(), asset(b"2"))].into();
        assert_eq!(base.key(), base.clone().key());
        assert_ne!(base.key(), renamed.key());
        assert_ne!(base.key(), changed.key());
    }
}
