//! References: many samples of another seed.

use super::bias::Held;
use super::point::{Reference, ReferenceError, own_errors};
use super::prepare::Prepared;
use super::progress::Progress;
use super::store::{Store, key};
use super::{Options, StudyError};
use crate::measure::{FrameSums, How, MeasureError, render_more};
use std::sync::atomic::AtomicBool;

/// Not a seed that anybody takes by chance.
const REFERENCE_SEED: u64 = 0x7265_6665_7265_6e63;

/// A reference without an answer ends one variant, not the study.
pub(super) enum NoReference {
    Study(StudyError),
    Variant(String),
}

/// The reference of a prepared scene: from the store, else rendered.
pub(super) fn rendered(
    prepared: &Prepared,
    options: &Options,
    store: &Store,
    cancel: &AtomicBool,
    progress: &mut Progress<'_>,
) -> Result<Reference, NoReference> {
    let (width, height) = prepared.size;
    let name = format!("reference-{}.sums", prepared.key);
    let pixels = u64::from(width) * u64::from(height);
    let target = (options.reference_spp / 2).max(1);
    let fresh = || FrameSums::zero(width, height);
    let mut sums = store
        .read_sums(&name, prepared.size)
        .filter(|sums| sums.samples_per_half <= target)
        .unwrap_or_else(fresh);
    progress.skip(2 * pixels * u64::from(sums.samples_per_half));
    if sums.samples_per_half < target {
        let scene = prepared
            .frame(options.reference_spp, REFERENCE_SEED)
            .map_err(NoReference::Variant)?;
        let how = How {
            threads: options.threads,
            tile: 64,
            block: 64,
        };
        let text = format!(
            "{}: reference of {} spp",
            prepared.name, options.reference_spp
        );
        // Kept now and then, at each quarter: an interruption loses little.
        let step = target.div_ceil(4).max(1);
        while sums.samples_per_half < target {
            let from = sums.samples_per_half;
            let to = (from + step).min(target);
            let mut alive = |running| progress.alive(&text, running);
            render_more(&scene, &mut sums, to, how, cancel, &mut alive).map_err(|e| match e {
                MeasureError::Cancelled => NoReference::Study(StudyError::Cancelled),
                MeasureError::Thread(_) => NoReference::Variant(e.to_string()),
            })?;
            progress.finish(2 * pixels * u64::from(to - from));
            store
                .write(&name, &sums.encode())
                .map_err(|e| NoReference::Study(e.into()))?;
        }
        progress.say(&text);
    }
    let rgb = sums.mean();
    let (mse, rel_mse) = own_errors(&sums.half_difference(), &rgb);
    Ok(Reference {
        rgb,
        held: Held::halves(&sums),
        about: ReferenceError {
            spp: Some(2 * sums.samples_per_half),
            file: None,
            mse: Some(mse),
            rel_mse: Some(rel_mse),
        },
        key: format!("{} {target}", prepared.key),
    })
}

/// The reference that the user gives; `None` when there is none.
pub(super) fn given(
    options: &Options,
    (width, height): (u32, u32),
) -> Option<Result<Reference, String>> {
    let (file, picture) = options.reference.as_ref()?;
    if (picture.width, picture.height) != (width as usize, height as usize) {
        let message = format!("{file}: {}: expected {width}x{height}", picture.size());
        return Some(Err(message));
    }
    let bytes: Vec<u8> = picture
        .rgb
        .iter()
        .flatten()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    Some(Ok(Reference {
        rgb: picture.rgb.clone(),
        held: Held::exact(&picture.rgb),
        about: ReferenceError {
            spp: None,
            file: Some(file.clone()),
            mse: None,
            rel_mse: None,
        },
        key: key(&[&bytes]),
    }))
}
