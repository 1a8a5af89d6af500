//! Is the error that the halves estimate the error that the picture has?
//!
//! A fast form runs with the tests; `tests/calibration` runs the full one and
//! writes its table into docs/error.md.

#[path = "../radiance/common.rs"]
mod common;

mod document;
mod fireflies;
mod measure;
mod scenes;

use measure::{Measured, Ratio, calibrate};

/// How much work is put in.
struct Form {
    /// Pictures, each with a seed of its own.
    seeds: u64,
    /// Samples per pixel of the pictures.
    samples: &'static [u32],
    /// Samples of the reference, in those of the pictures with the most.
    reference: u32,
}

const FAST: Form = Form {
    seeds: 40,
    samples: &[16],
    reference: 64,
};
const FULL: Form = Form {
    seeds: 200,
    samples: &[16, 64],
    reference: 128,
};
/// How far a mean ratio may lie from 1 in the full form.
const TOLERANCE: f64 = 0.1;
/// The same of the relative error: in squares that are dark but for rare glints,
/// error and light are large in the same pictures, and their quotient lies low.
const RELATIVE_TOLERANCE: f64 = 0.2;

fn is_full() -> bool {
    std::env::var("CALIBRATION").is_ok_and(|form| form == "full")
}

// In the fast form, four standard errors: one false alarm in 15,800 ratios if the
// seeds were drawn anew; they are fixed.
fn assert_honest(what: &str, ratio: &Ratio, full_tolerance: f64) {
    let Ratio { value, error } = *ratio;
    let tolerance = if is_full() {
        full_tolerance
    } else {
        4.0 * error
    };
    assert!(
        (value - 1.0).abs() <= tolerance && error < 0.12,
        "{what}: estimated / true is {value} +- {error}"
    );
}

#[test]
fn the_estimated_error_is_the_true_error() {
    let form = if is_full() { FULL } else { FAST };
    let scenes = scenes::all();
    let rows: Vec<(&str, Vec<Measured>)> = std::thread::scope(|scope| {
        let threads: Vec<_> = scenes
            .iter()
            .map(|(name, view)| (*name, scope.spawn(|| calibrate(view, &form))))
            .collect();
        let join = |(name, thread): (_, std::thread::ScopedJoinHandle<'_, _>)| {
            (name, thread.join().expect("a scene that renders"))
        };
        threads.into_iter().map(join).collect()
    });
    document::write(&rows, &form, is_full());
    for (name, measured) in &rows {
        for row in measured {
            let what = format!("{name} at {} samples", row.samples);
            assert_honest(&format!("{what}, MSE"), &row.mse, TOLERANCE);
            assert_honest(&format!("{what}, NMSE"), &row.nmse, TOLERANCE);
            assert_honest(&format!("{what}, relMSE"), &row.relmse, RELATIVE_TOLERANCE);
            // 95 % of them; four standard deviations of a binomial, and a little
            // for the error of the reference.
            let spread = (0.95 * 0.05 / form.seeds as f64).sqrt();
            assert!(
                (row.covered - 0.95).abs() <= 4.0 * spread + 0.01,
                "{what}: {} of the intervals hold the mean",
                row.covered
            );
            assert_eq!(row.repeated, 0, "{what}: no seed is repeated");
        }
    }
}
