//! Sums of many samples, and the integers that random numbers are made of.

use crate::common::{RECT, floor, scene, sums};
use crate::support::uniform;
use crate::table::{Case, Form, Row, Section};
use shearwater_shared::film::{
    BadCause, BadSample, FIXED_ONE, Half, TileFilm, TileSums, fixed_from_f32, rgb_to_fixed,
};
use shearwater_tracer::math::hash::u32_to_unit;
use shearwater_tracer::{BuildOptions, Scene};
use std::sync::OnceLock;

static SECTION: Section = Section::new(
    "Accumulation and random numbers",
    &[
        Case {
            name: "ten million equal samples",
            note: "Relative error of the sum. A running f32 sum of 0.1 would be 8.8 % too large; the step of 2^-24 itself \
                   gives 2.2e-7 for 0.1.",
            broken_by: "values rounded to 2^-19",
            rows: equal_samples,
        },
        Case {
            name: "samples below a firefly of 1e6",
            note: "Each keeps its own value exactly; in f32 everything below 1/32 is lost.",
            broken_by: "the film's sums kept in f32",
            rows: below_a_firefly,
        },
        Case {
            name: "orders of 16 parts",
            note: "Pixels of 4096 whose sum differs between one order and its reverse, or a rotation; f64 sums differ in 61 %.",
            broken_by: "the film's sums kept in f32",
            rows: orders,
        },
        Case {
            name: "bad samples",
            note: "Counted by cause, adding nothing, and still counted as samples.",
            broken_by: "negative values let through",
            rows: bad_samples,
        },
        Case {
            name: "u32 to [0, 1)",
            note: "1 must never come out: u * 2^-32 in f32 gives it for 129 of 2^32 inputs.",
            broken_by: "all 32 bits converted",
            rows: unit_interval,
        },
        Case {
            name: "independence of the two halves",
            note: "A floor under a lamp, 8 samples of each half, pixels of many seeds.",
            broken_by: "the half left out of the sampler's key",
            rows: half_correlation,
        },
        Case {
            name: "variance of the mean of 8 pictures",
            note: "8 times it over the variance of one: 1 for independent seeds. A seed that is repeated keeps the mean and \
                   makes this 8.",
            broken_by: "the seed left out of the sampler's key",
            rows: variance_of_the_mean,
        },
        Case {
            name: "a rare bright sample",
            note: "999 samples of 0.5 and one of 500: nothing is clamped; at 10 the mean would be half.",
            broken_by: "samples clamped at 100",
            rows: not_clamped,
        },
    ],
);

#[test]
fn accumulation() {
    SECTION.check();
}

fn equal_samples(_: Form) -> Vec<Row> {
    [0.1f32, 1.0 / 3.0, 2.7, 1.0]
        .into_iter()
        .map(|v| {
            let count = 10_000_000u32;
            let sum: i64 = (0..count)
                .map(|_| fixed_from_f32(std::hint::black_box(v)))
                .sum();
            let relative = sum as f64 / FIXED_ONE / (f64::from(v) * f64::from(count)) - 1.0;
            Row::near(format!("1e7 x {v}"), 0.0, relative, 5e-7)
        })
        .collect()
}

fn below_a_firefly(_: Form) -> Vec<Row> {
    // A part of one sample of each half.
    let part = |value: f32| {
        let mut part = TileSums::zero(1, &(0..1));
        part.radiance
            .iter_mut()
            .flatten()
            .for_each(|sum| *sum = fixed_from_f32(value));
        part
    };
    let bright = 1e6;
    [1.0 / 32.0, 1e-3, 1e-6f32]
        .into_iter()
        .map(|dark| {
            let mut film = TileFilm::zero(1);
            film.add(&part(bright)).expect("one pixel");
            for _ in 0..1000 {
                film.add(&part(dark)).expect("one pixel");
            }
            let kept = film.radiance[0][0] - i128::from(fixed_from_f32(bright));
            let kept = kept as f64 / fixed_from_f32(dark) as f64;
            Row::exact(format!("1000 x {dark}"), 1000.0, kept)
        })
        .collect()
}

/// Radiance of sample `i` of a pixel: many orders of magnitude.
fn skewed(pixel: u64, i: u64) -> f32 {
    let u = f64::from(uniform(31 + pixel, i));
    libm::exp(12.0 * u - 6.0) as f32
}

fn orders(_: Form) -> Vec<Row> {
    let pixels = 4096;
    let part = |number: u64| {
        let mut part = TileSums::zero(pixels, &(0..1));
        for (i, sum) in part.radiance.iter_mut().flatten().enumerate() {
            *sum = fixed_from_f32(skewed(number, i as u64));
        }
        part
    };
    let parts: Vec<TileSums> = (0..16).map(part).collect();
    let film = |order: &dyn Fn(usize) -> usize| {
        let mut film = TileFilm::zero(pixels);
        for i in 0..parts.len() {
            film.add(&parts[order(i)]).expect("equal shapes");
        }
        film
    };
    let straight = film(&|i| i);
    [
        ("reversed", film(&|i| 15 - i)),
        ("rotated", film(&|i| (i + 5) % 16)),
    ]
    .into_iter()
    .map(|(name, other)| {
        let differing = (0..pixels)
            .filter(|&p| straight.mean(p) != other.mean(p))
            .count();
        Row::exact(name, 0.0, differing as f64)
    })
    .collect()
}

fn bad_samples(_: Form) -> Vec<Row> {
    let samples = [
        [0.5, 0.5, 0.5],
        [f32::NAN, 0.5, 0.5],
        [0.5, f32::INFINITY, 0.5],
        [0.5, 0.5, -1e-30],
        [0.5, 1e9, 0.5],
        [0.5, 0.5, 0.5],
    ];
    let mut part = TileSums::zero(1, &(0..samples.len() as u32));
    for (index, sample) in samples.into_iter().enumerate() {
        match rgb_to_fixed(sample) {
            Ok(rgb) => {
                for half in &mut part.radiance {
                    half.iter_mut().zip(rgb).for_each(|(sum, v)| *sum += v);
                }
            }
            Err(cause) => {
                let (x, y, half, index) = (0, 0, Half::A, index as u32);
                part.bad.record(BadSample {
                    x,
                    y,
                    half,
                    index,
                    cause,
                });
            }
        }
    }
    let mut film = TileFilm::zero(1);
    film.add(&part).expect("one pixel");
    let listed = |cause| {
        film.bad
            .listed
            .iter()
            .filter(|bad| bad.cause == cause)
            .count() as f64
    };
    vec![
        Row::exact("mean of 2 x 0.5 among 6", 1.0 / 6.0, film.mean(0)[0]),
        Row::exact("NaN listed", 1.0, listed(BadCause::NotANumber)),
        Row::exact("infinite listed", 1.0, listed(BadCause::Infinite)),
        Row::exact("negative listed", 1.0, listed(BadCause::Negative)),
        Row::exact("too large listed", 1.0, listed(BadCause::Overflow)),
        Row::exact("counted", 4.0, film.bad.total() as f64),
    ]
}

fn unit_interval(_: Form) -> Vec<Row> {
    let highest = (0..1 << 16)
        .map(|i| u32_to_unit(u32::MAX - i))
        .fold(0.0, f32::max);
    let exact = |i: u32| f64::from(u32_to_unit(i << 8)) * FIXED_ONE == f64::from(i);
    let inexact = (0..1u32 << 24).step_by(101).filter(|&i| !exact(i)).count();
    vec![
        Row::exact(
            "1 less the largest, in steps of 2^-24",
            1.0,
            (1.0 - f64::from(highest)) * FIXED_ONE,
        ),
        Row::exact("steps that are not multiples of 2^-24", 0.0, inexact as f64),
    ]
}

/// A floor under a lamp in the sky: light samples, roulette, several bounces.
fn noisy(seed: u64) -> Scene {
    let body = format!(
        r#"{},"sky":{{"type":"map","file":"lamp.exr"}}"#,
        floor(r#"{"type":"phong","kd":[0.4,0.4,0.4],"ks":[0.4,0.4,0.4],"exponent":20}"#)
    );
    scene(
        &body,
        [0.0, 2.0, 3.0],
        [0.0; 3],
        20.0,
        seed,
        BuildOptions::default(),
    )
}

/// What [`noisy`] converges to, red by pixel.
fn reference(form: Form) -> &'static [f64] {
    static ONCE: OnceLock<Vec<f64>> = OnceLock::new();
    ONCE.get_or_init(|| {
        let [a, b] = halves(&noisy(1), 0..form.pick(512, 8192));
        a.iter().zip(&b).map(|(a, b)| 0.5 * (a + b)).collect()
    })
}

/// Red means of both halves, by pixel.
fn halves(scene: &Scene, samples: std::ops::Range<u32>) -> [Vec<f64>; 2] {
    let mut film = TileFilm::zero(RECT.pixels());
    film.add(&sums(scene, samples)).expect("fits");
    [0, 1].map(|half| {
        (0..RECT.pixels())
            .map(|p| film.half_mean(half, p)[0])
            .collect()
    })
}

fn half_correlation(form: Form) -> Vec<Row> {
    let (pictures, reference) = (form.pick(16, 64), reference(form));
    let (mut ab, mut aa, mut bb, mut count) = (0.0, 0.0, 0.0, 0.0);
    let mut equal = 0;
    for seed in 0..pictures {
        let [a, b] = halves(&noisy(100 + seed), 0..8);
        equal += usize::from(a == b);
        for (p, (a, b)) in a.iter().zip(&b).enumerate() {
            let mean = reference[p];
            ab += (a - mean) * (b - mean);
            aa += (a - mean) * (a - mean);
            bb += (b - mean) * (b - mean);
            count += 1.0;
        }
    }
    let correlation = ab / libm::sqrt(aa * bb);
    vec![
        Row::sampled(
            "corr(A - reference, B - reference)",
            0.0,
            correlation,
            4.0,
            1.0 / libm::sqrt(count),
            0.0,
        ),
        Row::exact("pictures with A = B", 0.0, f64::from(equal as u32)),
    ]
}

fn variance_of_the_mean(form: Form) -> Vec<Row> {
    let (groups, reference) = (form.pick(4, 48), reference(form));
    let (mut one, mut eight) = (vec![0.0; RECT.pixels()], vec![0.0; RECT.pixels()]);
    for group in 0..groups {
        let mut mean = vec![0.0; RECT.pixels()];
        for number in 0..8 {
            let [a, b] = halves(&noisy(1000 + 8 * group + number), 0..4);
            for p in 0..RECT.pixels() {
                let off = 0.5 * (a[p] + b[p]) - reference[p];
                one[p] += off * off;
                mean[p] += off / 8.0;
            }
        }
        for p in 0..RECT.pixels() {
            eight[p] += 8.0 * 8.0 * mean[p] * mean[p];
        }
    }
    // Pixels are independent of each other: the spread of their differences.
    let count = RECT.pixels() as f64;
    let size: f64 = one.iter().sum::<f64>() / count;
    let gaps: Vec<f64> = eight.iter().zip(&one).map(|(a, b)| a - b).collect();
    let gap = gaps.iter().sum::<f64>() / count;
    let spread = gaps.iter().map(|g| (g - gap) * (g - gap)).sum::<f64>() / count;
    let error = libm::sqrt(spread / count) / size;
    vec![Row::sampled(
        "quotient",
        1.0,
        1.0 + gap / size,
        4.0,
        error,
        0.0,
    )]
}

fn not_clamped(_: Form) -> Vec<Row> {
    let mut part = TileSums::zero(1, &(0..1000));
    for index in 0..1000 {
        let value = if index == 500 { 500.0 } else { 0.5 };
        let rgb = rgb_to_fixed([value; 3]).expect("light");
        for half in &mut part.radiance {
            half.iter_mut().zip(rgb).for_each(|(sum, v)| *sum += v);
        }
    }
    let mut film = TileFilm::zero(1);
    film.add(&part).expect("one pixel");
    vec![Row::near("mean", 0.9995, film.mean(0)[0], 1e-7)]
}
