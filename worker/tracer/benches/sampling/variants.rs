//! What is measured.

use serde_json::{Value, json};

/// Merge patches of a scene; the first changes nothing and shows the noise.
pub(crate) fn all() -> Vec<Value> {
    [
        json!({}),
        json!({"sampler": "independent"}),
        json!({"sobol_scatterings": 0}),
        json!({"sobol_scatterings": 1}),
        json!({"sobol_scatterings": 8}),
        json!({"mis": "balance"}),
        json!({"mis": "lights_only"}),
        json!({"map_compensation": false}),
        json!({"sky_sampling": "rough"}),
        json!({"sky_sampling": "any_sky"}),
        json!({"sky_sampling": "always"}),
        json!({"sky_sampling": "never"}),
        json!({"faint_share": 0}),
        json!({"faint_share": 0.2}),
        json!({"roulette": {"from": 0}}),
        json!({"roulette": {"from": 1}}),
        json!({"roulette": {"from": 2}}),
        json!({"roulette": {"from": 5}}),
        json!({"roulette": {"rule": "throughput_root"}}),
        json!({"roulette": {"rule": "albedo"}}),
        json!({"roulette": {"rule": "none"}}),
        json!({"roulette": {"survival_min": 0.2}}),
        json!({"roulette": {"from": 1}, "sky_sampling": "rough", "map_compensation": false}),
    ]
    .into_iter()
    .map(|sampling| json!({"sampling": sampling}))
    .collect()
}
