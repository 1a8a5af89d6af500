//! The lists that come with the scenes.

use super::{parse_variants, patched};
use shearwater_shared::scene;
use std::collections::BTreeSet;
use std::path::PathBuf;

/// A list, and a scene that it is meant for.
const LISTS: [(&str, &str); 6] = [
    ("reflectance.json", "reflectance/ggx.json"),
    ("sampling.json", "golden-gate/scene.json"),
    ("sampling.json", "metal/scene.json"),
    ("threads.json", "golden-gate/scene.json"),
    ("volumes.json", "clouds/volume.json"),
    ("water.json", "golden-gate/scene.json"),
];

fn scenes() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes"))
}

#[test]
fn every_list_makes_valid_scenes() {
    let mut named = BTreeSet::new();
    for (list, file) in LISTS {
        named.insert(list.to_owned());
        let json = std::fs::read(scenes().join("variants").join(list)).expect(list);
        let plain = std::fs::read(scenes().join(file)).expect(file);
        let variants = parse_variants(list, &json).expect(list);
        let mut seen = BTreeSet::new();
        for variant in &variants {
            let what = format!("{list}: {}", variant.name);
            let changed = patched(&plain, variant).expect(&what);
            if let Err(error) = scene::parse(&changed) {
                panic!("{what}: {error}");
            }
            // A variant that changes nothing but its name would be measured twice.
            let how = (variant.threads, variant.tile, variant.block);
            assert!(seen.insert((changed, how)), "{what}: as another one");
        }
    }
    let folder = std::fs::read_dir(scenes().join("variants")).expect("folder");
    let files: BTreeSet<String> = folder
        .map(|entry| entry.expect("entry").file_name().to_string_lossy().into())
        .collect();
    assert_eq!(files, named, "every list is tried here");
}
