//! Pictures of frames as numbered files.

use crate::api::{Api, Picture};
use crate::exit::CliError;
use serde_json::{Value, json};
use shearwater_shared::api::{FrameState, FrameView, JobView};
use shearwater_shared::limits::FRAMES_MAX;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Which frames of a scene: `N` (0 to N - 1) or `A..B` (A to B - 1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FrameRange {
    /// The scene's number of the first one.
    pub(crate) first: u32,
    /// How many.
    pub(crate) count: u32,
}

impl FromStr for FrameRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| text.trim().parse::<u32>().ok();
        let range = match text.split_once("..") {
            Some((first, end)) => number(first).zip(number(end)),
            None => number(text).map(|count| (0, count)),
        };
        range
            .filter(|(first, end)| first < end && *end <= FRAMES_MAX)
            .map(|(first, end)| Self {
                first,
                count: end - first,
            })
            .ok_or_else(|| {
                format!(
                    "expected a number of frames N, 1 to {FRAMES_MAX}, or A..B with A < B (frames \
                     A to B - 1), for example 24..48"
                )
            })
    }
}

/// Whether the files of a job carry the number of their frame.
pub(crate) const fn are_numbered(job: &JobView) -> bool {
    job.fps.is_some() || job.settings.frames > 1
}

/// Name of a picture of a job without its extension; `frame` is the scene's
/// number of the frame.
pub(crate) fn stem(job: &JobView, frame: u32) -> String {
    let stem = file_stem(&job.name);
    if are_numbered(job) {
        format!("{stem}.{frame:04}")
    } else {
        stem
    }
}

/// Fetch both pictures of a frame (the scene's number) and write them to
/// `folder`.
pub(crate) async fn write_pictures(
    api: &Api,
    job: &JobView,
    frame: u32,
    folder: &Path,
) -> Result<Vec<PathBuf>, CliError> {
    std::fs::create_dir_all(folder).map_err(CliError::io(folder))?;
    let stem = stem(job, frame);
    let mut files = Vec::new();
    for picture in Picture::ALL {
        let bytes = api.picture(job.id, picture, frame).await?;
        let file = folder.join(format!("{stem}.{}", picture.extension()));
        write_whole(&file, &bytes)?;
        files.push(file);
    }
    Ok(files)
}

/// Writes the pictures of frames as they are finished, each once.
#[derive(Debug)]
pub(crate) struct FrameWriter {
    folder: PathBuf,
    /// Page of the first frame that is not written yet.
    page: Option<String>,
    /// By the scene's number.
    written: BTreeMap<u32, FrameView>,
    /// Every file, in the order of writing.
    pub(crate) files: Vec<PathBuf>,
}

impl FrameWriter {
    /// Nothing is written yet.
    pub(crate) fn new(folder: &Path) -> Self {
        Self {
            folder: folder.to_owned(),
            page: None,
            written: BTreeMap::new(),
            files: Vec::new(),
        }
    }

    /// The frames written, by the scene's number.
    pub(crate) const fn written(&self) -> &BTreeMap<u32, FrameView> {
        &self.written
    }

    /// Write what was finished since the last time. Asks for nothing when
    /// nothing was.
    pub(crate) async fn catch_up(&mut self, api: &Api, job: &JobView) -> Result<(), CliError> {
        let mut page = self.page.clone();
        let mut all_before = true;
        while (self.written.len() as u64) < job.frames_done {
            let answer = api.frames(job.id, page.as_deref()).await?;
            for frame in answer.frames {
                let done = frame.state == FrameState::Done;
                all_before &= done;
                if done && !self.written.contains_key(&frame.frame) {
                    let files = write_pictures(api, job, frame.frame, &self.folder).await?;
                    self.files.extend(files);
                    self.written.insert(frame.frame, frame);
                }
            }
            page = answer.next_page_token;
            if page.is_none() {
                break;
            }
            if all_before {
                self.page.clone_from(&page);
            }
        }
        Ok(())
    }

    /// The frames written, for programs.
    pub(crate) fn json(&self) -> Value {
        let frame = |frame: &FrameView| {
            json!({
                "frame": frame.frame,
                "film_hash": frame.film_hash,
                "nmse": frame.error.map(|error| error.nmse),
            })
        };
        self.written.values().map(frame).collect()
    }
}

/// A viewer that watches the file must never see half of it.
fn write_whole(file: &Path, bytes: &[u8]) -> Result<(), CliError> {
    let mut part = file.as_os_str().to_owned();
    part.push(".part");
    let part = PathBuf::from(part);
    std::fs::write(&part, bytes).map_err(CliError::io(&part))?;
    std::fs::rename(&part, file).map_err(CliError::io(file))
}

/// A job's name as a file name: a name is a text, not a path.
pub(crate) fn file_stem(name: &str) -> String {
    let stem: String = name
        .chars()
        .map(|c| match c {
            c if c.is_alphanumeric() || matches!(c, '-' | '_' | '.' | ' ') => c,
            _ => '_',
        })
        .collect();
    let stem = stem.trim_matches(['.', ' ']);
    if stem.is_empty() {
        "picture".to_owned()
    } else {
        stem.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_never_leave_the_folder() {
        assert_eq!(file_stem("golden-gate"), "golden-gate");
        assert_eq!(file_stem("../../etc/passwd"), "_.._etc_passwd");
        assert_eq!(file_stem(".."), "picture");
        assert_eq!(file_stem(""), "picture");
        assert_eq!(file_stem("a\0b\nc\\d"), "a_b_c_d");
    }

    #[test]
    fn ranges_of_frames() {
        let range = |first, count| Ok(FrameRange { first, count });
        assert_eq!("72".parse(), range(0, 72));
        assert_eq!("24..48".parse(), range(24, 24));
        assert_eq!("0..1".parse(), range(0, 1));
        assert_eq!("999999..1000000".parse(), range(999_999, 1));
        for bad in [
            "",
            "0",
            "-1",
            "x",
            "..",
            "3..",
            "..3",
            "3..3",
            "5..2",
            "1..2..3",
            "1000001",
            "1.5",
            "0..1000001",
            "1...3",
        ] {
            assert!(bad.parse::<FrameRange>().is_err(), "{bad}");
        }
    }
}
