//! Every input that the fuzz targets have kept, through the same code, without a
//! fuzzer: what once failed stays mended. `tests/fuzz/run` looks for more.

#[path = "../fuzz/bodies/lib.rs"]
mod bodies;

use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;

/// Most files and bytes of one target's corpus, as `tests/fuzz/run` keeps them.
const FILES_MAX: usize = 300;
const BYTES_MAX: usize = 1_100_000;

/// Crates of the fuzzers' lock file that the product has not.
const FUZZ_ONLY: [&str; 4] = ["arbitrary", "jobserver", "libfuzzer-sys", "shearwater-fuzz"];

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("fuzz")
}

fn replay(target: &str) {
    let (_, body) = bodies::TARGETS
        .into_iter()
        .find(|(name, _)| *name == target)
        .expect("target");
    let entries = std::fs::read_dir(folder().join("corpus").join(target)).expect("corpus");
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.expect("entry").path()).collect();
    files.sort();
    assert!((1..=FILES_MAX).contains(&files.len()), "{}", files.len());
    let mut bytes = 0;
    for file in files {
        let data = std::fs::read(&file).expect("file");
        bytes += data.len();
        let ended = catch_unwind(AssertUnwindSafe(|| body(&data)));
        assert!(ended.is_ok(), "{}", file.display());
    }
    bodies::end();
    assert!(bytes <= BYTES_MAX, "{bytes}");
}

#[test]
fn messages() {
    replay("wire");
}

#[test]
fn films() {
    replay("film");
}

#[test]
fn scenes() {
    replay("scene");
}

#[test]
fn meshes_and_materials() {
    replay("obj_mtl");
}

#[test]
fn pictures() {
    replay("images");
}

#[test]
fn requests() {
    replay("query");
}

// What is fuzzed is what is built.
#[test]
fn the_fuzzers_use_the_product_s_versions() {
    let packages = |path: PathBuf| -> BTreeSet<(String, String)> {
        let text = std::fs::read_to_string(path).expect("lock file");
        let of = |package: &str, key: &str| {
            let line = package.lines().find(|line| line.starts_with(key));
            line.unwrap_or_default().to_owned()
        };
        let packages = text.split("[[package]]").skip(1);
        packages
            .map(|package| (of(package, "name = "), of(package, "version = ")))
            .collect()
    };
    let ours = packages(folder().join("Cargo.lock"));
    let product = packages(folder().join("../../Cargo.lock"));
    let others: Vec<_> = ours
        .difference(&product)
        .filter(|(name, _)| {
            !FUZZ_ONLY
                .iter()
                .any(|only| *name == format!("name = \"{only}\""))
        })
        .collect();
    assert!(
        others.is_empty(),
        "`cargo update` in tests/fuzz: {others:?}"
    );
}
