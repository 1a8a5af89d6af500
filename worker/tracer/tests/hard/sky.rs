//! The sky: hot, black, even, and infinitely far.

use crate::common::{floor, scene};
use crate::sun::{brightest, draw};
use crate::support::{Moments, uniform};
use crate::table::{Case, Form, Row, Section};
use glam::Vec3;
use shearwater_tracer::BuildOptions;
use shearwater_tracer::light::{MapTables, SkyLight, SkyMap};
use std::f64::consts::PI;
use std::sync::Arc;

static SECTION: Section = Section::new(
    "Sky",
    &[
        Case {
            name: "one hot texel of 4096 x 2048",
            note: "E = L Omega cos by light samples alone, as a share; a piecewise constant density of the texel alone would \
                   give 56.25 %, since the lookup is bilinear.",
            broken_by: "the sine left out of the samples' density",
            rows: hot_texel,
        },
        Case {
            name: "black map",
            note: "",
            broken_by: "every cell of the map given a weight of at least 1e-6",
            rows: black_map,
        },
        Case {
            name: "constant map",
            note: "E = pi L by light samples.",
            broken_by: "the sine left out of the samples' density",
            rows: constant_map,
        },
        Case {
            name: "every lit texel can be drawn",
            note: "A map of log-normal texels; a running f32 CDF gives 14 % of them probability 0.",
            broken_by: "cells below 1e-3 of the mean dropped",
            rows: no_zero_bins,
        },
        Case {
            name: "the sky is infinitely far",
            note: "Largest difference of radiance between two points 100 m apart.",
            broken_by: "the map treated as a dome of 1 km",
            rows: no_parallax,
        },
    ],
);

#[test]
fn sky_light() {
    SECTION.check();
}

const ANY: MapTables = MapTables {
    any_contrast: true,
    compensated: false,
};

fn sky(width: usize, height: usize, rgb: Vec<[f32; 3]>, turn: f64) -> SkyLight {
    SkyLight::Map(Arc::new(SkyMap::new(width, height, rgb, turn, ANY)))
}

/// Irradiance of a floor by light samples.
fn from_sky(sky: &SkyLight, samples: u64) -> Moments {
    let mut all = Moments::default();
    for i in 0..samples {
        let sample = sky.sample(Vec3::ZERO, draw(47, i));
        all.add(sample.map_or(0.0, |s| {
            f64::from(s.radiance.x) * f64::from(s.wi.y).max(0.0) / f64::from(s.pdf)
        }));
    }
    all
}

fn hot_texel(form: Form) -> Vec<Row> {
    let (width, height, row) = (4096usize, 2048usize, 512usize);
    let mut rgb = vec![[0.0f32; 3]; width * height];
    rgb[row * width + 1000] = [1e6; 3];
    let theta = PI * (row as f64 + 0.5) / height as f64;
    let exact = 1e6 * 1.665_166_4e-6 * libm::cos(theta);
    let all = from_sky(
        &sky(width, height, rgb, 123.0),
        form.pick(100_000, 1_000_000),
    );
    let (mean, error) = (all.mean() / exact, all.standard_error() / exact);
    vec![
        Row::sampled("E over L Omega cos", 1.0, mean, 4.0, error, 1e-5),
        Row::at_most(
            "its relative sigma of one sample",
            5.0,
            libm::sqrt(all.variance()) / all.mean(),
        ),
    ]
}

fn black_map(_: Form) -> Vec<Row> {
    let sky = sky(64, 32, vec![[0.0; 3]; 64 * 32], 0.0);
    let drawn = (0..10_000)
        .filter(|&i| sky.sample(Vec3::ZERO, draw(51, i)).is_some())
        .count();
    let (radiance, pdf) = sky.radiance_and_pdf(Vec3::ZERO, Vec3::Y);
    let black = format!(
        r#"{},"sky":{{"type":"constant","radiance":[0,0,0]}}"#,
        floor(r#"{"type":"ggx","base_color":[1,1,1],"roughness":0.3}"#)
    );
    let scene = scene(
        &black,
        [0.0, 2.0, 3.0],
        [0.0; 3],
        40.0,
        1,
        BuildOptions::default(),
    );
    vec![
        Row::exact("samples of 1e4", 0.0, drawn as f64),
        Row::exact("density", 0.0, f64::from(pdf)),
        Row::exact("radiance", 0.0, f64::from(radiance.element_sum())),
        Row::exact("brightest pixel under a black sky", 0.0, brightest(&scene)),
    ]
}

fn constant_map(form: Form) -> Vec<Row> {
    let sky = sky(64, 32, vec![[1.0; 3]; 64 * 32], 0.0);
    let all = from_sky(&sky, form.pick(100_000, 1_000_000));
    vec![Row::sampled(
        "E",
        PI,
        all.mean(),
        4.0,
        all.standard_error(),
        1e-5,
    )]
}

fn no_zero_bins(form: Form) -> Vec<Row> {
    let (width, height) = form.pick((1024usize, 512usize), (4096, 2048));
    let rgb = (0..width * height)
        .map(|i| {
            // Box and Muller.
            let (a, b) = (
                1.0 - f64::from(uniform(53, 2 * i as u64)),
                f64::from(uniform(53, 2 * i as u64 + 1)),
            );
            let normal = libm::sqrt(-2.0 * libm::log(a)) * libm::cos(2.0 * PI * b);
            [libm::exp(2.0 * normal) as f32; 3]
        })
        .collect();
    let sky = sky(width, height, rgb, 0.0);
    let (mut zero, mut integral) = (0u32, 0.0);
    for y in 0..height {
        let theta = PI * (y as f64 + 0.5) / height as f64;
        let area = 2.0 * PI * PI * libm::sin(theta) / (width * height) as f64;
        for x in 0..width {
            let phi = 2.0 * PI * ((x as f64 + 0.5) / width as f64 - 0.5);
            let (sin, cos) = (libm::sin(theta), libm::cos(theta));
            let d = Vec3::new(
                (sin * libm::sin(phi)) as f32,
                cos as f32,
                (-sin * libm::cos(phi)) as f32,
            );
            let (radiance, pdf) = sky.radiance_and_pdf(Vec3::ZERO, d);
            zero += u32::from(radiance.x > 0.0 && pdf <= 0.0);
            integral += f64::from(pdf) * area;
        }
    }
    vec![
        Row::exact("lit texels of density 0", 0.0, f64::from(zero)),
        Row::near("integral of the density", 1.0, integral, 1e-3),
    ]
}

fn no_parallax(_: Form) -> Vec<Row> {
    let rgb = (0..64 * 32).map(|i| [uniform(57, i); 3]).collect();
    let sky = sky(64, 32, rgb, 10.0);
    let mut worst = 0.0f32;
    for i in 0..1000 {
        let d = (Vec3::from(crate::support::uniform3(59, i)) - 0.5).normalize();
        let [a, b] = [Vec3::ZERO, Vec3::new(60.0, 0.0, 80.0)].map(|o| sky.radiance(o, d));
        worst = worst.max((a - b).abs().max_element());
    }
    vec![Row::exact("", 0.0, f64::from(worst))]
}
