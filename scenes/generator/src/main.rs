//! Writes the files of an example scene, or compares them with those on disk; makes
//! the gallery.

use shearwater_scenes::assets::{self, Asset};
use shearwater_scenes::cloud_scenes;
use shearwater_scenes::gallery;
use shearwater_scenes::image_files::EncodeError;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const USAGE: &str = "\
Generates the assets of the example scenes, bit for bit, and the gallery.

Usage: shearwater-scenes SCENE [-o DIR] [--check]
       shearwater-scenes gallery [--only NAME] [--shearwater PROGRAM]

  SCENE         golden-gate, clouds, skies
  -o DIR        write below DIR (default: the scene's folder under scenes/)
  --check       write nothing; compare with the files below DIR
  --only NAME   render only pictures with NAME in their name
  --shearwater  the program that renders (default: target/release/shearwater)

Exit codes: 0 done or equal, 1 different or failed, 2 wrong usage.
";

type Files = fn() -> Result<Vec<Asset>, EncodeError>;

/// What can be generated: name, folder, files.
const SCENES: [(&str, &str, Files); 3] = [
    ("golden-gate", "scenes/golden-gate", assets::golden_gate),
    ("clouds", "scenes/clouds", cloud_scenes::clouds),
    ("skies", "scenes/skies", assets::skies),
];

/// What the command line asks for.
enum Request {
    Scene {
        files: Files,
        folder: PathBuf,
        check: bool,
    },
    Gallery {
        program: PathBuf,
        only: Option<String>,
    },
}

fn main() -> ExitCode {
    let Some(request) = parse(std::env::args().skip(1)) else {
        eprint!("{USAGE}");
        return ExitCode::from(2);
    };
    let done = match request {
        Request::Scene {
            files,
            folder,
            check,
        } => run(files, &folder, check),
        Request::Gallery { program, only } => gallery::make(&program, only.as_deref())
            .map(|()| true)
            .map_err(|error| error.to_string()),
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

fn parse(mut args: impl Iterator<Item = String>) -> Option<Request> {
    let name = args.next()?;
    if name == "gallery" {
        return parse_gallery(args);
    }
    let (_, folder, files) = SCENES.into_iter().find(|(scene, ..)| *scene == name)?;
    let (mut folder, mut check) = (PathBuf::from(folder), false);
    while let Some(arg) = args.next() {
        match arg.as_str() {
            "-o" => folder = PathBuf::from(args.next()?),
            "--check" => check = true,
            _ => return None,
        }
    }
    Some(Request::Scene {
        files,
        folder,
        check,
    })
}

fn parse_gallery(mut args: impl Iterator<Item = String>) -> Option<Request> {
    let (mut program, mut only) = (PathBuf::from("target/release/shearwater"), None);
    while let Some(arg) = args.next() {
        match arg.as_str() {
            "--only" => only = Some(args.next()?),
            "--shearwater" => program = PathBuf::from(args.next()?),
            _ => return None,
        }
    }
    Some(Request::Gallery { program, only })
}

/// Whether everything is written, or equal.
fn run(files: Files, folder: &Path, check_only: bool) -> Result<bool, String> {
    let files = files().map_err(|error| error.to_string())?;
    let mut equal = true;
    for file in &files {
        let path = folder.join(file.path);
        if check_only {
            equal &= check(file, &path);
        } else {
            write(file, &path)?;
        }
    }
    Ok(equal)
}

fn check(file: &Asset, path: &Path) -> bool {
    let same = std::fs::read(path).is_ok_and(|bytes| bytes == file.bytes);
    let verdict = if same {
        "equal"
    } else {
        "DIFFERENT or missing"
    };
    println!("{verdict:<20} {}", path.display());
    same
}

fn write(file: &Asset, path: &Path) -> Result<(), String> {
    let fail = |error: std::io::Error| format!("cannot write {}: {error}", path.display());
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(fail)?;
    }
    std::fs::write(path, &file.bytes).map_err(fail)?;
    println!("{:>10} bytes  {}", file.bytes.len(), path.display());
    Ok(())
}
