//! The sun: small, far, and on the wrong side.

use crate::common::{RECT, floor, mean_and_error, scene, sums};
use crate::support::{Moments, uniform};
use crate::table::{Case, Form, Law, Row, Section};
use shearwater_shared::scene::Sun;
use shearwater_tracer::light::SunLight;
use shearwater_tracer::math::warp::{one_minus_cos, uniform_cone_pdf};
use shearwater_tracer::{BuildOptions, Scene};
use std::f64::consts::PI;

static SECTION: Section = Section::new(
    "Sun",
    &[
        Case {
            name: "a far sphere",
            note: "Irradiance of a sphere of radius r at distance d, above the horizon, as a share of pi L (r/d)^2 cos: the sun \
                   of that angular radius.",
            broken_by: "the density of a cone with 1 - cos formed in f32",
            rows: spheres,
        },
        Case {
            name: "sun of 0.27 degrees and radiance 1e6",
            note: "Irradiance by light samples, W/m^2 per unit of radiance; E = pi L sin^2(r) cos.",
            broken_by: "the density of a cone with 1 - cos formed in f32",
            rows: small_sun,
        },
        Case {
            name: "its relative sigma of one sample",
            note: "Samples spread over the disc and no more; a chance hit would have 212 at the zenith.",
            broken_by: "directions drawn with u^2 in place of u",
            rows: sun_sigma,
        },
        Case {
            name: "a floor under that sun",
            note: "Whole paths, albedo 0.5: 0.5/pi E.",
            broken_by: "the density of a cone with 1 - cos formed in f32",
            rows: lit_floor,
        },
        Case {
            name: "light samples, chance hits and both",
            note: "A sun of 8 degrees on a rough and a smooth floor; differences in standard errors.",
            broken_by: "the weight of chance hits squared",
            rows: three_ways,
        },
        Case {
            name: "1 - cos of a small cone",
            note: "Relative error of s2/(1 + sqrt(1 - s2)); 1 - sqrt(1 - s2) in f32 is 7 % off at d/r = 1000, and 0 (infinite \
                   density) at 1e4.",
            broken_by: "1 - sqrt(1 - s2)",
            rows: cancellation,
        },
        Case {
            name: "distinct directions",
            note: "Chords of 1e5 samples; a cosine drawn in f32 has 187 values at 0.27 degrees.",
            broken_by: "the sine taken from the rounded cosine",
            rows: distinct,
        },
        Case {
            name: "light behind the surface",
            note: "A sun 10 degrees below an opaque floor, shading normals leaning 45 degrees towards it, and below the sea: \
                   the brightest pixel.",
            broken_by: "the test of the geometric normal left out of the value",
            rows: no_leaks,
        },
    ],
);

#[test]
fn sun_light() {
    SECTION.check();
}

fn sun(elevation_deg: f64, angular_radius_deg: f64) -> SunLight {
    SunLight::new(&Sun {
        azimuth_deg: 30.0,
        elevation_deg,
        angular_radius_deg,
        radiance: Some([1e6; 3]),
    })
    .expect("light")
}

/// Two random numbers of sample `i`.
pub(crate) fn draw(seed: u64, i: u64) -> [f32; 2] {
    [uniform(seed, 2 * i), uniform(seed, 2 * i + 1)]
}

/// Radiance times cosine over density of each sample, on a floor.
fn irradiance(light: &SunLight, samples: u64) -> Moments {
    let mut all = Moments::default();
    for i in 0..samples {
        let cos = f64::from(light.sample(draw(41, i)).y).max(0.0);
        all.add(f64::from(light.radiance.x) * cos / f64::from(light.pdf()));
    }
    all
}

fn spheres(form: Form) -> Vec<Row> {
    let samples = form.pick(20_000, 1_000_000);
    let mut rows = Vec::new();
    for ratio in [2.5, 10.0, 1e3, 1e5] {
        let sine: f64 = 1.0 / ratio;
        let all = irradiance(&sun(60.0, libm::asin(sine).to_degrees()), samples);
        let exact = 1e6 * PI * sine * sine * libm::sin(60f64.to_radians());
        let at = format!("d/r {ratio}, 60 deg of elevation");
        rows.push(Row::sampled(
            at,
            1.0,
            all.mean() / exact,
            4.0,
            all.standard_error() / exact,
            3e-7,
        ));
    }
    rows
}

/// Elevation, irradiance, and relative sigma of one sample.
const SMALL: [(f64, f64, f64); 4] = [
    (90.0, 69.763_606, 3.2e-6),
    (60.0, 60.417_055, 0.00136),
    (30.0, 34.881_803, 0.00408),
    (10.0, 12.114_323, 0.01336),
];

fn small_sun(form: Form) -> Vec<Row> {
    let row = |(elevation, expected, _): (f64, f64, f64)| {
        let all = irradiance(&sun(elevation, 0.27), form.pick(20_000, 1_000_000));
        let at = format!("{elevation} deg of elevation");
        Row::sampled(
            at,
            expected,
            all.mean(),
            4.0,
            all.standard_error(),
            3e-7 * expected,
        )
    };
    SMALL.into_iter().map(row).collect()
}

fn sun_sigma(_: Form) -> Vec<Row> {
    let row = |(elevation, _, expected): (f64, f64, f64)| {
        let all = irradiance(&sun(elevation, 0.27), 200_000);
        let sigma = libm::sqrt(all.variance()) / all.mean();
        // The listed values have two or three digits.
        Row::near(
            format!("{elevation} deg of elevation"),
            expected,
            sigma,
            0.015 * expected,
        )
    };
    SMALL.into_iter().map(row).collect()
}

fn lit_floor(form: Form) -> Vec<Row> {
    let row = |(elevation, expected, _): (f64, f64, f64)| {
        let sun = format!(
            r#""sun":{{"azimuth_deg":40,"elevation_deg":{elevation},"radiance":[1e6,1e6,1e6]}}"#
        );
        let body = format!(
            "{},{sun}",
            floor(r#"{"type":"lambert","albedo":[0.5,0.5,0.5]}"#)
        );
        let scene = scene(
            &body,
            [0.0, 2.0, 0.0],
            [0.0; 3],
            20.0,
            4,
            BuildOptions::default(),
        );
        let (mean, error) = mean_and_error(&scene, form.pick(16, 512));
        let expected = 0.5 / PI * expected;
        Row::sampled(
            format!("{elevation} deg"),
            expected,
            mean,
            4.0,
            error,
            1e-6 * expected,
        )
    };
    SMALL.into_iter().map(row).collect()
}

fn three_ways(form: Form) -> Vec<Row> {
    let samples = form.pick(256, 8192);
    let by = |roughness: f64, mis: &str, seed| {
        let material = format!(
            r#"{{"type":"ggx","base_color":[1,1,1],"metalness":1,"roughness":{roughness}}}"#
        );
        let body = format!(
            r#"{},"sun":{{"azimuth_deg":0,"elevation_deg":45,"angular_radius_deg":8,"radiance":[1,1,1]}},
            "sampling":{{"mis":"{mis}"}}"#,
            floor(&material)
        );
        let scene = scene(
            &body,
            [0.0, 5.0, 5.0],
            [0.0; 3],
            3.0,
            seed,
            BuildOptions::default(),
        );
        mean_and_error(&scene, samples)
    };
    let mut rows = Vec::new();
    // alpha is the square: 0.36 and 0.001.
    for (name, roughness, ways) in [
        ("alpha 0.36", 0.6, &["power", "balance", "lights_only"][..]),
        ("alpha 0.001", 0.03163, &["power", "balance"][..]),
    ] {
        let (chance, error) = by(roughness, "scattering_only", 61);
        for (mis, seed) in ways.iter().zip(62..) {
            let (mean, other) = by(roughness, mis, seed);
            // 1e-6 for what rounding leaves where nothing is random.
            let sigma = libm::sqrt(error * error + other * other) + 1e-6 * chance;
            let z = (mean - chance).abs() / sigma;
            rows.push(Row::at_most(format!("{name}, {mis}"), 4.0, z).by(Law::Sigma(4.0)));
        }
    }
    rows
}

fn cancellation(_: Form) -> Vec<Row> {
    let row = |ratio: f64| {
        let sin2 = (1.0 / (ratio * ratio)) as f32;
        let wide = f64::from(sin2);
        let exact = wide / (1.0 + libm::sqrt(1.0 - wide));
        let found = f64::from(one_minus_cos(sin2));
        Row::near(format!("d/r {ratio}"), 0.0, found / exact - 1.0, 1e-7)
    };
    let mut rows: Vec<Row> = [1.2, 10.0, 100.0, 1000.0, 4096.0, 1e4, 1e6].map(row).into();
    let far = uniform_cone_pdf(one_minus_cos(1e-8));
    rows.push(Row::near(
        "density at d/r 1e4, times pi sin^2",
        1.0,
        f64::from(far) * PI * 1e-8,
        1e-6,
    ));
    rows
}

fn distinct(_: Form) -> Vec<Row> {
    let row = |radius: f64| {
        let light = sun(20.0, radius);
        let mut chords = std::collections::BTreeSet::new();
        for i in 0..100_000 {
            let chord = (light.sample(draw(43, i)) - light.direction()).length_squared();
            chords.insert(chord.to_bits());
        }
        Row::at_least(format!("{radius} deg"), 5e4, chords.len() as f64)
    };
    [0.05, 0.27, 5.0].map(row).into()
}

/// The largest channel of any pixel in 16 samples of each half.
pub(crate) fn brightest(scene: &Scene) -> f64 {
    let sums = sums(scene, 0..16);
    assert_eq!(sums.radiance[0].len(), 3 * RECT.pixels());
    sums.radiance
        .iter()
        .flatten()
        .max()
        .map_or(f64::NAN, |&v| v as f64)
}

fn no_leaks(_: Form) -> Vec<Row> {
    // Normals of `leaning.obj` lean towards +x, azimuth 90.
    let below = r#""sun":{"azimuth_deg":90,"elevation_deg":-10,"radiance":[1e6,1e6,1e6]}"#;
    let materials = [
        ("Lambert", r#"{"type":"lambert","albedo":[1,1,1]}"#),
        (
            "Phong",
            r#"{"type":"phong","kd":[0.5,0.5,0.5],"ks":[0.5,0.5,0.5],"exponent":5}"#,
        ),
        (
            "GGX",
            r#"{"type":"ggx","base_color":[1,1,1],"roughness":0.7}"#,
        ),
        (
            "report",
            r#"{"type":"ggx","base_color":[1,1,1],"roughness":0.7,"model":"report"}"#,
        ),
    ];
    let eye = [3.0, 2.0, 0.0];
    let mut rows: Vec<Row> = materials
        .into_iter()
        .map(|(name, material)| {
            let ground = floor(material).replace("\"floor\"", "\"leaning\"");
            let scene = scene(
                &format!("{ground},{below}"),
                eye,
                [0.0; 3],
                20.0,
                3,
                BuildOptions::default(),
            );
            Row::exact(name, 0.0, brightest(&scene))
        })
        .collect();
    let sea = r#""water":{"type":"tessendorf","tile_m":50,"wind_speed_mps":15,"roughness":0.5,"body_color":[1,1,1]}"#;
    let scene = scene(
        &format!("{sea},{below}"),
        eye,
        [0.0; 3],
        20.0,
        3,
        BuildOptions::default(),
    );
    rows.push(Row::exact("water", 0.0, brightest(&scene)));
    // The same normals under a sun above: not black for want of light.
    let above = below.replace("-10", "10");
    let ground = floor(materials[0].1).replace("\"floor\"", "\"leaning\"");
    let scene = crate::common::scene(
        &format!("{ground},{above}"),
        eye,
        [0.0; 3],
        20.0,
        3,
        BuildOptions::default(),
    );
    let (mean, _) = mean_and_error(&scene, 16);
    rows.push(Row::at_least(
        "Lambert, a sun above instead, mean radiance",
        5.0,
        mean,
    ));
    rows
}
