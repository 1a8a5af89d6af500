//! Estimated against true errors of one scene.

use crate::Form;
use crate::scenes::{SIDE, View};
use shearwater_shared::film::{ErrorEstimate, TileFilm, join_errors, tile_error};
use shearwater_shared::job::RenderSettings;
use shearwater_shared::limits::RUN_SAMPLES_PER_HALF_MAX;
use shearwater_shared::stop::Stop;
use shearwater_tracer::render_run;
use std::sync::atomic::AtomicBool;

/// Side of the squares of the relative error: as the estimate has them.
const SQUARE: usize = 16;
/// What the estimate adds to the light of a square before it divides.
const EPSILON: f64 = 0.01;
/// Of the reference; the pictures have 1, 2, ...
const REFERENCE_SEED: u64 = 1 << 40;
const PIXELS: usize = (SIDE * SIDE) as usize;

/// Mean estimated over mean true error of all seeds, and its standard error.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ratio {
    pub(crate) value: f64,
    pub(crate) error: f64,
}

/// One scene at one number of samples.
pub(crate) struct Measured {
    pub(crate) samples: u32,
    /// Mean of the true NMSE, to tell what the ratios are of.
    pub(crate) true_nmse: f64,
    pub(crate) mse: Ratio,
    pub(crate) nmse: Ratio,
    pub(crate) relmse: Ratio,
    /// Share of the 95 % intervals that hold the mean of the reference.
    pub(crate) covered: f64,
    /// Tiles taken for those of a repeated seed.
    pub(crate) repeated: u32,
    /// Mean of the firefly gauge.
    pub(crate) fireflies: f64,
}

/// A film and what its halves say.
pub(crate) struct Picture {
    pub(crate) film: TileFilm,
    pub(crate) estimate: ErrorEstimate,
}

/// Render the square with `samples` per pixel.
pub(crate) fn render(view: &View, seed: u64, samples: u32) -> Picture {
    let settings = RenderSettings {
        width: view.width,
        height: view.height,
        samples,
        seed,
        frames: 1,
        first_frame: 0,
        stop: Stop::NONE,
    };
    let scene = view.stage.frame(&settings, 0).expect("a frame");
    let mut film = TileFilm::zero(PIXELS);
    let step = RUN_SAMPLES_PER_HALF_MAX as usize;
    for from in (0..samples / 2).step_by(step) {
        let run = from..(from + RUN_SAMPLES_PER_HALF_MAX).min(samples / 2);
        let cancel = AtomicBool::new(false);
        let sums = render_run(&scene, &view.rect, run.clone(), &cancel).expect("not cancelled");
        sums.check(&view.rect, &run).expect("sums that can be");
        film.add(&sums).expect("one size");
    }
    let tile = tile_error(&film, SIDE as usize);
    let estimate = join_errors(std::iter::once((0, tile))).expect("samples");
    let estimate = estimate.with_brightness(&film.brightness);
    Picture { film, estimate }
}

/// What the errors are held against, its own error known.
pub(crate) struct Reference {
    mean: Vec<[f64; 3]>,
    variance: Vec<f64>,
    luminance: f64,
}

impl Reference {
    pub(crate) fn new(view: &View, samples: u32) -> Self {
        let picture = render(view, REFERENCE_SEED, samples);
        let variance = |pixel: usize| {
            let [a, b] = [0, 1].map(|half| picture.film.half_mean(half, pixel));
            (0..3).map(|c| (a[c] - b[c]) * (a[c] - b[c]) / 4.0).sum()
        };
        Self {
            mean: (0..PIXELS).map(|p| picture.film.mean(p)).collect(),
            variance: (0..PIXELS).map(variance).collect(),
            luminance: picture.estimate.detail.expect("new").mean,
        }
    }

    /// True MSE, NMSE and relative MSE of a picture, the reference's own error taken
    /// off.
    pub(crate) fn errors(&self, film: &TileFilm) -> [f64; 3] {
        let side = SIDE as usize;
        let squares = side.div_ceil(SQUARE);
        let mut sums = vec![[0.0; 3]; squares * squares];
        for pixel in 0..PIXELS {
            let (x, y) = (pixel % side, pixel / side);
            let [error, light, values] = &mut sums[y / SQUARE * squares + x / SQUARE];
            *error -= self.variance[pixel];
            *values += 3.0;
            for (v, r) in film.mean(pixel).into_iter().zip(self.mean[pixel]) {
                *error += (v - r) * (v - r);
                *light += r * r;
            }
        }
        let total = |i: usize| sums.iter().map(|square| square[i]).sum::<f64>();
        let relative = sums.iter().map(|[e, l, n]| n * e / (l + EPSILON * n));
        [
            total(0) / total(2),
            total(0) / total(1),
            relative.sum::<f64>() / total(2),
        ]
    }
}

/// Every number of samples of `form`.
pub(crate) fn calibrate(view: &View, form: &Form) -> Vec<Measured> {
    let most = form.samples.iter().max().copied().unwrap_or(0);
    let reference = Reference::new(view, form.reference * most);
    let samples = form.samples.iter();
    samples
        .map(|&samples| measure(view, &reference, form.seeds, samples))
        .collect()
}

/// `seeds` pictures of `samples` per pixel.
pub(crate) fn measure(view: &View, reference: &Reference, seeds: u64, samples: u32) -> Measured {
    let mut pairs: [Vec<[f64; 2]>; 3] = Default::default();
    let (mut covered, mut repeated, mut fireflies) = (0u32, 0, 0.0);
    for seed in 1..=seeds {
        let picture = render(view, seed, samples);
        let detail = picture.estimate.detail.expect("new");
        let estimated = [picture.estimate.mse, picture.estimate.nmse, detail.relmse];
        let truth = reference.errors(&picture.film);
        for (pairs, pair) in pairs.iter_mut().zip(estimated.into_iter().zip(truth)) {
            pairs.push([pair.0, pair.1]);
        }
        let off = (detail.mean - reference.luminance).abs();
        covered += u32::from(off <= detail.mean_interval);
        repeated += detail.repeated_tiles;
        fireflies += detail.firefly_share.expect("light");
    }
    let [mse, nmse, relmse] = [0, 1, 2].map(|i| ratio(&pairs[i]));
    let count = seeds as f64;
    Measured {
        samples,
        true_nmse: pairs[1].iter().map(|pair| pair[1]).sum::<f64>() / count,
        mse,
        nmse,
        relmse,
        covered: f64::from(covered) / count,
        repeated,
        fireflies: fireflies / count,
    }
}

/// Mean estimated over mean true error; the spread of `estimated - ratio * true`
/// gives its standard error (to first order).
pub(crate) fn ratio(pairs: &[[f64; 2]]) -> Ratio {
    let count = pairs.len() as f64;
    let mean = |i: usize| pairs.iter().map(|pair| pair[i]).sum::<f64>() / count;
    let value = mean(0) / mean(1);
    let square = |[estimated, truth]: &[f64; 2]| {
        let off = estimated - value * truth;
        off * off
    };
    let variance = pairs.iter().map(square).sum::<f64>() / (count - 1.0);
    Ratio {
        value,
        error: (variance / count).sqrt() / mean(1),
    }
}
