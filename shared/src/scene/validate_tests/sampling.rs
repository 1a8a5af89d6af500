//! Values of how light is sampled.

use crate::scene::test_scene::{fails, full, with};
use crate::scene::{Mis, RouletteRule, Sampler, Sampling, SkySampling, parse};
use serde_json::json;

#[test]
fn values_out_of_range_are_named() {
    for (pointer, value, path, message) in [
        (
            "/sampling/sobol_scatterings",
            json!(9),
            "sampling.sobol_scatterings",
            "9: expected 0 to 8",
        ),
        (
            "/sampling/faint_share",
            json!(1.5),
            "sampling.faint_share",
            "1.5: expected 0 to 1",
        ),
        (
            "/sampling/mis",
            json!("maximum"),
            "sampling.mis",
            "unknown variant `maximum`",
        ),
        (
            "/sampling/roulette/from",
            json!(65),
            "sampling.roulette.from",
            "65: expected 0 to 64",
        ),
        (
            "/sampling/roulette/survival_min",
            json!(0),
            "sampling.roulette.survival_min",
            "0: expected 0.001 to 0.99",
        ),
        (
            "/sampling/roulette/survival_min",
            json!(2),
            "sampling.roulette.survival_min",
            "2: expected 0.001 to 0.99",
        ),
        (
            "/sampling/rolette",
            json!({}),
            "sampling.rolette",
            "unknown field `rolette`",
        ),
    ] {
        fails(&with(pointer, value), path, message);
    }
}

#[test]
fn every_choice_is_read_and_none_is_the_default() {
    let read = |text: &str| parse(text.as_bytes()).expect("valid").sampling;
    let full = read(&full().to_string());
    assert_eq!(full.sampler, Sampler::Independent);
    assert_eq!(full.mis, Mis::Balance);
    assert_eq!(full.sky_sampling, SkySampling::AnySky);
    assert_eq!(full.roulette.rule, RouletteRule::Albedo);
    assert_eq!((full.sobol_scatterings, full.roulette.from), (4, 2));
    assert!(!full.map_compensation);
    assert_eq!(read(&with("/sampling", json!(null))), Sampling::default());
    assert_eq!(read(&with("/sampling", json!({}))), Sampling::default());
}
