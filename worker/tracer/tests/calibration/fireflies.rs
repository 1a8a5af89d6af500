//! Rare bright samples: the estimate must not lie low, and the gauge must show it.

use crate::measure::{Reference, measure, ratio};
use crate::scenes;
use shearwater_shared::film::{Half, TileFilm, TileSums, fixed_from_f32, join_errors, tile_error};
use shearwater_tracer::math::hash::{hash_combine64, mix64};

const SIDE: usize = 32;
/// One sample in a thousand is 500, the others 0.5: mean 0.9995.
const CHANCE: f64 = 1e-3;
const BRIGHT: f64 = 500.0;
const DIM: f64 = 0.5;

fn film(seed: u64, samples_per_half: u32) -> TileFilm {
    let mut sums = TileSums::zero(SIDE * SIDE, &(0..samples_per_half));
    for half in Half::BOTH {
        for pixel in 0..SIDE * SIDE {
            for sample in 0..u64::from(samples_per_half) {
                let place = ((half.index() * SIDE * SIDE + pixel) as u64) << 32 | sample;
                let draw = mix64(hash_combine64(mix64(seed), place));
                let chance = (draw >> 11) as f64 / (1u64 << 53) as f64;
                let value = if chance < CHANCE { BRIGHT } else { DIM };
                let fixed = fixed_from_f32(value as f32);
                sums.brightness.record(3 * fixed);
                let sum = &mut sums.radiance[half.index()][3 * pixel..3 * pixel + 3];
                sum.iter_mut().for_each(|sum| *sum += fixed);
            }
        }
    }
    let mut film = TileFilm::zero(SIDE * SIDE);
    film.add(&sums).expect("one size");
    film
}

/// Estimated over true NMSE and relative MSE, and what dividing by the noisy pixel
/// gives in place of the latter.
struct Outcome {
    nmse: [f64; 2],
    relmse: [f64; 2],
    plug_in: f64,
    fireflies: f64,
}

fn outcome(samples_per_half: u32, seeds: u64) -> Outcome {
    let mean = CHANCE * BRIGHT + (1.0 - CHANCE) * DIM;
    let (mut nmse, mut relmse, mut plug_in, mut fireflies) = (vec![], vec![], 0.0, 0.0);
    for seed in 1..=seeds {
        let film = film(seed, samples_per_half);
        let estimate = join_errors(std::iter::once((0, tile_error(&film, SIDE))));
        let estimate = estimate.expect("samples").with_brightness(&film.brightness);
        let detail = estimate.detail.expect("new");
        let (mut truth, mut naive) = (0.0, 0.0);
        for pixel in 0..film.pixels() {
            let [a, b, m] = [
                film.half_mean(0, pixel),
                film.half_mean(1, pixel),
                film.mean(pixel),
            ]
            .map(|rgb| rgb[0]);
            truth += (m - mean) * (m - mean);
            naive += (a - b) * (a - b) / 4.0 / (m * m + 0.01);
        }
        truth /= film.pixels() as f64;
        nmse.push([estimate.nmse, truth / (mean * mean)]);
        relmse.push([detail.relmse, truth / (mean * mean + 0.01)]);
        plug_in += naive / film.pixels() as f64 / (truth / (mean * mean + 0.01));
        fireflies += detail.firefly_share.expect("light");
    }
    let both = |pairs: &[[f64; 2]]| {
        let ratio = ratio(pairs);
        [ratio.value, ratio.error]
    };
    Outcome {
        nmse: both(&nmse),
        relmse: both(&relmse),
        plug_in: plug_in / seeds as f64,
        fireflies: fireflies / seeds as f64,
    }
}

// The error must not be told too small by those who have not met a firefly yet.
// It may be told a little too large: the light that divides is noisy too, and
// bright fireflies make numerator and denominator large together less often than
// apart (E[1/x] > 1/E[x]).
#[test]
fn made_up_fireflies_do_not_make_the_error_look_small() {
    for (samples_per_half, seeds) in [(8, 100), (32, 60), (128, 30)] {
        let found = outcome(samples_per_half, seeds);
        println!(
            "{} samples: NMSE {:.3} +- {:.3}, relMSE {:.3} +- {:.3}, divided by the pixel {:.3}, gauge {:.4}",
            2 * samples_per_half,
            found.nmse[0],
            found.nmse[1],
            found.relmse[0],
            found.relmse[1],
            found.plug_in,
            found.fireflies
        );
        for [ratio, error] in [found.nmse, found.relmse] {
            assert!(
                ratio > 1.0 - 4.0 * error && ratio < 1.5,
                "{ratio} +- {error}"
            );
            assert!(error < 0.1, "{error}");
        }
        assert!(
            found.plug_in < 0.5,
            "or the test shows nothing: {}",
            found.plug_in
        );
        // The brightest 1e-4 of the samples are a tenth of the fireflies, which
        // carry half of the light: 500 times an even share.
        assert!(
            (found.fireflies / 0.05 - 1.0).abs() < 0.05,
            "{}",
            found.fireflies
        );
    }
}

// A lamp of 2000 times the sky that is found by chance alone: the same from a scene.
#[test]
fn rendered_fireflies_do_not_make_the_error_look_small() {
    let view = scenes::chance_hits();
    let reference = Reference::new(&view, 4096);
    for samples in [16, 64] {
        let found = measure(&view, &reference, 40, samples);
        println!(
            "{samples} samples: MSE {:?}, NMSE {:?}, relMSE {:?}, gauge {:.4}",
            found.mse, found.nmse, found.relmse, found.fireflies
        );
        assert!((found.mse.value - 1.0).abs() <= 4.0 * found.mse.error);
        // Where hardly any pixel has met the lamp in both halves, A * B is smaller
        // than the light: the relative errors lie high.
        for ratio in [found.nmse, found.relmse] {
            assert!(ratio.value > 1.0 - 4.0 * ratio.error, "{ratio:?}");
            assert!(ratio.error < 0.25 * ratio.value, "{ratio:?}");
        }
        assert!(found.fireflies > 0.02, "{}", found.fireflies);
    }
}

// The two halves of a repeated seed are one film twice: no difference, no error.
#[test]
fn a_repeated_seed_is_noticed() {
    let honest = film(1, 64);
    let mut repeated = honest.clone();
    repeated.radiance[1] = repeated.radiance[0].clone();
    let tiles = |film: &TileFilm| {
        let estimate = join_errors(std::iter::once((0, tile_error(film, SIDE))));
        let estimate = estimate.expect("samples");
        (
            estimate.nmse > 0.0,
            estimate.detail.expect("new").repeated_tiles,
        )
    };
    assert_eq!(tiles(&honest), (true, 0));
    let picture = crate::measure::render(&scenes::chance_hits(), 1, 64);
    assert_eq!(tiles(&picture.film), (true, 0));
    let mut rendered = picture.film;
    rendered.radiance[1] = rendered.radiance[0].clone();
    assert_eq!(tiles(&rendered), (false, 1));
}
