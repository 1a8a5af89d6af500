//! The sea as a whole: statistics, waves in time, drift.

use super::spectrum::frequency_hz;
use super::*;
use shearwater_shared::scene::TessendorfWater;
use std::f64::consts::PI;

fn stage_of(sea: TessendorfWater) -> SeaStage {
    SeaStage::new(&Water::Tessendorf(sea), None)
}

pub(super) fn sea() -> TessendorfWater {
    TessendorfWater {
        height_m: 0.0,
        grid: 128,
        tile_m: 200.0,
        wind_speed_mps: 10.0,
        wind_direction_deg: 30.0,
        amplitude: 1.0,
        cutoff_m: 0.0,
        seed: 5,
        body_color: [0.0; 3],
        ior: 1.333,
        roughness: 0.0,
        velocity_mps: [0.0; 2],
        time_s: 3.0,
        loop_s: None,
        shutter_fields: 1,
        whitecaps: None,
    }
}

fn field(sea: &TessendorfWater) -> HeightField {
    Spectrum::new(sea).at(sea.time_s)
}

fn variance(values: &[f32]) -> f64 {
    values
        .iter()
        .map(|&v| f64::from(v) * f64::from(v))
        .sum::<f64>()
        / values.len() as f64
}

#[test]
fn the_field_has_no_mean() {
    for grid in [16, 32, 128, 512] {
        let field = field(&TessendorfWater { grid, ..sea() });
        let mean =
            field.height.iter().map(|&h| f64::from(h)).sum::<f64>() / field.height.len() as f64;
        let rms = libm::sqrt(variance(&field.height));
        assert!(mean.abs() < 1e-6 * rms && rms > 0.0, "{grid}: {mean}");
        let slopes = field.slope_x.iter().chain(&field.slope_z);
        assert!(slopes.chain(&field.height).all(|v| v.is_finite()));
    }
}

// Sum P dk^2 -> A pi Lw^2 / 2 over the plane: 163.22 for V = 10, A = 1; a
// tile of 200 m and 128 points holds 162.8 of it. Averaged over seeds.
#[test]
fn variance_is_that_of_the_spectrum_for_any_tile() {
    let measured = |tile_m: f64| {
        let seeds = 60;
        let one = |seed| {
            let sea = TessendorfWater {
                grid: 64,
                tile_m,
                seed,
                ..sea()
            };
            variance(&field(&sea).height)
        };
        (0..seeds).map(one).sum::<f64>() / f64::from(seeds as u32)
    };
    for tile_m in [200.0, 400.0] {
        let v = measured(tile_m);
        assert!((v / 163.0 - 1.0).abs() < 0.12, "{tile_m} m: {v}");
    }
}

// Spectral slopes against sixth-order differences of a smooth field.
#[test]
fn slopes_are_the_derivatives_of_the_heights() {
    let field = field(&TessendorfWater {
        cutoff_m: 12.0,
        ..sea()
    });
    let (n, d) = (field.n, field.tile_m / field.n as f64);
    let at = |x: usize, z: usize| f64::from(field.height[(z % n) * n + x % n]);
    let rms = libm::sqrt(variance(&field.slope_x) + variance(&field.slope_z));
    for (x, z) in [(0, 0), (5, 77), (127, 127), (64, 3)] {
        let stencil = |f: &dyn Fn(usize) -> f64| {
            (45.0 * (f(1) - f(n - 1)) - 9.0 * (f(2) - f(n - 2)) + (f(3) - f(n - 3))) / (60.0 * d)
        };
        let dx = stencil(&|s| at(x + s, z));
        let dz = stencil(&|s| at(x, z + s));
        let i = z * n + x;
        assert!((dx - f64::from(field.slope_x[i])).abs() < 2e-4 * rms);
        assert!((dz - f64::from(field.slope_z[i])).abs() < 2e-4 * rms);
    }
}

// Deep water: w = sqrt(g k), so that a wave of 1, 10, 100 m needs .80030, 2.53079,
// 8.00305 s to come back and runs 1.2495, 3.9513, 12.4952 m/s.
#[test]
fn waves_have_the_period_and_the_speed_of_deep_water() {
    for (length_m, period_s, speed_mps) in [
        (1.0, 0.800_30, 1.2495),
        (10.0, 2.530_79, 3.9513),
        (100.0, 8.003_05, 12.4952),
    ] {
        let hz = frequency_hz(2.0 * PI / length_m);
        assert!(
            (1.0 / hz - period_s).abs() < 1e-5 * period_s,
            "{length_m} m"
        );
        assert!((length_m * hz - speed_mps).abs() < 1e-4 * speed_mps);
        // The field itself: a spectrum cut off above its longest waves, (1, 0) and
        // (0, 1) on the grid, is back after one period and reversed after half.
        let sea = TessendorfWater {
            tile_m: length_m,
            cutoff_m: length_m,
            wind_speed_mps: 30.0,
            grid: 16,
            ..sea()
        };
        let spectrum = Spectrum::new(&sea);
        let start = spectrum.at(0.0).height;
        let rms = libm::sqrt(variance(&start));
        for (periods, sign) in [(1.0, 1.0), (0.5, -1.0), (1000.0, 1.0)] {
            let later = spectrum.at(periods / hz).height;
            let worst = start.iter().zip(&later).map(|(a, b)| (a - sign * b).abs());
            assert!(
                f64::from(worst.fold(0.0, f32::max)) < 1e-5 * rms,
                "{length_m} m, {periods}"
            );
        }
    }
}

// mean h^2 = sum |h(k)|^2 (Parseval), with h(k) by a sum over all points in f64.
#[test]
fn the_energy_of_the_field_is_that_of_its_waves() {
    let spectrum = Spectrum::new(&TessendorfWater { grid: 16, ..sea() });
    for time_s in [0.0, 3.0, 1e5] {
        let height = spectrum.at(time_s).height;
        let wave = |kx: usize, kz: usize| {
            let (mut re, mut im) = (0.0, 0.0);
            for (i, &h) in height.iter().enumerate() {
                let turns = (kx * (i % 16) + kz * (i / 16)) % 16;
                let angle = turns as f64 / 16.0 * 2.0 * PI;
                re += f64::from(h) * libm::cos(angle) / 256.0;
                im -= f64::from(h) * libm::sin(angle) / 256.0;
            }
            re * re + im * im
        };
        let given = spectrum.energy(time_s);
        let sum: f64 = (0..256).map(|k| wave(k % 16, k / 16)).sum();
        let mean = variance(&height);
        assert!((mean / given - 1.0).abs() < 1e-6, "{mean} {given}");
        assert!((sum / given - 1.0).abs() < 1e-6, "{sum} {given}");
        // Nyquist waves and the mean are absent.
        let absent = (0..16).map(|k| wave(8, k) + wave(k, 8)).sum::<f64>() + wave(0, 0);
        assert!(absent < 1e-12 * given);
    }
}

// Of the two waves of a pair the wind drives the one that runs with it: after
// a time dt its crest has moved by +c dt downwind.
#[test]
fn waves_run_with_the_wind() {
    let spectrum = Spectrum::new(&TessendorfWater {
        wind_direction_deg: 90.0,
        amplitude: 0.01,
        cutoff_m: 3.0,
        ..sea()
    });
    let (now, later) = (spectrum.at(10.0), spectrum.at(10.2));
    // Where the surface rises, the wave that brings the crest comes from upwind:
    // dh/dt = -c dh/dx on average, so the sum of dh/dt * dh/dx is negative.
    let rising = now.height.iter().zip(&later.height).map(|(a, b)| b - a);
    let products = rising
        .zip(&now.slope_x)
        .map(|(dh, slope)| f64::from(dh * slope));
    let sum: f64 = products.sum();
    let size = libm::sqrt(variance(&now.height) * variance(&now.slope_x)) * now.height.len() as f64;
    assert!(sum < -0.02 * size, "{sum} of {size}");
}

#[test]
fn a_loop_closes() {
    let looping = TessendorfWater {
        loop_s: Some(3.0),
        ..sea()
    };
    let spectrum = Spectrum::new(&looping);
    let rms = libm::sqrt(variance(&spectrum.at(0.0).height));
    let differ = |a: f64, b: f64| {
        let (a, b) = (spectrum.at(a).height, spectrum.at(b).height);
        let worst = a
            .iter()
            .zip(&b)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f32::max);
        f64::from(worst) / rms
    };
    // Frame 72 of 24 fps, a hundred thousand loops, and across the wrap.
    assert!(differ(0.0, 72.0 / 24.0) < 1e-6);
    assert!(differ(7.0 / 24.0, 79.0 / 24.0) < 1e-6);
    assert!(differ(0.7, 300_000.7) < 1e-5);
    assert!(differ(-1e-6, 1e-6) < 1e-4);
    assert!(differ(0.0, 1.0) > 0.1);
}

// Drifting by v for t seconds is looking v t metres upstream, whether t passed
// before the shutter opened or after.
#[test]
fn the_surface_drifts_with_its_velocity() {
    let sea = TessendorfWater {
        velocity_mps: [3.0, -7.0],
        // All waves are back after each millisecond: only the drift moves.
        loop_s: Some(1e-3),
        ..sea()
    };
    let stage = stage_of(sea);
    let still = stage.at(0.0, 0.0, [10.0, 5.0, -20.0]);
    let later = stage.at(4.0, 0.0, [10.0, 5.0, -20.0]);
    for (x, z, t) in [(1.0, 2.0, 0.5), (-40.0, 13.0, 2.0)] {
        let there = still.at(x - 3.0 * t, z + 7.0 * t, 0.0, 0.0, &[]).slope;
        assert!((still.at(x, z, t, 0.0, &[]).slope - there).length() < 1e-3);
        let there = still
            .at(x - 12.0 - 3.0 * t, z + 28.0 + 7.0 * t, 0.0, 0.0, &[])
            .slope;
        assert!((later.at(x, z, t, 0.0, &[]).slope - there).length() < 1e-3);
    }
    let (now, moved) = (
        still.at(1.0, 2.0, 0.0, 0.0, &[]),
        still.at(1.0, 2.0, 0.5, 0.0, &[]),
    );
    assert!((now.slope - moved.slope).length() > 1e-2);
}

// With several fields the slopes at their times are those of a frame at that time,
// and in between they lie on the line.
#[test]
fn slopes_follow_the_waves_within_the_shutter() {
    let fields = |shutter_fields| {
        stage_of(TessendorfWater {
            shutter_fields,
            ..sea()
        })
    };
    let at = |sea: &Sea, t: f32| sea.at(3.0, 5.0, t, 0.0, &[]).slope;
    let (one, three) = (fields(1), fields(3).at(1.0, 0.5, [0.0; 3]));
    let frozen = one.at(1.0, 0.5, [0.0; 3]);
    assert_eq!(at(&frozen, 0.0), at(&frozen, 0.4));
    for t in [0.0, 0.25, 0.5] {
        let then = at(&one.at(1.0 + f64::from(t), 0.0, [0.0; 3]), 0.0);
        assert!((at(&three, t) - then).length() < 1e-5, "{t}");
    }
    let middle = (at(&three, 0.0) + at(&three, 0.25)) * 0.5;
    assert!((at(&three, 0.125) - middle).length() < 1e-5);
    assert!((at(&three, 0.0) - at(&three, 0.25)).length() > 1e-3);
    // Without a shutter there is one time.
    let open = fields(4).at(1.0, 0.0, [0.0; 3]);
    assert_eq!(at(&open, 0.0), at(&frozen, 0.0));
}

// The first and the last texel of a tile are neighbours.
#[test]
fn the_surface_is_continuous_across_the_wrap() {
    let sea = stage_of(sea()).at(0.0, 0.0, [0.0; 3]);
    let at = |x: f32, z: f32| sea.at(x, z, 0.0, 0.0, &[]).slope;
    for i in 0..50 {
        let v = i as f32 * 4.1;
        assert_eq!(at(0.0, v), at(200.0, v));
        assert!((at(-1e-3, v) - at(1e-3, v)).length() < 0.02, "{v}");
        assert!((at(v, 199.999) - at(v, 200.001)).length() < 0.02, "{v}");
    }
}

// One wave of amplitude a squeezes its crest to 1 - c k a: foam begins where the
// threshold says, on crests and not in troughs, and its mean is that of all levels.
#[test]
fn foam_lies_on_the_crests() {
    let caps = |threshold| shearwater_shared::scene::Whitecaps {
        choppiness: 1.0,
        threshold,
        softness: 1e-3,
        albedo: [0.7, 0.8, 0.9],
        roughness: 1.0,
    };
    let sea_of = |threshold| TessendorfWater {
        amplitude: 0.01,
        cutoff_m: 4.0,
        whitecaps: Some(caps(threshold)),
        ..sea()
    };
    let field = field(&sea_of(0.0));
    let stage = |threshold| stage_of(sea_of(threshold)).at(3.0, 0.0, [0.0; 3]);
    let (some, all, none) = (stage(0.9), stage(100.0), stage(-100.0));
    let step = field.tile_m as f32 / field.n as f32;
    let (mut under_foam, mut count) = (0.0_f64, 0);
    for (i, &height) in Spectrum::new(&sea_of(0.0))
        .at(6.0)
        .height
        .iter()
        .enumerate()
    {
        let (x, z) = ((i % field.n) as f32 * step, (i / field.n) as f32 * step);
        let point = some.at(x, z, 0.0, 0.0, &[]);
        if point.body_color.y > 0.79 {
            under_foam += f64::from(height);
            count += 1;
            assert_eq!(point.alpha, 1.0);
        }
        assert!(
            (all.at(x, z, 0.0, 0.0, &[]).body_color - Vec3::new(0.7, 0.8, 0.9)).length() < 1e-6
        );
        assert_eq!(none.at(x, z, 0.0, 0.0, &[]).body_color, Vec3::ZERO);
    }
    let rms = libm::sqrt(variance(&field.height));
    let points = field.height.len();
    assert!(
        count > points / 50 && count < points / 3,
        "{count} of {points}"
    );
    assert!(under_foam / f64::from(count as u32) > 0.5 * rms);
    let mean = some.at(0.0, 0.0, 0.0, 1e6, &[]).body_color.y / 0.8;
    let share = count as f32 / points as f32;
    assert!((mean - share).abs() < 0.02, "{mean} {share}");
}

// The bits of a field, the same on every processor: fails where arithmetic differs.
#[test]
fn the_field_has_the_bits_of_every_machine() {
    let field = field(&TessendorfWater { grid: 32, ..sea() });
    let bits = field
        .height
        .iter()
        .chain(&field.slope_x)
        .chain(&field.slope_z);
    let hash = bits.fold(0, |hash: u64, v| {
        crate::math::hash::mix64(hash ^ u64::from(v.to_bits()))
    });
    assert_eq!(hash, 2_482_477_889_506_550_135);
}

// The texture lies still in the water and drifts with it; without one the body has its
// own colour, and there are no waves.
#[test]
fn flat_water_carries_its_texture() {
    let red_green = image::RgbImage::from_fn(2, 1, |x, _| {
        image::Rgb([255, 0, 0].map(|v| if x == 0 { v } else { 255 - v }))
    });
    let mut png = std::io::Cursor::new(Vec::new());
    red_green
        .write_to(&mut png, image::ImageFormat::Png)
        .unwrap();
    let texture =
        crate::load::load_texture("t.png", png.get_ref(), crate::load::Encoding::Srgb).unwrap();
    let flat = |name: Option<&str>| {
        Water::Flat(shearwater_shared::scene::FlatWater {
            texture: name.map(str::to_owned),
            texture_size_m: 4.0,
            height_m: 1.5,
            body_color: [0.5; 3],
            ior: 1.333,
            roughness: 0.1,
            velocity_mps: [1.0, 0.0],
        })
    };
    let sea = SeaStage::new(&flat(Some("t.png")), Some(0)).at(3.0, 1.0, [100.0, 2.0, 7.0]);
    let textures = [texture];
    let at = |x: f32, t: f32| sea.at(x, 5.0, t, 0.1, &textures);
    // Scene x = 100 is render x = 0; at 3 s the texture has moved by 3 m: its left
    // half, whose middle is 1 m from its edge, covers 3 + 4 i to 5 + 4 i.
    assert!((at(4.0, 0.0).body_color - Vec3::new(0.5, 0.0, 0.0)).length() < 1e-5);
    assert!((at(2.0, 0.0).body_color - Vec3::new(0.0, 0.5, 0.5)).length() < 1e-5);
    assert!((at(-396.0 + 1.0, 1.0).body_color - Vec3::new(0.5, 0.0, 0.0)).length() < 1e-4);
    assert_eq!(at(4.0, 0.0).slope, Vec2::ZERO);
    assert!((at(4.0, 0.0).alpha - 0.01).abs() < 1e-7);
    let plain = SeaStage::new(&flat(None), None).at(3.0, 1.0, [0.0; 3]);
    assert_eq!(
        plain.at(4.0, 5.0, 0.5, 0.1, &[]).body_color,
        Vec3::splat(0.5)
    );
}
