//! Names of what is stored: a hash of everything that it depends on.

use super::store;
use crate::measure::How;
use shearwater_tracer::{Assets, BUILD};

/// What a picture depends on, beside seed and number of samples.
pub(super) fn of_scene(scene: &[u8], assets: &Assets, (width, height): (u32, u32)) -> String {
    let size = [width.to_le_bytes(), height.to_le_bytes()].concat();
    let mut parts = vec![BUILD.as_bytes(), scene, &size];
    for (name, bytes) in assets {
        parts.push(name.as_bytes());
        parts.push(bytes);
    }
    store::key(&parts)
}

/// What a measurement depends on beside: how it is rendered, and against what.
pub(super) fn of_run(scene: &str, seed: u64, how: How, reference: &str) -> String {
    let how = format!("{} {} {} {seed}", how.threads, how.tile, how.block);
    store::key(&[scene.as_bytes(), how.as_bytes(), reference.as_bytes()])
}
