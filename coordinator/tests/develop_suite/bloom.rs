//! B = I + strength K * max(I - T, 0): its exact identities.

use std::time::{Duration, Instant};

use shearwater_coordinator::develop::{Bloom, apply_bloom};

use crate::pictures::noisy;

/// Settings whose box has half-width `radius_px` in a picture of this height.
fn bloom(threshold: f32, strength: f32, radius_px: usize, height: u32) -> Bloom {
    Bloom {
        threshold,
        strength,
        radius: radius_px as f32 / height as f32,
        passes: 1,
    }
}

fn apply(beauty: &[[f32; 3]], width: u32, height: u32, bloom: &Bloom) -> Vec<[f32; 3]> {
    apply_bloom(beauty, width, height, Some(bloom)).unwrap().rgb
}

fn bits(rgb: &[[f32; 3]]) -> Vec<[u32; 3]> {
    rgb.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

fn close(value: f32, expected: f64, tolerance: f64) {
    let error = (f64::from(value) - expected).abs();
    assert!(
        error <= tolerance * expected.abs(),
        "{value} is not {expected} within {tolerance}"
    );
}

#[test]
fn constant_picture_stays_constant_up_to_its_borders() {
    for (radius_px, passes) in [(0, 1), (1, 1), (7, 1), (20, 1), (20, 3)] {
        let settings = Bloom {
            passes,
            ..bloom(1.0, 0.7, radius_px, 20)
        };
        let beauty = vec![[3.1_f32, 0.4, 1.0]; 33 * 20];
        for pixel in apply(&beauty, 33, 20, &settings) {
            close(
                pixel[0],
                3.1_f32 as f64 + f64::from(0.7_f32) * (3.1_f32 as f64 - 1.0),
                1e-7,
            );
            // At or below the threshold: the bits stay.
            assert_eq!([pixel[1], pixel[2]], [0.4, 1.0]);
        }
    }
}

#[test]
fn impulse_becomes_a_box_and_nothing_outside() {
    let (width, height, radius_px, value) = (41_u32, 31_u32, 4_usize, 1e6_f32);
    let (cx, cy) = (20_usize, 15_usize);
    let mut beauty = vec![[0.0_f32; 3]; (width * height) as usize];
    beauty[cy * width as usize + cx][1] = value;
    let out = apply(&beauty, width, height, &bloom(1.0, 0.5, radius_px, height));
    let level = 0.5 * (f64::from(value) - 1.0) / 81.0;
    for (i, pixel) in out.iter().enumerate() {
        let (x, y) = (i % width as usize, i / width as usize);
        let reach = x.abs_diff(cx).max(y.abs_diff(cy));
        if reach == 0 {
            close(pixel[1], f64::from(value) + level, 1e-7);
        } else if reach <= radius_px {
            close(pixel[1], level, 1e-7);
        } else {
            assert_eq!(pixel[1].to_bits(), 0, "at {x}, {y}");
        }
        assert_eq!([pixel[0].to_bits(), pixel[2].to_bits()], [0, 0]);
    }
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
fn interior_energy_rises_by_strength_times_the_excess() {
    let (width, height) = (64_u32, 64_u32);
    for passes in 1..=3 {
        let settings = Bloom {
            passes,
            ..bloom(1.0, 0.25, 6, height)
        };
        let mut beauty = vec![[0.3_f32; 3]; 64 * 64];
        for (i, value) in [
            (30 * 64 + 31, 900.0_f32),
            (33 * 64 + 36, 12.0),
            (34 * 64 + 29, 2.5),
        ] {
            beauty[i] = [value; 3];
        }
        let sum = |rgb: &[[f32; 3]]| rgb.iter().map(|p| f64::from(p[0])).sum::<f64>();
        let excess = 899.0 + 11.0 + 1.5;
        let gained = sum(&apply(&beauty, width, height, &settings)) - sum(&beauty);
        assert!(
            (gained - 0.25 * excess).abs() < 1e-4 * excess,
            "{passes} passes: {gained}"
        );
    }
}

#[test]
fn off_settings_return_the_input_bit_for_bit() {
    let mut beauty = noisy(24, 18, 3);
    beauty[5] = [f32::INFINITY, f32::from_bits(0x7fc0_1234), -0.0];
    let same = [
        bloom(f32::INFINITY, 1.0, 3, 18),
        bloom(1.0, 0.0, 3, 18),
        bloom(1e9, 1.0, 3, 18),
    ];
    for settings in same {
        assert_eq!(bits(&apply(&beauty, 24, 18, &settings)), bits(&beauty));
    }
    let none = apply_bloom(&beauty, 24, 18, None).unwrap();
    assert_eq!(bits(&none.rgb), bits(&beauty));
    assert_eq!(none.non_finite_values, 2);
}

#[test]
fn bright_pixel_leaves_no_error_in_its_row() {
    // A running f32 sum reads 1.000 instead of 1.010 behind the bright pixel.
    let (width, height, radius_px) = (600_u32, 21_u32, 5_usize);
    let mut beauty = vec![[1.01_f32; 3]; (width * height) as usize];
    beauty[10 * width as usize + 20] = [1e6; 3];
    let out = apply(&beauty, width, height, &bloom(0.0, 1.0, radius_px, height));
    for (i, pixel) in out.iter().enumerate() {
        if i % width as usize > 25 {
            close(pixel[0], 2.0 * f64::from(1.01_f32), 1e-7);
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
