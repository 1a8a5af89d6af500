//! The sea's cost: `cargo bench -p shearwater-tracer --bench water`. One core; the
//! median of many runs, in milliseconds, and beside it FFTW if it is installed.

mod fftw;

use rayon::ThreadPoolBuilder;
use shearwater_shared::scene::{Water, Whitecaps, parse};
use shearwater_tracer::water::{SeaStage, SlopeMap, Spectrum};
use std::hint::black_box;
use std::time::Instant;

/// Runs of each measurement; the median is shown.
const RUNS: usize = 41;

fn main() {
    let Ok(one_core) = ThreadPoolBuilder::new().num_threads(1).build() else {
        eprintln!("no thread could be started");
        return;
    };
    println!("ms, one core, median of {RUNS} runs (fastest in brackets)");
    for n in [64, 256, 1024] {
        one_core.install(|| measure(n));
    }
}

fn measure(n: usize) {
    let Some(water) = sea(n) else {
        eprintln!("the bench's own scene is refused");
        return;
    };
    let Water::Tessendorf(sea) = &water else {
        return;
    };
    println!("{n} x {n}");
    show("waves, once a scene", || Spectrum::new(sea));
    let spectrum = Spectrum::new(sea);
    let mut time_s = 0.0;
    let mut next = || {
        time_s += 1.0 / 24.0;
        time_s
    };
    show("height and two slope maps at a time", || {
        spectrum.at(next())
    });
    let field = spectrum.at(1.0);
    show("levels of the slope maps", || {
        SlopeMap::new(n, &field.slope_x, &field.slope_z, &[])
    });
    let stage = SeaStage::new(&water, None);
    show("whole sea of a frame (slopes, levels)", || {
        stage.at(next(), 0.02, [0.0; 3])
    });
    let mut with_foam = sea.clone();
    with_foam.whitecaps = Some(Whitecaps {
        choppiness: 1.0,
        threshold: 0.5,
        softness: 0.3,
        albedo: [0.8; 3],
        roughness: 0.8,
    });
    let stage = SeaStage::new(&Water::Tessendorf(with_foam), None);
    show("the same with whitecaps", || {
        stage.at(next(), 0.02, [0.0; 3])
    });
    match fftw::Fftw::new(n) {
        None => println!("  FFTW is not installed (Debian: libfftw3-single3)"),
        Some(mut fftw) => show(
            "FFTW, f32, MEASURE: its three real transforms alone",
            || {
                fftw.run();
            },
        ),
    }
}

fn show<T>(what: &str, mut run: impl FnMut() -> T) {
    black_box(run());
    let mut times: Vec<f64> = (0..RUNS)
        .map(|_| {
            let start = Instant::now();
            black_box(run());
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    println!("  {what:<52} {:8.3} ({:.3})", times[RUNS / 2], times[0]);
}

fn sea(n: usize) -> Option<Water> {
    let scene = serde_json::json!({
        "version": 1, "name": "bench", "image": {"width": 16, "height": 16},
        "camera": {"position_m": [0, 9, 0], "target_m": [0, 9, -1], "vertical_fov_deg": 40},
        "water": {"type": "tessendorf", "grid": n, "tile_m": 160, "wind_speed_mps": 8}
    });
    parse(scene.to_string().as_bytes()).ok()?.water
}
