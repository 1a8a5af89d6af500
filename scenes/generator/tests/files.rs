//! The committed files are those of the generator, byte for byte.

use shearwater_scenes::assets;
use std::path::Path;

/// All assets of a scene together stay below this, so that a clone stays light
/// and a worker fetches a scene in seconds.
const MOST_BYTES: usize = 25_000_000;

/// The four skies together.
const MOST_SKY_BYTES: usize = 6_000_000;

#[test]
fn committed_skies_equal_the_generated_ones() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../skies");
    let files = assets::skies().unwrap();
    for file in &files {
        let committed = std::fs::read(folder.join(file.path))
            .unwrap_or_else(|error| panic!("{}: {error}", file.path));
        assert!(
            committed == file.bytes,
            "{} differs from what the generator makes: run `cargo run --release \
             -p shearwater-scenes -- skies` and commit the result",
            file.path
        );
    }
    let total: usize = files.iter().map(|file| file.bytes.len()).sum();
    assert!(total < MOST_SKY_BYTES, "{total} bytes");
}

#[test]
fn committed_files_equal_the_generated_ones() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../golden-gate");
    let files = assets::golden_gate().unwrap();
    let mut total = 0;
    for file in &files {
        let committed = std::fs::read(folder.join(file.path))
            .unwrap_or_else(|error| panic!("{}: {error}", file.path));
        assert!(
            committed == file.bytes,
            "{} differs from what the generator makes: run `cargo run --release \
             -p shearwater-scenes -- golden-gate` and commit the result",
            file.path
        );
        total += committed.len();
    }
    assert!(total < MOST_BYTES, "{total} bytes");
    for entry in std::fs::read_dir(folder.join("assets")).unwrap() {
        let name = entry.unwrap().file_name();
        let path = format!("assets/{}", name.to_string_lossy());
        assert!(
            files.iter().any(|file| file.path == path),
            "{path} is not the generator's"
        );
    }
}
