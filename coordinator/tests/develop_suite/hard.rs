//! Bloom's identities as rows of the table of hard cases (docs/hard-cases.md).

use crate::bloom::{apply, bits, bloom};
use crate::pictures::noisy;
use crate::table::{Case, Form, Row, Section};
use shearwater_coordinator::develop::{Bloom, apply_bloom};

static SECTION: Section = Section::new(
    "Bloom",
    &[
        Case {
            name: "constant picture up to its borders",
            note: "c + strength (c - threshold); the picture continues with its edge. Relative error of the value that is furthest off.",
            broken_by: "a border of zeros",
            rows: constant,
        },
        Case {
            name: "one bright pixel",
            note: "A box of strength (V - threshold)/(2 r + 1)^2 around it, nothing outside: relative errors, and pixels outside whose \
                   bits changed.",
            broken_by: "windows one pixel longer to the right",
            rows: impulse,
        },
        Case {
            name: "energy inside the picture",
            note: "The formula adds strength times the excess and takes nothing away: the gain over that, less 1. Passes of the box.",
            broken_by: "strength squared",
            rows: energy,
        },
        Case {
            name: "row behind a pixel of 1e6",
            note: "Relative error of 1.01 there; a running 32-bit sum gives 0.01.",
            broken_by: "windows summed in 32 bits",
            rows: behind,
        },
        Case {
            name: "an infinity and NaN",
            note: "Values that are finite before and not after, values that differ from those of the picture with 0 in place of what is not \
                   finite, values counted.",
            broken_by: "the infinity kept in the excess",
            rows: non_finite,
        },
        Case {
            name: "bloom switched off",
            note: "Threshold infinite, strength 0, threshold above all: pixels that differ in a bit.",
            broken_by: "0 added where no glow arrives, which turns -0 to 0",
            rows: off,
        },
        Case {
            name: "glow at twice the resolution",
            note: "Level of the halo of a square, less 1, against the same at half the resolution, averaged: rounding of the radius to \
                   pixels allows 4/(2 r + 1), r = 6.",
            broken_by: "a radius in pixels of a fixed height",
            rows: resolution,
        },
    ],
);

#[test]
fn hard() {
    SECTION.check();
}

// The larger by size; NaN is larger than all.
fn worse(a: f64, b: f64) -> f64 {
    if b.is_nan() || b.abs() > a.abs() {
        b
    } else {
        a
    }
}

fn constant(_: Form) -> Vec<Row> {
    let row = |(radius_px, passes): (usize, u32)| {
        let settings = Bloom {
            passes,
            ..bloom(1.0, 0.7, radius_px, 20)
        };
        let out = apply(&vec![[3.1_f32; 3]; 33 * 20], 33, 20, &settings);
        let c = f64::from(3.1_f32);
        let expected = c + f64::from(0.7_f32) * (c - 1.0);
        let errors = out.iter().map(|p| f64::from(p[0]) / expected - 1.0);
        Row::near(
            format!("r = {radius_px}, {passes} passes"),
            0.0,
            errors.fold(0.0, worse),
            1e-7,
        )
    };
    [(1, 1), (7, 1), (20, 1), (20, 3)].map(row).to_vec()
}

fn impulse(_: Form) -> Vec<Row> {
    let (width, height, radius_px, value) = (41_usize, 31_usize, 4_usize, 1e6_f32);
    let (cx, cy) = (20_usize, 15_usize);
    let mut beauty = vec![[0.0_f32; 3]; width * height];
    beauty[cy * width + cx] = [value; 3];
    let settings = bloom(1.0, 0.5, radius_px, height as u32);
    let out = apply(&beauty, width as u32, height as u32, &settings);
    let level = 0.5 * (f64::from(value) - 1.0) / 81.0;
    let (mut centre, mut inside, mut outside) = (0.0, 0.0, 0.0);
    for (i, pixel) in out.iter().enumerate() {
        let reach = (i % width).abs_diff(cx).max((i / width).abs_diff(cy));
        let found = f64::from(pixel[1]);
        match reach {
            0 => centre = found / (f64::from(value) + level) - 1.0,
            _ if reach <= radius_px => inside = worse(inside, found / level - 1.0),
            _ => outside += f64::from(u8::from(pixel[1].to_bits() != 0)),
        }
    }
    vec![
        Row::near("its own value", 0.0, centre, 1e-7),
        Row::near("the box", 0.0, inside, 1e-7),
        Row::exact("pixels outside", 0.0, outside),
    ]
}

fn energy(_: Form) -> Vec<Row> {
    let row = |passes: u32| {
        let settings = Bloom {
            passes,
            ..bloom(1.0, 0.25, 6, 64)
        };
        let mut beauty = vec![[0.3_f32; 3]; 64 * 64];
        for (i, value) in [
            (30 * 64 + 31, 900.0),
            (33 * 64 + 36, 12.0),
            (34 * 64 + 29, 2.5),
        ] {
            beauty[i] = [value; 3];
        }
        let sum = |rgb: &[[f32; 3]]| rgb.iter().map(|p| f64::from(p[0])).sum::<f64>();
        let gained = sum(&apply(&beauty, 64, 64, &settings)) - sum(&beauty);
        let gain = gained / (0.25 * (899.0 + 11.0 + 1.5)) - 1.0;
        Row::near(format!("{passes}"), 0.0, gain, 1e-4)
    };
    [1, 2, 3].map(row).to_vec()
}

fn behind(_: Form) -> Vec<Row> {
    let (width, height) = (600_usize, 21_usize);
    let mut beauty = vec![[1.01_f32; 3]; width * height];
    beauty[10 * width + 20] = [1e6; 3];
    let settings = bloom(0.0, 1.0, 5, height as u32);
    let out = apply(&beauty, width as u32, height as u32, &settings);
    let behind = out.iter().enumerate().filter(|(i, _)| i % width > 25);
    let errors = behind.map(|(_, p)| f64::from(p[0]) / (2.0 * f64::from(1.01_f32)) - 1.0);
    vec![Row::near("", 0.0, errors.fold(0.0, worse), 1e-7)]
}

fn non_finite(_: Form) -> Vec<Row> {
    let mut beauty = vec![[2.0_f32; 3]; 40 * 30];
    beauty[15 * 40 + 20] = [f32::INFINITY, f32::NAN, 2.0];
    beauty[3] = [2.0, 2.0, f32::NEG_INFINITY];
    let out = apply_bloom(&beauty, 40, 30, Some(&bloom(1.0, 0.5, 4, 30))).expect("settings");
    let dark = |v: f32| if v.is_finite() { v } else { 0.0 };
    let without: Vec<[f32; 3]> = beauty.iter().map(|rgb| rgb.map(dark)).collect();
    let without = apply(&without, 40, 30, &bloom(1.0, 0.5, 4, 30));
    let found = out.rgb.iter().flatten().zip(without.iter().flatten());
    let changed = beauty
        .iter()
        .flatten()
        .zip(found)
        .filter(|(was, (a, b))| was.is_finite() && a.to_bits() != b.to_bits())
        .count();
    let pairs = beauty.iter().flatten().zip(out.rgb.iter().flatten());
    let spread = pairs
        .filter(|(a, b)| a.is_finite() && !b.is_finite())
        .count();
    vec![
        Row::exact("spread", 0.0, spread as f64),
        Row::exact("others than with 0 in their place", 0.0, changed as f64),
        Row::exact("counted", 3.0, out.non_finite_values as f64),
    ]
}

fn off(_: Form) -> Vec<Row> {
    let mut beauty = noisy(24, 18, 3);
    beauty[5] = [f32::INFINITY, f32::from_bits(0x7fc0_1234), -0.0];
    let row = |(what, threshold, strength): (&str, f32, f32)| {
        let out = apply(&beauty, 24, 18, &bloom(threshold, strength, 3, 18));
        let other = bits(&out)
            .iter()
            .zip(bits(&beauty))
            .filter(|(a, b)| *a != b)
            .count();
        Row::exact(what, 0.0, other as f64)
    };
    [
        ("threshold infinite", f32::INFINITY, 1.0),
        ("strength 0", 1.0, 0.0),
        ("threshold above all", 1e9, 1.0),
    ]
    .map(row)
    .to_vec()
}

fn resolution(_: Form) -> Vec<Row> {
    // A square of 4 x 4 low pixels in a picture of 64.
    let glow = |scale: usize| {
        let side = 64 * scale;
        let lit = 30 * scale..34 * scale;
        let mut beauty = vec![[0.0_f32; 3]; side * side];
        for (x, y) in lit.clone().flat_map(|y| lit.clone().map(move |x| (x, y))) {
            beauty[y * side + x] = [500.0; 3];
        }
        let settings = bloom(1.0, 1.0, 6, 64);
        let out = apply(&beauty, side as u32, side as u32, &settings);
        // Where every window holds the whole square.
        let level = |x: usize, y: usize| f64::from(out[y * side + x][0] - beauty[y * side + x][0]);
        level(32 * scale, 32 * scale)
    };
    let off = (glow(1) / glow(2) - 1.0).abs();
    vec![Row::at_most("", 4.0 / 13.0, off)]
}
