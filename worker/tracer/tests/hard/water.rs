//! The sea's spectrum, its waves in time, and waves by hand.

use crate::table::{Case, Form, Row, Section};
use rustfft::{FftPlanner, num_complex::Complex};
use serde_json::json;
use shearwater_shared::scene::{TessendorfWater, Water, parse};
use shearwater_tracer::water::{SeaStage, Spectrum};
use std::f64::consts::PI;

static SECTION: Section = Section::new(
    "Water",
    &[
        Case {
            name: "mean and unpaired waves",
            note: "k = 0 would be 0/0 and waves of the Nyquist column have no partner: shares of the field's energy, by a transform in \
                   64 bits. The field is real by construction (half a spectrum is transformed), so there is no imaginary part to measure.",
            broken_by: "the Nyquist column kept",
            rows: absent,
        },
        Case {
            name: "slopes against i k h",
            note: "Root mean square difference from the derivative of the heights' own transform, over that of the slopes. Fields are 32 \
                   bits wide. A difference of neighbours would be 0.29.",
            broken_by: "slopes by central differences",
            rows: slopes,
        },
        Case {
            name: "energy of the field against its waves (Parseval)",
            note: "Mean square of the heights over the sum of |h(k)|^2 of the transform of slopes over k^2, less 1.",
            broken_by: "heights times 1.0001",
            rows: parseval,
        },
        Case {
            name: "variance of the sea, tiles of any size",
            note: "sum P (2 pi/L)^2 over the waves of the grid, here summed anew from the formula; tends to A pi V^4/(2 g^2) = 163.22 \
                   for V = 10 and A = 1 while the tile has room for the longest waves. Mean over seeds.",
            broken_by: "each h0 with all of P for half (twice the variance)",
            rows: variance,
        },
        Case {
            name: "share of energy against the wind",
            note: "Both waves of each pair told apart by two times: 0.07/1.07 where the undamped spectrum has 0.5. Mean over seeds.",
            broken_by: "the sign of the wind's direction",
            rows: upwind,
        },
        Case {
            name: "every wave's frequency",
            note: "A third time predicted from the first two with w = sqrt(g k): largest error of a wave over the largest wave.",
            broken_by: "g = 9.8",
            rows: frequencies,
        },
        Case {
            name: "deep water",
            note: "A field of waves of this length is back after the period of the closed form, and reversed after half: largest \
                   difference over root mean square.",
            broken_by: "g = 9.8",
            rows: periods,
        },
        Case {
            name: "loop of 3 s",
            note: "Largest difference over root mean square: a loop later, 100,000 loops later, and from just before its end to just after.",
            broken_by: "frequencies that are not rounded to whole turns",
            rows: loops,
        },
        Case {
            name: "across the tile's border",
            note: "Places of 1000 whose slope differs in a bit from that a tile further.",
            broken_by: "whole negative texels rounded one too low, as they were: 28 places",
            rows: border,
        },
        Case {
            name: "trochoid of k = 1, a = 0.3",
            note: "Crests are narrow: the mean height is -k a^2/2. Slopes against those of its parametric form in 64 bits: the \
                   largest difference.",
            broken_by: "one step of the search for the water of a point",
            rows: crate::trochoid::trochoid,
        },
        Case {
            name: "grids of 15, 100, 255 and 257 points refused",
            note: "Odd and uneven grids are not supported and said to be so.",
            broken_by: "any grid of 16 to 2048 taken",
            rows: grids,
        },
    ],
);

#[test]
fn water() {
    SECTION.check();
}

fn sea() -> TessendorfWater {
    let described = json!({"version": 1, "name": "sea", "image": {"width": 1, "height": 1},
        "camera": {"position_m": [0, 9, 0], "target_m": [0, 0, -9], "vertical_fov_deg": 40},
        "water": {"type": "tessendorf", "grid": 128, "tile_m": 200, "wind_speed_mps": 10,
            "wind_direction_deg": 30, "amplitude": 1, "seed": 5}});
    match parse(described.to_string().as_bytes())
        .expect("valid")
        .water
    {
        Some(Water::Tessendorf(sea)) => sea,
        other => panic!("{other:?}"),
    }
}

type Waves = Vec<Complex<f64>>;

// h(k), row by row along kz: the forward transform over the number of points.
fn transform(field: &[f32], n: usize) -> Waves {
    let mut values: Waves = field
        .iter()
        .map(|&h| Complex::new(f64::from(h), 0.0))
        .collect();
    let plan = FftPlanner::new().plan_fft_forward(n);
    for _ in 0..2 {
        plan.process(&mut values);
        values = (0..n * n).map(|i| values[(i % n) * n + i / n]).collect();
    }
    values.iter().map(|h| h / (n * n) as f64).collect()
}

// The wave vector of entry i, radians per metre.
fn vector(i: usize, n: usize, tile_m: f64) -> [f64; 2] {
    let signed = |i: usize| {
        if i < n / 2 {
            i as f64
        } else {
            i as f64 - n as f64
        }
    };
    [i % n, i / n].map(|i| signed(i) * 2.0 * PI / tile_m)
}

fn length(k: [f64; 2]) -> f64 {
    (k[0] * k[0] + k[1] * k[1]).sqrt()
}

fn mean_square(field: &[f32]) -> f64 {
    field
        .iter()
        .map(|&h| f64::from(h) * f64::from(h))
        .sum::<f64>()
        / field.len() as f64
}

fn absent(_: Form) -> Vec<Row> {
    let field = Spectrum::new(&sea()).at(3.0);
    let waves = transform(&field.height, field.n);
    let total: f64 = waves.iter().map(Complex::norm_sqr).sum();
    let half = field.n / 2;
    let unpaired = |i: usize| i % field.n == half || i / field.n == half;
    let nyquist: f64 = (0..waves.len())
        .filter(|&i| unpaired(i))
        .map(|i| waves[i].norm_sqr())
        .sum();
    vec![
        Row::at_most("k = 0", 1e-12, waves[0].norm_sqr() / total),
        Row::at_most("Nyquist", 1e-12, nyquist / total),
    ]
}

fn slopes(_: Form) -> Vec<Row> {
    let field = Spectrum::new(&sea()).at(3.0);
    let waves = transform(&field.height, field.n);
    let row = |(axis, slope, name): (usize, &[f32], &str)| {
        let found = transform(slope, field.n);
        let (mut off, mut total) = (0.0, 0.0);
        for (i, (h, s)) in waves.iter().zip(&found).enumerate() {
            let k = vector(i, field.n, field.tile_m)[axis];
            off += (s - h * Complex::new(0.0, k)).norm_sqr();
            total += s.norm_sqr();
        }
        Row::at_most(name, 1e-5, (off / total).sqrt())
    };
    [(0, &*field.slope_x, "x"), (1, &*field.slope_z, "z")]
        .map(row)
        .to_vec()
}

fn parseval(_: Form) -> Vec<Row> {
    let field = Spectrum::new(&sea()).at(3.0);
    let [x, z] = [&field.slope_x, &field.slope_z].map(|slope| transform(slope, field.n));
    let energy = |i: usize| {
        let k = length(vector(i, field.n, field.tile_m));
        (x[i].norm_sqr() + z[i].norm_sqr()) / (k * k)
    };
    let sum: f64 = (1..x.len()).map(energy).sum();
    vec![Row::near(
        "",
        0.0,
        mean_square(&field.height) / sum - 1.0,
        1e-5,
    )]
}

// Sum of P dk^2, P = A exp(-1/(k^2 V^4/g^2)) cos^2/k^4 (Tessendorf 2001, equation 40), over
// the waves that have a partner.
fn variance_of(sea: &TessendorfWater) -> f64 {
    let n = sea.grid as usize;
    let largest = sea.wind_speed_mps * sea.wind_speed_mps / 9.81;
    let azimuth = sea.wind_direction_deg.to_radians();
    let cell = 2.0 * PI / sea.tile_m;
    (1..n * n)
        .filter(|i| i % n != n / 2 && i / n != n / 2)
        .map(|i| {
            let k = vector(i, n, sea.tile_m);
            let k2 = k[0] * k[0] + k[1] * k[1];
            let along = k[0] * libm::sin(azimuth) - k[1] * libm::cos(azimuth);
            let ends = libm::exp(-1.0 / (k2 * largest * largest));
            sea.amplitude * ends * along * along / (k2 * k2 * k2) * cell * cell
        })
        .sum()
}

// Mean and standard error over seeds.
fn over_seeds(seeds: u64, f: impl Fn(u64) -> f64) -> (f64, f64) {
    let values: Vec<f64> = (0..seeds).map(f).collect();
    let n = seeds as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

fn variance(form: Form) -> Vec<Row> {
    let row = |tile_m: f64| {
        let sea = TessendorfWater {
            tile_m,
            grid: 64,
            ..sea()
        };
        let (found, error) = over_seeds(form.pick(100, 4000), |seed| {
            mean_square(
                &Spectrum::new(&TessendorfWater {
                    seed,
                    ..sea.clone()
                })
                .at(3.0)
                .height,
            )
        });
        Row::sampled(
            format!("{tile_m} m"),
            variance_of(&sea),
            found,
            4.0,
            error,
            0.0,
        )
    };
    [400.0, 200.0, 100.0, 50.0].map(row).to_vec()
}

// The waves at three times, the third predicted: h(t) = a e^-iwt + b e^iwt.
struct Pair {
    /// Runs along k, and against it.
    along: Complex<f64>,
    against: Complex<f64>,
    k: [f64; 2],
    /// What the third time has, less what the first two say.
    off: f64,
}

fn pairs(seed: u64) -> Vec<Pair> {
    let sea = TessendorfWater {
        seed,
        grid: 64,
        ..sea()
    };
    let times = [0.0, 0.7, 1.9];
    let spectrum = Spectrum::new(&sea);
    let [first, second, third] = times.map(|t| transform(&spectrum.at(t).height, 64));
    let one = |i: usize| {
        let k = vector(i, 64, sea.tile_m);
        let w = (9.81 * length(k)).sqrt();
        let turn = |t: f64| Complex::new(libm::cos(w * t), libm::sin(w * t));
        let (sin, e) = (turn(times[1]).im, turn(times[1]));
        // Near a half turn the two cannot be told apart.
        if sin.abs() < 0.2 {
            return None;
        }
        let against = (second[i] - first[i] * e.conj()) / Complex::new(0.0, 2.0 * sin);
        let along = first[i] - against;
        let e = turn(times[2]);
        let off = (third[i] - along * e.conj() - against * e).norm();
        Some(Pair {
            along,
            against,
            k,
            off,
        })
    };
    (1..64 * 64)
        .filter(|i| i % 64 != 32 && i / 64 != 32)
        .filter_map(one)
        .collect()
}

fn upwind(form: Form) -> Vec<Row> {
    let azimuth = sea().wind_direction_deg.to_radians();
    let (found, error) = over_seeds(form.pick(40, 1000), |seed| {
        let (mut against, mut total) = (0.0, 0.0);
        for pair in pairs(seed) {
            if pair.k[0] * libm::sin(azimuth) - pair.k[1] * libm::cos(azimuth) > 0.0 {
                against += pair.against.norm_sqr();
                total += pair.along.norm_sqr() + pair.against.norm_sqr();
            }
        }
        against / total
    });
    // A quotient of means, not a mean of quotients: 2e-3.
    vec![Row::sampled("", 0.07 / 1.07, found, 4.0, error, 2e-3)]
}

fn frequencies(_: Form) -> Vec<Row> {
    let pairs = pairs(3);
    let largest = pairs
        .iter()
        .map(|p| p.along.norm().max(p.against.norm()))
        .fold(0.0, f64::max);
    let worst = pairs.iter().map(|p| p.off).fold(0.0, f64::max);
    assert!(pairs.len() > 3000, "{}", pairs.len());
    vec![Row::at_most("", 1e-5, worst / largest)]
}

// Largest difference of two fields (one times `sign`) over the root mean square.
fn apart(a: &[f32], b: &[f32], sign: f32) -> f64 {
    let worst = a
        .iter()
        .zip(b)
        .map(|(a, b)| (a - sign * b).abs())
        .fold(0.0, f32::max);
    f64::from(worst) / mean_square(a).sqrt()
}

fn periods(_: Form) -> Vec<Row> {
    let rows = |tile_m: f64| {
        let period_s = (2.0 * PI * tile_m / 9.81).sqrt();
        // Cut off above its longest waves, (1, 0) and (0, 1) on the grid.
        let sea = TessendorfWater {
            tile_m,
            cutoff_m: tile_m,
            wind_speed_mps: 30.0,
            grid: 16,
            ..sea()
        };
        let spectrum = Spectrum::new(&sea);
        let at = |t: f64| spectrum.at(t).height;
        [
            Row::at_most(
                format!("{tile_m} m, {period_s:.5} s"),
                1e-5,
                apart(&at(0.0), &at(period_s), 1.0),
            ),
            Row::at_most(
                format!("{tile_m} m, half of it"),
                1e-5,
                apart(&at(0.0), &at(period_s / 2.0), -1.0),
            ),
        ]
    };
    [1.0, 10.0, 100.0].into_iter().flat_map(rows).collect()
}

fn loops(_: Form) -> Vec<Row> {
    let spectrum = Spectrum::new(&TessendorfWater {
        loop_s: Some(3.0),
        ..sea()
    });
    let at = |t: f64| spectrum.at(t).height;
    vec![
        Row::at_most("once", 1e-6, apart(&at(0.25), &at(3.25), 1.0)),
        Row::at_most("100,000 times", 1e-5, apart(&at(0.7), &at(300_000.7), 1.0)),
        Row::at_most(
            "0.2 ms across its end",
            0.01,
            apart(&at(2.9999), &at(3.0001), 1.0),
        ),
        Row::at_least("a third of it", 0.1, apart(&at(0.0), &at(1.0), 1.0)),
    ]
}

fn border(_: Form) -> Vec<Row> {
    // A tile of a power of two: places a tile apart are exact in 32 bits.
    let sea = TessendorfWater {
        tile_m: 256.0,
        ..sea()
    };
    let sea = SeaStage::new(&Water::Tessendorf(sea), None).at(0.0, 0.0, [0.0; 3]);
    let at = |x: f32, z: f32| sea.at(x, z, 0.0, 0.1, &[]).slope;
    let other = (0..1000).filter(|i| {
        let (x, z) = (*i as f32 * 0.25, (*i * 37 % 1000) as f32 * 0.25);
        at(x, z) != at(x + 256.0, z) || at(x, z) != at(x, z - 256.0)
    });
    vec![Row::exact("", 0.0, other.count() as f64)]
}

fn grids(_: Form) -> Vec<Row> {
    let refused = [15, 100, 255, 257].into_iter().filter(|grid| {
        let described = json!({"version": 1, "name": "sea", "image": {"width": 1, "height": 1},
            "camera": {"position_m": [0, 9, 0], "target_m": [0, 0, -9], "vertical_fov_deg": 40},
            "water": {"type": "tessendorf", "grid": grid, "tile_m": 200, "wind_speed_mps": 10}});
        parse(described.to_string().as_bytes())
            .is_err_and(|e| e.to_string().contains("power of two"))
    });
    vec![Row::exact("", 4.0, refused.count() as f64)]
}
