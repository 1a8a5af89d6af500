//! How the choices differ: in noise. The halves of 64 x 64 pixels measure a variance
//! to sqrt(2 / 4096) = 2.2 % (one standard error); a ratio of two to 3.1 %.

use crate::common::{floor, halves, scene, variance, with};
use serde_json::{Value, json};

const SIDE: u32 = 64;
/// Samples of each half.
const SAMPLES: u32 = 16;
/// Four standard errors of a ratio of two variances.
const SLACK: f64 = 1.13;

fn diffuse() -> Value {
    floor(&json!({"type": "lambert", "albedo": [0.5, 0.5, 0.5]}))
}

// Half of all cosine-distributed directions meet a sun of 45 degrees at the zenith:
// heads or tails, with a known variance.
fn coin() -> Value {
    let sun = json!({"sun": {"azimuth_deg": 0, "elevation_deg": 90, "angular_radius_deg": 45, "radiance": [1, 1, 1]}});
    with(&diffuse(), &sun)
}

#[test]
fn independent_samples_have_the_variance_of_a_coin_and_sobol_points_far_less() {
    let of = |sampler: &str| {
        let sampling = json!({"mis": "scattering_only", "sampler": sampler});
        variance(&scene(SIDE, &coin(), &sampling, 1), SIDE, SAMPLES)
    };
    let coin = 0.25 * 0.25 / f64::from(SAMPLES);
    let independent = of("independent");
    assert!(
        (independent / coin - 1.0).abs() < 4.0 * 0.022,
        "{independent} against {coin}"
    );
    let sobol = of("sobol");
    assert!(sobol < 0.3 * coin, "{sobol} against {coin}");
}

// The error estimate needs halves that know nothing of each other.
#[test]
fn the_halves_are_independent_under_every_sampler() {
    for sampler in ["sobol", "independent"] {
        let sampling = json!({"mis": "scattering_only", "sampler": sampler});
        let [a, b] = halves(&scene(SIDE, &coin(), &sampling, 2), SIDE, SAMPLES);
        let error = |v: f64| v - 0.25;
        let sum = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
            a.iter().zip(&b).map(|(&a, &b)| f(error(a), error(b))).sum()
        };
        let correlation = sum(&|a, b| a * b) / (sum(&|a, _| a * a) * sum(&|_, b| b * b)).sqrt();
        // Its standard error is 1 / sqrt(pixels).
        assert!(
            correlation.abs() < 4.0 / f64::from(SIDE),
            "{sampler}: {correlation}"
        );
        assert_ne!(a, b);
    }
}

fn variances(fields: &Value, variants: &[&str]) -> Vec<f64> {
    let of = |mis: &&str| {
        let sampling = json!({"mis": mis, "sampler": "independent"});
        variance(&scene(SIDE, fields, &sampling, 3), SIDE, SAMPLES)
    };
    variants.iter().map(of).collect()
}

// A diffuse floor: light samples are the better technique, for the real sun and for
// a wide one. The balance heuristic adds what a chance hit of the sun now and then is
// worth: Veach and Guibas (1995, theorem 1) bound that by half the squared mean per
// sample; here it stays below a fiftieth.
#[test]
fn on_a_diffuse_floor_mis_is_no_worse_than_light_samples() {
    for radius in [0.27, 10.0] {
        let sun = json!({"sun": {"azimuth_deg": 10, "elevation_deg": 30, "angular_radius_deg": radius,
            "radiance": [1000, 1000, 1000]}});
        let found = variances(
            &with(&diffuse(), &sun),
            &["power", "balance", "lights_only"],
        );
        assert!(found[2] > 0.0);
        assert!(found[0] < SLACK * found[2], "{radius}: {found:?}");
        let sin = libm::sin(f64::to_radians(radius));
        let mean = 0.5 * 1000.0 * sin * sin * 0.5;
        let excess = 0.02 * mean * mean / f64::from(SAMPLES);
        assert!(found[1] < SLACK * found[2] + excess, "{radius}: {found:?}");
    }
}

// A floor like a mirror (alpha 1e-3) that shows a large sun and its rim: chance
// hits are the better technique by far. Only the pixels of the rim are noisy, a few
// hundred: a standard error of a ratio is about 14 %.
#[test]
fn on_a_mirror_mis_is_no_worse_than_chance_hits() {
    let fields = with(
        &floor(&json!({"type": "ggx", "metalness": 1, "roughness": 0.032})),
        &json!({"camera": {"position_m": [0, 5, 5], "target_m": [0, 0, 0], "vertical_fov_deg": 30},
            "sun": {"azimuth_deg": 0, "elevation_deg": 45, "angular_radius_deg": 10, "radiance": [1, 1, 1]}}),
    );
    let found = variances(
        &fields,
        &["power", "balance", "scattering_only", "lights_only"],
    );
    assert!(found[2] > 0.0);
    assert!(found[0] < 1.6 * found[2], "{found:?}");
    assert!(found[1] < 1.6 * found[2], "{found:?}");
    assert!(found[3] > 10.0 * found[0], "{found:?}");
}

// Neither technique alone does well for both; together they do.
#[test]
fn on_a_glossy_floor_mis_is_better_than_either_alone() {
    let fields = with(
        &floor(&json!({"type": "ggx", "metalness": 1, "roughness": 0.5})),
        &json!({"camera": {"position_m": [0, 5, 5], "target_m": [0, 0, 0], "vertical_fov_deg": 60},
            "sun": {"azimuth_deg": 0, "elevation_deg": 45, "angular_radius_deg": 25, "radiance": [1, 1, 1]}}),
    );
    let found = variances(
        &fields,
        &["power", "balance", "scattering_only", "lights_only"],
    );
    let alone = found[2].min(found[3]);
    assert!(found[..2].iter().all(|v| *v < SLACK * alone), "{found:?}");
}
