//! Gives the tracer a name for its arithmetic: a hash over every source that can
//! change a bit of a picture. Workers of one farm must agree on it.

use std::path::{Path, PathBuf};

fn main() {
    println!("cargo::rerun-if-changed=src");
    println!("cargo::rerun-if-changed=../../shared/src");
    println!("cargo::rerun-if-changed=../../Cargo.lock");
    println!("cargo::rerun-if-changed=../../Cargo.toml");
    // Versions, features and profile; then the sources themselves.
    let mut files = vec![
        PathBuf::from("../../Cargo.lock"),
        PathBuf::from("../../Cargo.toml"),
        PathBuf::from("Cargo.toml"),
    ];
    collect(Path::new("src"), &mut files);
    collect(Path::new("../../shared/src"), &mut files);
    files.sort();
    let mut hasher = blake3::Hasher::new();
    for file in &files {
        let Ok(bytes) = std::fs::read(file) else {
            continue;
        };
        hasher.update(file.to_string_lossy().as_bytes());
        hasher.update(&(bytes.len() as u64).to_le_bytes());
        hasher.update(&bytes);
    }
    // The compiler: its library shapes the trees (selection) and its code the bits.
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    if let Ok(version) = std::process::Command::new(rustc).arg("--version").output() {
        hasher.update(&version.stdout);
    }
    let name = hasher.finalize().to_hex();
    println!("cargo::rustc-env=SHEARWATER_TRACER_BUILD={}", &name[..16]);
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            files.push(path);
        }
    }
}
