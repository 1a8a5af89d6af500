//! B = I + strength K * max(I - T, 0): its exact identities.

use std::time::{Duration, Instant};

use shearwater_coordinator::develop::{Bloom, apply_bloom};

use crate::pictures::noisy;

/// Settings whose box has half-width `radius_px` in a picture of this height.
pub(crate) fn bloom(threshold: f32, strength: f32, radius_px: usize, height: u32) -> Bloom {
    Bloom {
        threshold,
        strength,
        radius: radius_px as f32 / height as f32,
        passes: 1,
    }
}

pub(crate) fn apply(beauty: &[[f32; 3]], width: u32, height: u32, bloom: &Bloom) -> Vec<[f32; 3]> {
    apply_bloom(beauty, width, height, Some(bloom)).unwrap().rgb
}

pub(crate) fn bits(rgb: &[[f32; 3]]) -> Vec<[u32; 3]> {
    rgb.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

fn close(value: f32, expected: f64, tolerance: f64) {
    let error = (f64::from(value) - expected).abs();
    assert!(
        error <= tolerance * expected.abs(),
        "{value} is not {expected} within {tolerance}"
    );
}

/// The definition, written out: clamped coordinates, every window added up.
fn by_definition(beauty: &[[f32; 3]], width: i64, height: i64, r: i64, s: &Bloom) -> Vec<[f64; 3]> {
    let excess = |x: i64, y: i64, c: usize| {
        let index = y.clamp(0, height - 1) * width + x.clamp(0, width - 1);
        (f64::from(beauty[index as usize][c]) - f64::from(s.threshold)).max(0.0)
    };
    let area = ((2 * r + 1) * (2 * r + 1)) as f64;
    let mut out = Vec::new();
    for y in 0..height {
        for x in 0..width {
            out.push([0, 1, 2].map(|c| {
                let mut sum = 0.0;
                for v in y - r..=y + r {
                    for u in x - r..=x + r {
                        sum += excess(u, v, c);
                    }
                }
                let value = f64::from(beauty[(y * width + x) as usize][c]);
                value + f64::from(s.strength) * sum / area
            }));
        }
    }
    out
}

#[test]
fn any_size_and_radius_follow_the_definition() {
    // Radii beyond the width, cut-off blocks, single rows and columns.
    let cases = [
        (1, 1, 1),
        (1, 9, 4),
        (17, 1, 1),
        (5, 12, 11),
        (12, 7, 2),
        (23, 16, 5),
        (16, 16, 16),
    ];
    for (width, height, radius_px) in cases {
        let settings = bloom(0.9, 1.3, radius_px, height);
        let beauty = noisy(width, height, 7 + u64::from(width));
        let out = apply(&beauty, width, height, &settings);
        let (w, h, r) = (i64::from(width), i64::from(height), radius_px as i64);
        for (got, want) in out.iter().zip(by_definition(&beauty, w, h, r, &settings)) {
            for c in 0..3 {
                close(got[c], want[c], 1.2e-7);
            }
        }
    }
}

#[test]
fn non_finite_values_are_counted_kept_and_do_not_spread() {
    let mut beauty = vec![[2.0_f32; 3]; 40 * 30];
    beauty[15 * 40 + 20] = [f32::INFINITY, f32::NAN, 2.0];
    beauty[3] = [2.0, 2.0, f32::NEG_INFINITY];
    let out = apply_bloom(&beauty, 40, 30, Some(&bloom(1.0, 0.5, 4, 30))).unwrap();
    assert_eq!(out.non_finite_values, 3);
    for (i, (before, after)) in beauty.iter().zip(&out.rgb).enumerate() {
        for c in 0..3 {
            if before[c].is_finite() {
                let share = (after[c] - 2.0) / 0.5;
                // At most one of the window's 81 values (nine copies of a
                // border pixel's row) is missing.
                assert!((0.88..=1.000_001).contains(&share), "pixel {i}: {share}");
            } else {
                assert_eq!(before[c].to_bits(), after[c].to_bits());
            }
        }
    }
}

#[test]
fn finite_input_stays_finite() {
    let out = apply(&[[f32::MAX; 3]; 9], 3, 3, &bloom(1.0, 100.0, 1, 3));
    assert!(out.iter().flatten().all(|&value| value == f32::MAX));
}

#[test]
fn glow_scales_with_the_resolution() {
    // The same bright square at one and two times the resolution.
    let glow = |scale: usize| {
        let side = 64 * scale;
        let mut beauty = vec![[0.0_f32; 3]; side * side];
        for y in 28 * scale..36 * scale {
            for x in 28 * scale..36 * scale {
                beauty[y * side + x] = [101.0; 3];
            }
        }
        let settings = Bloom {
            threshold: 1.0,
            strength: 1.0,
            radius: 0.1,
            passes: 1,
        };
        let out = apply(&beauty, side as u32, side as u32, &settings);
        move |x: usize, y: usize| {
            let mut sum = 0.0;
            for v in y * scale..(y + 1) * scale {
                for u in x * scale..(x + 1) * scale {
                    sum += f64::from(out[v * side + u][0] - beauty[v * side + u][0]);
                }
            }
            sum / (scale * scale) as f64
        }
    };
    let (low, high) = (glow(1), glow(2));
    let radius_px = 6.0; // round(0.1 * 64)
    // Windows that hold the whole square: its plateau, away from the rim.
    for (x, y) in [(31, 31), (30, 32), (33, 30), (31, 33)] {
        let (low, high) = (low(x, y), high(x, y));
        assert!(low > 1.0);
        assert!(
            (low / high - 1.0).abs() < 4.0 / (2.0 * radius_px + 1.0),
            "{low} {high}"
        );
    }
}

#[test]
fn more_passes_keep_the_spread_and_round_the_halo() {
    let (side, radius_px) = (201_usize, 30_usize);
    let mut beauty = vec![[0.0_f32; 3]; side * side];
    beauty[100 * side + 100] = [1e6; 3];
    let moments = |passes: u32| {
        let settings = Bloom {
            passes,
            ..bloom(0.0, 1.0, radius_px, side as u32)
        };
        let out = apply(&beauty, side as u32, side as u32, &settings);
        let halo = |x: usize, y: usize| match (x, y) {
            (100, 100) => f64::from(out[y * side + x][0] - 1e6),
            _ => f64::from(out[y * side + x][0]),
        };
        let (mut sum, mut second) = (0.0, 0.0);
        for y in 0..side {
            for x in 0..side {
                let dx = x as f64 - 100.0;
                sum += halo(x, y);
                second += halo(x, y) * dx * dx;
            }
        }
        // Along the axis and the diagonal, about 32 pixels from the centre.
        (
            second / sum,
            halo(100 + 32, 100) / halo(100 + 23, 100 + 23).max(1e-9),
        )
    };
    let variance = (radius_px * (radius_px + 1)) as f64 / 3.0;
    for passes in 1..=3 {
        let (spread, roundness) = moments(passes);
        assert!(
            (spread / variance - 1.0).abs() < 0.06,
            "{passes}: {spread} {variance}"
        );
        match passes {
            1 => assert!(roundness < 1e-6, "a box has corners: {roundness}"),
            3 => assert!((0.9..1.1).contains(&roundness), "{roundness}"),
            _ => {}
        }
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let beauty = noisy(97, 61, 11);
    let settings = Bloom {
        passes: 2,
        ..bloom(0.5, 0.3, 9, 61)
    };
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| bits(&apply(&beauty, 97, 61, &settings)))
    };
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(5));
}

#[test]
fn time_does_not_follow_the_radius() {
    let beauty = vec![[2.0_f32; 3]; 512 * 256];
    let time = |radius_px: usize| {
        let settings = bloom(1.0, 0.5, radius_px, 256);
        let start = Instant::now();
        apply(&beauty, 512, 256, &settings);
        start.elapsed()
    };
    let (mut small, mut large) = (Duration::MAX, Duration::MAX);
    for _ in 0..9 {
        small = small.min(time(5));
        large = large.min(time(100));
    }
    // Adding up each window would take 18 times as long; the rest of the factor
    // is for other work on the machine.
    assert!(large < small * 3, "r = 5: {small:?}, r = 100: {large:?}");
}
