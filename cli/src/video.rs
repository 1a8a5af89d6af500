//! Numbered pictures as one film, by the program ffmpeg where it is installed.

use crate::access;
use shearwater_shared::api::JobView;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use tokio::process::Command;

/// Quality of the H.264 film, 0 (lossless) to 51: hardly to be told from the
/// pictures.
const CRF: &str = "16";

/// Make NAME.mp4 (see [`film_stem`]) of the numbered PNG files of a job in
/// `folder`; every frame of it must be written. What happened instead, in one line, when there is none.
pub(crate) async fn make(job: &JobView, folder: &Path, stem: &str) -> Result<PathBuf, String> {
    let Some(fps) = job.fps else {
        return Err("no film: the scene has no frame rate".to_owned());
    };
    let name = film_stem(job, stem);
    let film = folder.join(format!("{name}.mp4"));
    // Never half a film under its name. The ending tells ffmpeg the format.
    let part = folder.join(format!("{name}.part.mp4"));
    let failed = |why: String| {
        let command = command_line(&arguments(job, fps, folder, stem, &film));
        format!("no {}: {why}. Made by: {command}", film.display())
    };
    let run = Command::new("ffmpeg")
        // It needs no right to anything.
        .env_remove(access::TOKEN_VARIABLE)
        .args(["-nostdin", "-y", "-loglevel", "error"])
        .args(arguments(job, fps, folder, stem, &part))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .kill_on_drop(true)
        .output()
        .await;
    let output = match run {
        Ok(output) => output,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            return Err(failed("ffmpeg is not installed".to_owned()));
        }
        Err(error) => return Err(failed(format!("ffmpeg: {error}"))),
    };
    if !output.status.success() {
        let _ = std::fs::remove_file(&part);
        let text = String::from_utf8_lossy(&output.stderr);
        let last = text.lines().rfind(|line| !line.trim().is_empty());
        return Err(failed(format!("ffmpeg: {}", last.unwrap_or("no reason"))));
    }
    std::fs::rename(&part, &film).map_err(|e| failed(e.to_string()))?;
    Ok(film)
}

/// Name of a job's film without its extension: a part of the animation has the
/// scene's numbers of its first and last frame, as the film of another part must
/// not take its place.
fn film_stem(job: &JobView, stem: &str) -> String {
    let settings = &job.settings;
    let (first, last) = (settings.first_frame, settings.last_frame());
    match job.animation_frames {
        Some(all) if first == 0 && settings.frames >= all => stem.to_owned(),
        _ => format!("{stem}.{first:04}-{last:04}"),
    }
}

/// What ffmpeg is told: H.264, 4:2:0, BT.709, at the scene's frame rate.
fn arguments(job: &JobView, fps: f64, folder: &Path, stem: &str, film: &Path) -> Vec<OsString> {
    let settings = &job.settings;
    // In a pattern of ffmpeg `%` begins a number; the stem has none.
    let escaped = folder.to_string_lossy().replace('%', "%%");
    let pattern = Path::new(&escaped).join(format!("{stem}.%04d.png"));
    let mut filters = String::new();
    let odd = [settings.width % 2, settings.height % 2];
    if odd != [0, 0] {
        // 4:2:0 needs even sides: the last column and row are drawn twice.
        let [right, bottom] = odd;
        filters = format!(
            "pad=iw+{right}:ih+{bottom},fillborders=right={right}:bottom={bottom}:mode=smear,"
        );
    }
    filters.push_str("scale=out_color_matrix=bt709:out_range=tv,format=yuv420p");
    let file = |path: &Path| {
        let mut url = OsString::from("file:");
        url.push(path);
        url
    };
    let text = |text: &str| OsString::from(text);
    vec![
        text("-framerate"),
        text(&fps.to_string()),
        text("-start_number"),
        text(&settings.first_frame.to_string()),
        text("-i"),
        file(&pattern),
        text("-frames:v"),
        text(&settings.frames.to_string()),
        text("-vf"),
        text(&filters),
        text("-c:v"),
        text("libx264"),
        text("-crf"),
        text(CRF),
        text("-colorspace"),
        text("bt709"),
        text("-color_primaries"),
        text("bt709"),
        text("-color_trc"),
        text("iec61966-2-1"),
        text("-movflags"),
        text("+faststart"),
        file(film),
    ]
}

/// As one types it into a shell.
fn command_line(arguments: &[OsString]) -> String {
    let mut line = String::from("ffmpeg");
    for argument in arguments {
        let argument = argument.to_string_lossy();
        let plain = |c: char| c.is_alphanumeric() || "-_./:+%=,".contains(c);
        line.push(' ');
        if argument.chars().all(plain) {
            line.push_str(&argument);
        } else {
            line.push('\'');
            line.push_str(&argument.replace('\'', r"'\''"));
            line.push('\'');
        }
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_reads_the_command_as_it_was_meant() {
        let arguments: Vec<OsString> = ["-i", "file:my out/it's.%04d.png", "a=1:b,c"]
            .map(OsString::from)
            .into();
        assert_eq!(
            command_line(&arguments),
            r"ffmpeg -i 'file:my out/it'\''s.%04d.png' a=1:b,c"
        );
    }
}
