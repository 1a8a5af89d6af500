//! Writes the files of an example scene, or compares them with those on disk.

use shearwater_scenes::assets::{self, Asset};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const USAGE: &str = "\
Generates the assets of an example scene, bit for bit.

Usage: shearwater-scenes golden-gate [-o DIR] [--check]

  -o DIR    write below DIR (default: scenes/golden-gate)
  --check   write nothing; compare with the files below DIR

Exit codes: 0 done or equal, 1 different or failed, 2 wrong usage.
";

/// What the command line asks for.
struct Request {
    folder: PathBuf,
    check: bool,
}

fn main() -> ExitCode {
    let Some(request) = parse(std::env::args().skip(1)) else {
        eprint!("{USAGE}");
        return ExitCode::from(2);
    };
    match run(&request) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

fn parse(mut args: impl Iterator<Item = String>) -> Option<Request> {
    if args.next()? != "golden-gate" {
        return None;
    }
    let mut request = Request {
        folder: PathBuf::from("scenes/golden-gate"),
        check: false,
    };
    while let Some(arg) = args.next() {
        match arg.as_str() {
            "-o" => request.folder = PathBuf::from(args.next()?),
            "--check" => request.check = true,
            _ => return None,
        }
    }
    Some(request)
}

/// Whether everything is written, or equal.
fn run(request: &Request) -> Result<bool, String> {
    let files = assets::golden_gate().map_err(|error| error.to_string())?;
    let mut equal = true;
    for file in &files {
        let path = request.folder.join(file.path);
        if request.check {
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
