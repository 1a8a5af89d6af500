//! `shearwater download`.

use crate::api::{Api, Picture};
use crate::args::Target;
use crate::exit::CliError;
use crate::output;
use clap::Args;
use serde_json::json;
use shearwater_shared::api::JobView;
use std::path::{Path, PathBuf};

/// Fetch the pictures of a job, finished or not
///
/// Writes NAME.png (developed) and NAME.exr (linear, with albedo, normal,
/// depth, variance and sample count).
#[derive(Args, Debug)]
pub(crate) struct Download {
    /// Number of the job
    id: i64,
    /// Folder to write to; made if need be
    #[arg(short, long, value_name = "DIR", default_value = "out")]
    output: PathBuf,
    /// Frame number, from 0
    #[arg(long, value_name = "N", default_value_t = 0)]
    frame: u32,
    #[command(flatten)]
    target: Target,
}

pub(crate) async fn run(args: &Download, json: bool) -> Result<(), CliError> {
    let api = Api::new(&args.target.url)?;
    let job = api.job(shearwater_shared::job::JobId(args.id)).await?;
    let files = write_pictures(&api, &job, args.frame, &args.output).await?;
    if json {
        output::object(&json!({
            "job": job.id,
            "done": job.done,
            "progress": job.progress,
            "files": files,
        }));
    } else {
        files.iter().for_each(|file| output::line(file.display()));
    }
    Ok(())
}

/// Fetch both pictures of a frame and write them to `folder`.
pub(crate) async fn write_pictures(
    api: &Api,
    job: &JobView,
    frame: u32,
    folder: &Path,
) -> Result<Vec<PathBuf>, CliError> {
    std::fs::create_dir_all(folder).map_err(CliError::io(folder))?;
    let mut stem = file_stem(&job.name);
    if job.settings.frames > 1 {
        stem = format!("{stem}.{frame:04}");
    }
    let mut files = Vec::new();
    for picture in Picture::ALL {
        let bytes = api.picture(job.id, picture, frame).await?;
        let file = folder.join(format!("{stem}.{}", picture.extension()));
        write_whole(&file, &bytes)?;
        files.push(file);
    }
    Ok(files)
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
fn file_stem(name: &str) -> String {
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
    use super::file_stem;

    #[test]
    fn names_never_leave_the_folder() {
        assert_eq!(file_stem("golden-gate"), "golden-gate");
        assert_eq!(file_stem("../../etc/passwd"), "_.._etc_passwd");
        assert_eq!(file_stem(".."), "picture");
        assert_eq!(file_stem(""), "picture");
        assert_eq!(file_stem("a\0b\nc\\d"), "a_b_c_d");
    }
}
