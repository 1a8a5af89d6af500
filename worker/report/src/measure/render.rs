//! Threads that render a frame and look at their clocks.

use super::{FrameSums, thread_cpu_seconds};
use shearwater_shared::plan::TileRect;
use shearwater_tracer::{Scene, render_run};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How a frame is cut and by how many it is rendered. None of it changes the sums.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct How {
    /// Threads, at least 1.
    pub threads: u16,
    /// Side of a tile in pixels, at least 1.
    pub tile: u32,
    /// Sample indices per half of one run, at least 1.
    pub block: u32,
}

/// What rendering has cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spent {
    /// Time on cores, over all render threads, in seconds.
    pub core_s: f64,
    /// Time on the clock, in seconds.
    pub wall_s: f64,
}

/// Why there are no sums.
#[derive(Debug, thiserror::Error)]
pub enum MeasureError {
    /// Somebody set `cancel`.
    #[error("interrupted")]
    Cancelled,
    /// A render thread could not start, or panicked.
    #[error("a render thread failed: {0}")]
    Thread(String),
}

/// How often whoever waits is told of progress.
const PROGRESS: Duration = Duration::from_secs(1);

struct Work<'a> {
    scene: &'a Scene,
    rects: Vec<TileRect>,
    from: u32,
    to: u32,
    block: u32,
    cancel: &'a AtomicBool,
    next: AtomicUsize,
    done_samples: AtomicU64,
    sums: Mutex<&'a mut FrameSums>,
}

/// Render the sample indices from those that `sums` has up to `to` of each half, and add
/// them. `progress` hears now and then how many samples (pixels x indices x halves) are
/// done.
///
/// # Errors
/// [`MeasureError`]; `sums` are then worthless.
pub fn render_more(
    scene: &Scene,
    sums: &mut FrameSums,
    to: u32,
    how: How,
    cancel: &AtomicBool,
    progress: &mut dyn FnMut(u64),
) -> Result<Spent, MeasureError> {
    let from = sums.samples_per_half;
    if to <= from {
        return Ok(Spent::default());
    }
    let work = Work {
        scene,
        rects: tiles(sums.width, sums.height, how.tile.max(1)),
        from,
        to,
        block: how.block.max(1),
        cancel,
        next: AtomicUsize::new(0),
        done_samples: AtomicU64::new(0),
        sums: Mutex::new(sums),
    };
    let spent = run_threads(&work, how.threads.max(1), progress)?;
    if cancel.load(Ordering::Relaxed) {
        return Err(MeasureError::Cancelled);
    }
    sums.samples_per_half = to;
    Ok(spent)
}

fn run_threads(
    work: &Work<'_>,
    threads: u16,
    progress: &mut dyn FnMut(u64),
) -> Result<Spent, MeasureError> {
    let began = Instant::now();
    let waiting = std::thread::current();
    let left = AtomicUsize::new(threads.into());
    std::thread::scope(|scope| {
        let mut handles = Vec::new();
        for number in 0..threads {
            let (waiting, left) = (&waiting, &left);
            let body = move || {
                // Told even by a thread that panics.
                let _end = AtEnd(|| {
                    left.fetch_sub(1, Ordering::AcqRel);
                    waiting.unpark();
                });
                let before = thread_cpu_seconds();
                render_runs(work);
                (thread_cpu_seconds() - before, began.elapsed().as_secs_f64())
            };
            let spawned = std::thread::Builder::new()
                .name(format!("measure-{number}"))
                .spawn_scoped(scope, body);
            match spawned {
                Ok(handle) => handles.push(handle),
                Err(error) => {
                    work.cancel.store(true, Ordering::Relaxed);
                    return Err(MeasureError::Thread(error.to_string()));
                }
            }
        }
        while left.load(Ordering::Acquire) > 0 {
            std::thread::park_timeout(PROGRESS);
            progress(work.done_samples.load(Ordering::Relaxed));
        }
        let mut spent = Spent::default();
        for handle in handles {
            let (core_s, wall_s) = handle
                .join()
                .map_err(|_| MeasureError::Thread("panic".to_owned()))?;
            spent.core_s += core_s;
            spent.wall_s = spent.wall_s.max(wall_s);
        }
        Ok(spent)
    })
}

struct AtEnd<F: FnMut()>(F);

impl<F: FnMut()> Drop for AtEnd<F> {
    fn drop(&mut self) {
        (self.0)();
    }
}

fn render_runs(work: &Work<'_>) {
    let blocks = (work.to - work.from).div_ceil(work.block) as usize;
    loop {
        let number = work.next.fetch_add(1, Ordering::Relaxed);
        let Some(rect) = work.rects.get(number / blocks) else {
            return;
        };
        let first = work.from + (number % blocks) as u32 * work.block;
        let samples = first..(first + work.block).min(work.to);
        let count = rect.pixels() as u64 * 2 * u64::from(samples.end - samples.start);
        let Some(part) = render_run(work.scene, rect, samples, work.cancel) else {
            return;
        };
        let mut sums = work.sums.lock().unwrap_or_else(PoisonError::into_inner);
        sums.add(rect, &part);
        drop(sums);
        work.done_samples.fetch_add(count, Ordering::Relaxed);
    }
}

fn tiles(width: u32, height: u32, side: u32) -> Vec<TileRect> {
    let starts = |length: u32| (0..length).step_by(side as usize);
    starts(height)
        .flat_map(|y0| starts(width).map(move |x0| (x0, y0)))
        .map(|(x0, y0)| TileRect {
            x0,
            y0,
            width: side.min(width - x0),
            height: side.min(height - y0),
        })
        .collect()
}
