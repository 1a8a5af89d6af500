//! Pictures, their errors and their time on a core.

use shearwater_shared::film::TileFilm;
use shearwater_shared::job::RenderSettings;
use shearwater_shared::limits::TILE_SIDE;
use shearwater_shared::plan::TileRect;
use shearwater_tracer::{Scene, Stage, render_run};
use std::sync::atomic::AtomicBool;

/// Added to the square of the reference, so that black pixels divide by something.
const EPSILON: f64 = 0.01;
/// Share of the pixels that the trimmed error leaves out.
const WORST: f64 = 0.001;
/// Samples of each half in one run.
const RUN: u32 = 512;
/// Far from the seeds of what is measured.
const REFERENCE_SEED: u64 = 1 << 40;

/// What pixels are measured against.
pub(crate) struct Reference {
    /// RGB by pixel, tile by tile.
    rgb: Vec<[f64; 3]>,
    /// Its own error.
    pub(crate) rel_mse: f64,
}

/// Errors of some pictures.
#[derive(Default)]
pub(crate) struct Measured {
    /// Squared relative error of each pixel of each picture: a quarter of the
    /// squared difference of its halves, over the reference's square, mean of the
    /// channels. Unbiased, since the halves are independent.
    pub(crate) squares: Vec<f64>,
    /// On a core.
    pub(crate) seconds: f64,
}

/// Mean of all.
pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Mean without the worst pixels.
pub(crate) fn trimmed(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let kept = sorted.len() - (sorted.len() as f64 * WORST).ceil() as usize;
    mean(&sorted[..kept])
}

/// Ratio of two means and its standard error (linearised).
pub(crate) fn ratio(above: &[f64], below: &[f64]) -> (f64, f64) {
    let share = |values: &[f64]| {
        let mean = mean(values);
        let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
        let n = values.len() as f64;
        squares / (n * n) / (mean * mean)
    };
    let ratio = mean(above) / mean(below);
    (ratio, ratio * (share(above) + share(below)).sqrt())
}

/// Render the reference.
pub(crate) fn reference(stage: &Stage, size: (u32, u32), spp: u32) -> Result<Reference, String> {
    let scene = frame(stage, size, REFERENCE_SEED)?;
    let (mut rgb, mut sum) = (Vec::new(), 0.0);
    for rect in tiles(size) {
        let film = render(&scene, &rect, spp)?;
        for pixel in 0..rect.pixels() {
            let halves = [0, 1].map(|half| film.half_mean(half, pixel));
            let value = [0, 1, 2].map(|c| (halves[0][c] + halves[1][c]) / 2.0);
            sum += squared(halves, value);
            rgb.push(value);
        }
    }
    let rel_mse = sum / rgb.len() as f64;
    Ok(Reference { rgb, rel_mse })
}

/// One picture of each stage, tile by tile in turn, with seeds from `seed` on.
pub(crate) fn measure_together(
    stages: &[&Stage],
    size: (u32, u32),
    spp: u32,
    seed: u64,
    reference: &Reference,
    into: &mut [Measured],
) -> Result<(), String> {
    let scenes: Vec<Scene> = stages
        .iter()
        .zip(seed..)
        .map(|(stage, seed)| frame(stage, size, seed))
        .collect::<Result<_, _>>()?;
    let mut first = 0;
    for (number, rect) in tiles(size).into_iter().enumerate() {
        for turn in 0..scenes.len() {
            // Who goes first changes from tile to tile.
            let which = (turn + number) % scenes.len();
            let start = core_seconds()?;
            let film = render(&scenes[which], &rect, spp)?;
            into[which].seconds += core_seconds()? - start;
            for pixel in 0..rect.pixels() {
                let halves = [0, 1].map(|half| film.half_mean(half, pixel));
                let error = squared(halves, reference.rgb[first + pixel]);
                into[which].squares.push(error);
            }
        }
        first += rect.pixels();
    }
    Ok(())
}

fn squared(halves: [[f64; 3]; 2], reference: [f64; 3]) -> f64 {
    (0..3)
        .map(|c| {
            let difference = halves[0][c] - halves[1][c];
            difference * difference / 4.0 / (reference[c] * reference[c] + EPSILON)
        })
        .sum::<f64>()
        / 3.0
}

fn frame(stage: &Stage, (width, height): (u32, u32), seed: u64) -> Result<Scene, String> {
    let settings = RenderSettings {
        width,
        height,
        samples: 2,
        seed,
        frames: 1,
        first_frame: 0,
        stop: shearwater_shared::stop::Stop::NONE,
    };
    stage.frame(&settings, 0).map_err(|e| e.to_string())
}

fn render(scene: &Scene, rect: &TileRect, spp: u32) -> Result<TileFilm, String> {
    let mut film = TileFilm::zero(rect.pixels());
    let mut start = 0;
    while start < spp / 2 {
        let end = (start + RUN).min(spp / 2);
        let sums = render_run(scene, rect, start..end, &AtomicBool::new(false))
            .ok_or("this build has no effects")?;
        film.add(&sums).map_err(|e| e.to_string())?;
        start = end;
    }
    Ok(film)
}

fn tiles((width, height): (u32, u32)) -> Vec<TileRect> {
    let side = TILE_SIDE / 2;
    let rows = (0..height).step_by(side as usize);
    rows.flat_map(|y0| {
        (0..width).step_by(side as usize).map(move |x0| TileRect {
            x0,
            y0,
            width: side.min(width - x0),
            height: side.min(height - y0),
        })
    })
    .collect()
}

// Nanoseconds of this thread on a core, as Linux counts them.
fn core_seconds() -> Result<f64, String> {
    let path = "/proc/thread-self/schedstat";
    let text = std::fs::read_to_string(path).map_err(|e| format!("{path}: {e}"))?;
    let first = text.split_whitespace().next().ok_or("schedstat is empty")?;
    first
        .parse::<f64>()
        .map(|ns| ns * 1e-9)
        .map_err(|e| e.to_string())
}
