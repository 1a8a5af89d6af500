//! A scene up to its first pixels: everything that bytes of others can reach.

use shearwater_shared::hash::ContentHash;
use shearwater_shared::job::RenderSettings;
use shearwater_shared::plan::TileRect;
use shearwater_shared::scene::{SceneDescription, SceneError};
use shearwater_shared::stop::Stop;
use shearwater_tracer::{Assets, BuildOptions, Stage, render_run};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Columns and rows of the picture, of which the four in the middle are rendered.
const SIDE: u32 = 8;

/// Build a scene and render four pixels of one frame with two samples of each half.
///
/// # Errors
/// What the build says.
pub(super) fn render(
    scene: &SceneDescription,
    assets: &Assets,
    frame: u32,
) -> Result<(), SceneError> {
    let (stage, _) = Stage::build(scene, assets, BuildOptions::default())?;
    let settings = RenderSettings {
        width: SIDE,
        height: SIDE,
        samples: 4,
        seed: 1,
        frames: 1,
        first_frame: frame,
        stop: Stop::default(),
    };
    let scene = stage.frame(&settings, frame)?;
    let middle = TileRect {
        x0: SIDE / 2 - 1,
        y0: SIDE / 2 - 1,
        width: 2,
        height: 2,
    };
    let sums = render_run(&scene, &middle, 0..2, &AtomicBool::new(false));
    // What a coordinator would refuse must not come out.
    let sums = sums.expect("nobody cancels it");
    assert_eq!(sums.check(&middle, &(0..2)), Ok(()));
    Ok(())
}

/// One input in so many that need albedo tables is built: they take a tenth of a
/// second, a thousand times as long as the rest.
const TABLES_EVERY: u8 = 16;

/// Whether this input is one of those that are built although they need tables.
pub(super) fn may_need_tables(data: &[u8]) -> bool {
    ContentHash::of(data).as_bytes()[0].is_multiple_of(TABLES_EVERY)
}

/// Files by name.
pub(super) fn assets(files: &[(&str, &[u8])]) -> Assets {
    let files = files.iter();
    files
        .map(|&(name, bytes)| (name.to_owned(), Arc::from(bytes)))
        .collect()
}
