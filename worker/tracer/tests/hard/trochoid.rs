//! One wave of Gerstner's, in closed form.

use crate::table::{Form, Row};
use serde_json::json;
use shearwater_shared::scene::{GerstnerWater, Profile, Water};
use shearwater_tracer::water::water_pictures;
use std::f64::consts::PI;

/// Mean height and slopes of the case `trochoid` of the section on water.
pub(crate) fn trochoid(_: Form) -> Vec<Row> {
    let waves = serde_json::from_value(json!([
        {"amplitude_m": 0.3, "wavelength_m": 2.0 * PI, "direction_deg": 90, "phase_deg": 40}
    ]));
    let sea = GerstnerWater {
        waves: waves.expect("a wave"),
        profile: Profile::Trochoid,
        height_m: 0.0,
        body_color: [0.0; 3],
        ior: 1.333,
        roughness: 0.0,
        velocity_mps: [0.0; 2],
        time_s: 0.7,
        loop_s: None,
    };
    let pictures = water_pictures(&Water::Gerstner(sea), 0.0).expect("pictures");
    let [height, slope] = ["Y", "slope.X"].map(|name| channel(&pictures.height_exr, name));
    let n = pictures.points;
    let mean = height.iter().sum::<f64>() / height.len() as f64;
    let step = pictures.side_m / n as f64;
    // x = q + a cos(u), h = a sin(u), u = q - w t + phase: dh/dx = a cos(u)/(1 - a sin(u)).
    let exact = |x: f64| {
        let mut u = 0.0;
        for _ in 0..200 {
            u = x - 0.3 * libm::cos(u) - libm::sqrt(9.81) * 0.7 + 40_f64.to_radians();
        }
        0.3 * libm::cos(u) / (1.0 - 0.3 * libm::sin(u))
    };
    let off = |i: usize| (slope[i] - exact(f64::from((i as f64 * step) as f32))).abs();
    let worst = (0..n).map(off).fold(0.0, f64::max);
    vec![
        Row::near("mean height", -0.045, mean, 1e-6),
        Row::at_most("slope", 1e-5, worst),
    ]
}

fn channel(file: &[u8], name: &str) -> Vec<f64> {
    use exr::prelude::{FlatSamples, ReadChannels, ReadLayers, read};
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(std::io::Cursor::new(file))
        .expect("an EXR");
    let channels = image.layer_data.channel_data.list;
    let channel = channels.iter().find(|c| c.name.eq(name)).expect(name);
    match &channel.sample_data {
        FlatSamples::F32(values) => values.iter().map(|&v| f64::from(v)).collect(),
        other => panic!("{other:?}"),
    }
}
