//! Exposure and views: exact values, neutral and monotone grey, total.

use shearwater_coordinator::develop::{View, apply_view};

/// Codes of grey pixels; each must come out neutral, bit for bit.
fn greys(values: &[f32], exposure_ev: f32, view: View) -> Vec<f32> {
    let pixels: Vec<[f32; 3]> = values.iter().map(|&value| [value; 3]).collect();
    apply_view(&pixels, exposure_ev, view)
        .into_iter()
        .zip(values)
        .map(|([r, g, b], value)| {
            let neutral = r.to_bits() == g.to_bits() && g.to_bits() == b.to_bits();
            assert!(neutral, "{value}: {r} {g} {b}");
            r
        })
        .collect()
}

fn grey(value: f32, exposure_ev: f32, view: View) -> f32 {
    greys(&[value], exposure_ev, view)[0]
}

/// Linear light of an sRGB code value (IEC 61966-2-1), the other direction.
fn linear_of(code: f64) -> f32 {
    let linear = if code <= 0.04045 {
        code / 12.92
    } else {
        libm::pow((code + 0.055) / 1.055, 2.4)
    };
    linear as f32
}

#[test]
fn standard_is_the_srgb_curve() {
    let codes: Vec<f64> = (0..=65_535)
        .map(|step| f64::from(step) / 65_535.0)
        .collect();
    let linear: Vec<f32> = codes.iter().map(|&code| linear_of(code)).collect();
    let got = greys(&linear, 0.0, View::Standard);
    for (step, (code, got)) in codes.into_iter().zip(got).enumerate() {
        let got = f64::from(got);
        assert!((got - code).abs() < 1e-7, "{step}: {got}");
        // Every integer of 16 bits comes back, so every one of 8 bits does.
        assert_eq!((got * 65_535.0 + 0.5) as usize, step);
    }
    for (linear, code) in [
        (0.0, 0.0),
        (1.0, 1.0),
        (0.18, 0.461_356_1),
        (0.5, 0.735_356_98),
        (7.0, 1.0),
    ] {
        assert!((grey(linear, 0.0, View::Standard) - code).abs() < 2e-7);
    }
}

#[test]
fn agx_meets_its_definition_on_grey() {
    // The curve passes (0.18, 0.5) by definition; ten stops below is 0, six and
    // a half above is 1.
    assert!((grey(0.18, 0.0, View::Agx) - 0.5).abs() < 1e-6);
    assert_eq!(grey(0.0, 0.0, View::Agx).to_bits(), 0);
    // 0.18 as an f32 lies a little above 0.18.
    assert!(grey(0.18 / 1024.0, 0.0, View::Agx) < 1e-9);
    assert!((grey(16.292, 0.0, View::Agx) - 1.0).abs() < 1e-6);
    assert_eq!(grey(1e4, 0.0, View::Agx), 1.0);
    // One stop is 1/16.5 across; the slope at mid grey is 2.
    let stops = grey(0.18, 0.05, View::Agx) - grey(0.18, -0.05, View::Agx);
    assert!((stops - 2.0 * 0.1 / 16.5).abs() < 1e-5);
    // Scene white, from the curve by hand: x = (0 - log2 0.18 + 10) / 16.5.
    assert!((grey(1.0, 0.0, View::Agx) - 0.787_515).abs() < 1e-5);
}

#[test]
fn grey_rises_and_stays_neutral() {
    for view in View::ALL {
        let values: Vec<f32> = (0..40_000)
            .map(|step| (1e-6 * libm::exp2(f64::from(step) / 1400.0)) as f32)
            .collect();
        let mut last = 0.0;
        for (code, value) in greys(&values, 0.0, view).into_iter().zip(&values) {
            assert!(code >= last, "{view:?} falls at {value}: {last} to {code}");
            last = code;
        }
        assert_eq!(last, 1.0);
    }
}

#[test]
fn bright_colours_fade_to_white_under_agx_only() {
    let sunset = [[400.0_f32, 90.0, 8.0]];
    let [_, _, blue] = apply_view(&sunset, 0.0, View::Agx)[0];
    assert!(blue > 0.9);
    // A saturated moderate colour keeps its hue order.
    let [r, g, b] = apply_view(&[[0.5, 0.2, 0.02]], 0.0, View::Agx)[0];
    assert!(r > g && g > b && r - b > 0.25, "{r} {g} {b}");
    // Pure red far beyond white: every channel reaches the top.
    assert!(
        apply_view(&[[1e6, 0.0, 0.0]], 0.0, View::Agx)[0]
            .iter()
            .all(|&code| code > 0.99)
    );
    assert_eq!(
        apply_view(&[[1e6, 0.0, 0.0]], 0.0, View::Standard)[0],
        [1.0, 0.0, 0.0]
    );
}

#[test]
fn exposure_is_a_factor_of_two_per_stop() {
    for view in View::ALL {
        assert_eq!(grey(0.1, 1.0, view), grey(0.2, 0.0, view));
        assert_eq!(grey(0.1, -3.0, view), grey(0.0125, 0.0, view));
    }
}

#[test]
fn nothing_makes_nan_or_leaves_the_range() {
    let values = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
        f32::MIN,
        -1.0,
        -0.0,
        0.0,
        f32::MIN_POSITIVE,
        1e-45,
        1e30,
        0.5,
    ];
    for view in View::ALL {
        for exposure_ev in [-32.0, 0.0, 32.0, f32::NAN] {
            let pixels: Vec<[f32; 3]> = values
                .iter()
                .flat_map(|&r| values.map(|g| [r, g, 0.25]))
                .collect();
            let codes = apply_view(&pixels, exposure_ev, view);
            for (pixel, codes) in pixels.iter().zip(codes) {
                let inside = codes.iter().all(|code| (0.0..=1.0).contains(code));
                assert!(inside, "{pixel:?}: {codes:?}");
            }
        }
        for dark in [f32::NAN, f32::NEG_INFINITY, -5.0, -0.0] {
            assert_eq!(grey(dark, 0.0, view).to_bits(), 0);
        }
        assert_eq!(grey(f32::INFINITY, 0.0, view), 1.0);
    }
}

#[test]
fn names_go_both_ways() {
    for view in View::ALL {
        assert_eq!(View::from_name(view.name()), Some(view));
    }
    assert_eq!(View::from_name("AGX"), None);
}
