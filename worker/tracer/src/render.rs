//! One run: the samples of a tile, summed exactly.

use crate::path::{LANES, PathResult, trace_batch};
use crate::sampler::PixelSampler;
use crate::scene::Scene;
use crate::uses;
use shearwater_shared::film::{
    BadSample, BrightnessTally, FEATURE_CHANNELS, Half, TileSums, feature_samples_of_half,
    fixed_from_f32, rgb_to_fixed,
};
use shearwater_shared::plan::TileRect;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// Render the samples `samples` of each half over `rect`, on the calling thread.
/// `None` when `cancel` was set meanwhile (looked at once per row of pixels).
///
/// The sums are a function of scene, pixels and sample indices alone.
#[must_use]
pub fn render_run(
    scene: &Scene,
    rect: &TileRect,
    samples: Range<u32>,
    cancel: &AtomicBool,
) -> Option<TileSums> {
    // Chosen once per run: see `uses`.
    match uses::copy_for(scene.uses()) {
        0 => render_tile::<0>(scene, rect, samples, cancel),
        #[cfg(feature = "effects")]
        8 => render_tile::<8>(scene, rect, samples, cancel),
        #[cfg(feature = "effects")]
        9 => render_tile::<9>(scene, rect, samples, cancel),
        #[cfg(feature = "effects")]
        10 => render_tile::<10>(scene, rect, samples, cancel),
        #[cfg(feature = "effects")]
        11 => render_tile::<11>(scene, rect, samples, cancel),
        #[cfg(feature = "effects")]
        12 => render_tile::<12>(scene, rect, samples, cancel),
        #[cfg(feature = "effects")]
        13 => render_tile::<13>(scene, rect, samples, cancel),
        #[cfg(feature = "effects")]
        14 => render_tile::<14>(scene, rect, samples, cancel),
        #[cfg(feature = "effects")]
        _ => render_tile::<15>(scene, rect, samples, cancel),
        #[cfg(not(feature = "effects"))]
        _ => None,
    }
}

fn render_tile<const USES: u8>(
    scene: &Scene,
    rect: &TileRect,
    samples: Range<u32>,
    cancel: &AtomicBool,
) -> Option<TileSums> {
    let mut sums = TileSums::zero(rect.pixels(), &samples);
    let mut tally = BrightnessTally::default();
    for row in 0..rect.height {
        if cancel.load(Ordering::Relaxed) {
            return None;
        }
        for column in 0..rect.width {
            let pixel = (row * rect.width + column) as usize;
            let at = (rect.x0 + column, rect.y0 + row);
            for half in Half::BOTH {
                let into = (&mut sums, &mut tally);
                render_pixel::<USES>(scene, at, half, samples.clone(), pixel, into);
            }
        }
    }
    sums.brightness = tally.finish();
    Some(sums)
}

fn render_pixel<const USES: u8>(
    scene: &Scene,
    (x, y): (u32, u32),
    half: Half,
    samples: Range<u32>,
    pixel: usize,
    (sums, tally): (&mut TileSums, &mut BrightnessTally),
) {
    let sampler = PixelSampler::new(
        scene.seed,
        scene.frame,
        half,
        x,
        y,
        scene.common.strategy.pattern,
    );
    let with_features = samples.start + feature_samples_of_half(&samples);
    let mut results = [PathResult::default(); LANES];
    // Of this pixel and half: added to the tile's once.
    let mut radiance = [0i64; 3];
    let mut index = samples.start;
    while index < samples.end {
        let count = (samples.end - index).min(LANES as u32) as usize;
        let streams: [_; LANES] = std::array::from_fn(|i| sampler.sample(index + i as u32));
        trace_batch::<USES>(scene, x, y, &streams[..count], &mut results);
        for (result, index) in results[..count].iter().zip(index..) {
            sums.depth_cap_hits += u64::from(result.depth_capped);
            match rgb_to_fixed(result.radiance.to_array()) {
                Ok(rgb) => {
                    tally.record(rgb.iter().sum());
                    radiance.iter_mut().zip(rgb).for_each(|(sum, v)| *sum += v);
                }
                Err(cause) => sums.bad.record(BadSample {
                    x,
                    y,
                    half,
                    index,
                    cause,
                }),
            }
            if index < with_features {
                add_features(sums, pixel, result);
            }
        }
        index += count as u32;
    }
    let sums = &mut sums.radiance[half.index()][3 * pixel..3 * pixel + 3];
    sums.iter_mut().zip(radiance).for_each(|(sum, v)| *sum += v);
}

// Once a sample, in each copy of the code: the compiler would make it a call.
#[inline(always)]
fn add_features(sums: &mut TileSums, pixel: usize, result: &PathResult) {
    let sum = &mut sums.features[FEATURE_CHANNELS * pixel..FEATURE_CHANNELS * (pixel + 1)];
    for (sum, value) in sum.iter_mut().zip(result.features) {
        *sum += fixed_from_f32(value);
    }
}
