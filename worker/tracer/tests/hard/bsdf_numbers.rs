//! Reflection models at the ends of 32-bit floats, and estimators against each
//! other.

use crate::common::{RECT, WHITE_SKY, scene, sums};
use crate::support::gallery::{gallery, ggx, metal, phong, plain_tables, white_dielectric};
use crate::support::metals::tables;
use crate::support::{Moments, direction, uniform, uniform3};
use crate::table::{Case, Form, Law, Row, Section};
use glam::Vec3;
use shearwater_shared::film::FIXED_ONE;
use shearwater_tracer::BuildOptions;
use shearwater_tracer::bsdf::microfacet::{MIRROR_ALPHA_MAX, ggx_d};
use shearwater_tracer::bsdf::{
    Bsdf, GgxModel, GgxParameters, GgxReport, LobeSampling, Phong, Tables,
};
use shearwater_tracer::math::warp::cosine_hemisphere;

static SECTION: Section = Section::new(
    "Reflection in 32-bit floats",
    &[
        Case {
            name: "D of GGX at n.h = 1",
            note: "1/(pi alpha^2); the textbook form in f32 is 10 % off at alpha 5e-4 and infinite at 1e-4.",
            broken_by: "D formed with (n.h)^2 (alpha^2 - 1) + 1",
            rows: ggx_peak,
        },
        Case {
            name: "Phong of n = 1e6",
            note: "u^(1/(n + 1)) in f32 has 195 distinct values: rings.",
            broken_by: "the cosine drawn as exp(ln(u)/(n + 1)); the peak (n + 1)/2 pi",
            rows: narrow_phong,
        },
        Case {
            name: "reciprocity",
            note: "Largest |f(o, i) - f(i, o)| over the larger of both, for pairs of directions of which half lie near the \
                   mirror direction; every kind of material, smooth and rough.",
            broken_by: "1 - E(i) of the body replaced by 1 - E(o)",
            rows: reciprocity,
        },
        Case {
            name: "weights of visible normals",
            note: "F G2/G1 lies in [0, 1]: the largest over all angles, 89.99 and 90 degrees included.",
            broken_by: "the density of visible normals scaled by 0.99",
            rows: largest_weight,
        },
        Case {
            name: "values that are no light",
            note: "Samples and evaluations that are NaN, infinite, negative, or leave below the surface, over all \
                   materials, corners of the random numbers included, and evaluations at the mirror direction, the viewer's own, \
                   the normal and the horizon.",
            broken_by: "Smith's shadowing divided by 4 cos(o) cos(i), as textbooks write it: NaN at 90 degrees",
            rows: no_light,
        },
        Case {
            name: "mixture against lobe alone",
            note: "Both are right in the mean (t-test); the mixture never has more variance (F-test, 1 % is four standard \
                   errors of a variance of bounded weights).",
            broken_by: "the chosen lobe's value over the density of both",
            rows: mixtures,
        },
        Case {
            name: "absent lobes",
            note: "kd = 0, ks = 0, both, and a black texel: values that are not exactly 0, or samples of a black surface.",
            broken_by: "a lobe of no colour chosen with the least probability",
            rows: absent,
        },
        Case {
            name: "Russian roulette",
            note: "A half sphere of albedo rho, open to a white sky: L = rho/2 / (1 - rho/2). A path counts rho, or by \
                   roulette 0 or 1, so its variance is known too: rho^2/2 (1 + p) - L^2 with p = 1/2 / (1 - rho/2). The \
                   facets leave out 0.1 % of the sphere. No depth is cut off.",
            broken_by: "a survivor's weight not raised",
            rows: roulette,
        },
    ],
);

#[test]
fn bsdf_numbers() {
    SECTION.check();
}

fn ggx_peak(_: Form) -> Vec<Row> {
    [1e-4f32, 2e-4, 5e-4, 1e-3, 0.1, 1.0]
        .into_iter()
        .map(|alpha| {
            let exact = 1.0 / (core::f64::consts::PI * f64::from(alpha) * f64::from(alpha));
            let d = f64::from(ggx_d(alpha, Vec3::Z));
            Row::near(format!("alpha {alpha:e}"), exact, d, 1e-5 * exact)
        })
        .collect()
}

fn narrow_phong(_: Form) -> Vec<Row> {
    let tables = Tables::default();
    let bsdf = phong(0.0, 1.0, 1e6);
    let angle = libm::sqrt(2.0 * core::f64::consts::LN_2 / 1e6);
    let mut sines = Vec::new();
    let mut within = 0;
    let samples = 1_000_000u64;
    for i in 0..samples {
        let Some(sample) = bsdf.sample(&tables, Vec3::Z, uniform3(7, i)) else {
            continue;
        };
        let (x, y) = (f64::from(sample.wi.x), f64::from(sample.wi.y));
        let sine = libm::sqrt(x * x + y * y);
        within += u32::from(sine < angle);
        sines.push((sine * 1e12) as u64);
    }
    sines.sort_unstable();
    sines.dedup();
    let peak = f64::from(bsdf.eval_pdf(&tables, Vec3::Z, Vec3::Z).0.x);
    let aside = direction(angle.to_degrees(), 0.0);
    let half = f64::from(bsdf.eval_pdf(&tables, Vec3::Z, aside).0.x) / peak;
    let error = libm::sqrt(0.25 / samples as f64);
    vec![
        Row::at_least("distinct angles in 1e6 samples", 1e5, sines.len() as f64),
        Row::near("peak (n + 2)/2 pi", 159_155.262, peak, 0.08),
        Row::near("value at 0.06746 deg over the peak", 0.5, half, 1e-3),
        Row::sampled(
            "samples within 0.06746 deg",
            0.5,
            f64::from(within) / samples as f64,
            4.0,
            error,
            5e-5,
        ),
    ]
}

/// What a name of the gallery begins with.
const KINDS: [&str; 6] = ["lambert", "phong", "water", "Corrected", "Report", "layer"];

fn reciprocity(form: Form) -> Vec<Row> {
    let tables = tables();
    let gallery = gallery(&tables);
    let pairs = form.pick(2_000, 100_000);
    KINDS
        .into_iter()
        .map(|kind| {
            let mut worst = 0.0f32;
            for (_, bsdf) in gallery.iter().filter(|(name, _)| name.starts_with(kind)) {
                for i in 0..pairs {
                    let [a, b, c] = uniform3(1, i);
                    let o = cosine_hemisphere([a, b]);
                    let spread = if i % 2 == 0 { 1.0 } else { 0.01 };
                    let wide = cosine_hemisphere([c, uniform(2, i)]);
                    let mirror = Vec3::new(-o.x, -o.y, o.z);
                    let v = (mirror * (1.0 - spread) + wide * spread).normalize();
                    if v.z < 1e-3 || o.z < 1e-3 {
                        continue;
                    }
                    let forth = bsdf.eval_pdf(&tables, o, v).0 / v.z;
                    let back = bsdf.eval_pdf(&tables, v, o).0 / o.z;
                    let size = forth.max(back).max_element();
                    if size > 1e-26 {
                        worst = worst.max((forth - back).abs().max_element() / size);
                    }
                }
            }
            Row::at_most(kind.to_lowercase(), 1e-4, f64::from(worst))
        })
        .collect()
}

fn largest_weight(form: Form) -> Vec<Row> {
    let tables = plain_tables();
    [MIRROR_ALPHA_MAX, 0.01, 0.1, 0.5, 1.0]
        .into_iter()
        .map(|alpha| {
            let bsdf = ggx(&tables, GgxModel::Corrected, &metal(alpha));
            let mut most = 0.0f32;
            for degrees in [0.0, 45.0, 80.0, 89.0, 89.99, 90.0] {
                let wo = direction(degrees, 10.0);
                for i in 0..form.pick(20_000, 500_000) {
                    if let Some(sample) = bsdf.sample(&tables, wo, uniform3(3, i)) {
                        most = most.max(sample.weight.max_element());
                    }
                }
            }
            Row::at_most(format!("alpha {alpha}"), 1.0 + 1e-5, f64::from(most))
        })
        .collect()
}

/// Random numbers of sample `i`: the corners of their ranges first.
fn numbers(i: u64) -> [f32; 3] {
    let ends = [0.0, 0.5, 1.0 - 1.0 / 16_777_216.0];
    if i < 27 {
        [
            ends[i as usize % 3],
            ends[i as usize / 3 % 3],
            ends[i as usize / 9],
        ]
    } else {
        uniform3(4, i)
    }
}

/// Whether a sample, or the evaluation of its direction, is no light.
fn is_bad(bsdf: &Bsdf, tables: &Tables, wo: Vec3, u: [f32; 3]) -> bool {
    let light = |v: Vec3| v.is_finite() && v.min_element() >= 0.0;
    let Some(sample) = bsdf.sample(tables, wo, u) else {
        return false;
    };
    let (f, pdf) = bsdf.eval_pdf(tables, wo, sample.wi);
    let unit = (sample.wi.length() - 1.0).abs() < 1e-5 && sample.wi.z > 0.0;
    let density = sample.pdf.is_finite() && sample.pdf > 0.0 && pdf.is_finite() && pdf >= 0.0;
    !(unit && density && light(sample.weight) && light(f))
}

/// Directions that are looked at whether or not they are ever drawn: the mirror's,
/// the viewer's own, the normal, and some at the very horizon.
fn corners(wo: Vec3) -> [Vec3; 5] {
    let low = |azimuth| Vec3 {
        z: 1e-7,
        ..direction(90.0, azimuth)
    };
    let mirror = Vec3::new(-wo.x, -wo.y, wo.z.max(1e-7));
    [
        mirror,
        wo.max(Vec3::new(-1.0, -1.0, 1e-7)),
        Vec3::Z,
        low(0.0),
        low(140.0),
    ]
}

/// Whether a material shows what is no light from one direction to another.
fn is_bad_value(bsdf: &Bsdf, tables: &Tables, wo: Vec3, wi: Vec3) -> bool {
    let (f, pdf) = bsdf.eval_pdf(tables, wo, wi);
    !(f.is_finite() && f.min_element() >= 0.0 && pdf.is_finite() && pdf >= 0.0)
}

fn no_light(form: Form) -> Vec<Row> {
    let tables = tables();
    let gallery = gallery(&tables);
    [0.0, 60.0, 89.99, 89.9999, 90.0]
        .into_iter()
        .map(|degrees| {
            let mut bad = 0;
            for (_, bsdf) in &gallery {
                for azimuth in [0.0, 133.0] {
                    let wo = direction(degrees, azimuth);
                    bad += (0..form.pick(2_000, 20_000))
                        .filter(|&i| is_bad(bsdf, &tables, wo, numbers(i)))
                        .count();
                    bad += corners(wo)
                        .into_iter()
                        .filter(|&wi| is_bad_value(bsdf, &tables, wo, wi))
                        .count();
                }
            }
            Row::exact(format!("{degrees} deg"), 0.0, bad as f64)
        })
        .collect()
}

/// Samples weighed by light from everywhere, twenty times more from around the
/// mirror direction of a view at 45 degrees.
fn lit(bsdf: &Bsdf, wo: Vec3, samples: u64) -> Moments {
    let bright = direction(45.0, 180.0);
    let mut spread = Moments::default();
    for i in 0..samples {
        let sample = bsdf.sample(&Tables::default(), wo, uniform3(23, i));
        let radiance = |wi: Vec3| if wi.dot(bright) > 0.97 { 20.0 } else { 1.0 };
        spread.add(sample.map_or(0.0, |s| f64::from(s.weight.y) * radiance(s.wi)));
    }
    spread
}

fn mixtures(form: Form) -> Vec<Row> {
    let samples = form.pick(50_000, 1_000_000);
    let half = Vec3::splat(0.5);
    let fifty = Phong::new(half, half, 50.0).expect("valid");
    let rough = GgxParameters {
        base_color: Vec3::splat(0.6),
        metalness: 0.0,
        alpha: 0.1,
        dielectric_f0: 0.2,
    };
    let rough = GgxReport::new(&rough).expect("valid");
    let pairs = [
        (
            "Phong 50, kd = ks = 0.5",
            Bsdf::Phong(fifty),
            Bsdf::Phong(fifty.with_sampling(LobeSampling::Lobe)),
        ),
        (
            "report, alpha 0.1",
            Bsdf::GgxReport(rough),
            Bsdf::GgxReport(rough.with_sampling(LobeSampling::Lobe)),
        ),
    ];
    let mut rows = Vec::new();
    for (name, mixture, lobe) in pairs {
        let (mut z, mut most, mut least) = (0.0f64, 0.0f64, f64::INFINITY);
        for degrees in [0.0, 30.0, 45.0, 60.0, 80.0] {
            let wo = direction(degrees, 0.0);
            let (a, b) = (lit(&mixture, wo, samples), lit(&lobe, wo, samples));
            let sigma = libm::sqrt((a.variance() + b.variance()) / samples as f64);
            z = z.max((a.mean() - b.mean()).abs() / sigma);
            most = most.max(a.variance() / b.variance());
            least = least.min(a.variance() / b.variance());
        }
        rows.push(
            Row::at_most(format!("{name}, difference of means in its sigma"), 4.0, z)
                .by(Law::Sigma(4.0)),
        );
        rows.push(
            Row::at_most(format!("{name}, largest quotient of variances"), 1.01, most)
                .by(Law::Sigma(4.0)),
        );
        // They are two samplers and not one by two names.
        rows.push(Row::at_most(
            format!("{name}, smallest quotient of variances"),
            0.99,
            least,
        ));
    }
    rows
}

fn absent(_: Form) -> Vec<Row> {
    let tables = plain_tables();
    let (wo, wi) = (direction(50.0, 0.0), direction(50.0, 180.0));
    let black = [
        ("Lambert, albedo 0", Bsdf::Lambert { albedo: Vec3::ZERO }),
        ("Phong, kd = ks = 0", phong(0.0, 0.0, 20.0)),
    ];
    let mut rows = Vec::new();
    for (name, bsdf) in black {
        let drawn = (0..10_000)
            .filter(|&i| bsdf.sample(&tables, wo, uniform3(5, i)).is_some())
            .count();
        rows.push(Row::exact(
            format!("{name}, samples of 1e4"),
            0.0,
            drawn as f64,
        ));
        let (f, pdf) = bsdf.eval_pdf(&tables, wo, wi);
        let sum = f64::from(f.element_sum()) + if pdf.is_finite() { 0.0 } else { f64::NAN };
        rows.push(Row::exact(format!("{name}, value"), 0.0, sum));
    }
    // ks = 0 is Lambert, kd = 0 the lobe: nothing else is drawn.
    let matte = phong(0.6, 0.0, 20.0);
    let off = |i| {
        matte
            .sample(&tables, wo, uniform3(6, i))
            .is_none_or(|s| (s.weight - 0.6).abs().max_element() > 1e-6)
    };
    let count = (0..10_000).filter(|&i| off(i)).count();
    rows.push(Row::exact(
        "Phong, ks = 0, weights that are not kd",
        0.0,
        count as f64,
    ));
    let shiny = phong(0.0, 0.6, 1000.0);
    let far = |i| {
        let sample = shiny.sample(&tables, wo, uniform3(6, i));
        sample.is_some_and(|s| s.wi.dot(wi) < 0.9)
    };
    let count = (0..10_000).filter(|&i| far(i)).count();
    rows.push(Row::exact(
        "Phong, kd = 0, n 1000, samples beyond 25 deg of the mirror",
        0.0,
        count as f64,
    ));
    // A black texel on a dielectric leaves the interface.
    let parameters = GgxParameters {
        base_color: Vec3::ZERO,
        ..white_dielectric(0.3)
    };
    let soot = ggx(&tables, GgxModel::Corrected, &parameters);
    let beyond = |i| {
        let sample = soot.sample(&tables, wo, uniform3(6, i));
        sample.is_some_and(|s| s.weight.is_nan() || s.weight.max_element() > 1.0 + 1e-5)
    };
    let count = (0..10_000).filter(|&i| beyond(i)).count();
    rows.push(Row::exact(
        "black body under an interface, weights above 1 or NaN",
        0.0,
        count as f64,
    ));
    rows
}

/// Single samples of a pixel's path into the bowl.
fn bowl_samples(rho: f64, samples: u32) -> Moments {
    // Roulette from the second scattering on: the variance is that of this rule.
    let body = format!(
        r#""materials":{{"m":{{"type":"lambert","albedo":[{rho},{rho},{rho}]}}}},
        "instances":[{{"mesh":"bowl","material":"m"}}],{WHITE_SKY},
        "sampling":{{"roulette":{{"from":1}}}}"#
    );
    let eye = [0.0, 0.5, 0.01];
    let scene = scene(
        &body,
        eye,
        [0.0, -1.0, 0.0],
        20.0,
        14,
        BuildOptions::default(),
    );
    let mut all = Moments::default();
    for index in 0..samples {
        let one = sums(&scene, index..index + 1);
        for half in &one.radiance {
            for pixel in 0..RECT.pixels() {
                all.add(half[3 * pixel] as f64 / FIXED_ONE);
            }
        }
    }
    all
}

fn roulette(form: Form) -> Vec<Row> {
    let mut rows = Vec::new();
    for rho in [0.5, 0.9, 0.99] {
        let all = bowl_samples(rho, form.pick(128, 4096));
        let mean = 0.5 * rho / (1.0 - 0.5 * rho);
        let p = 0.5 / (1.0 - 0.5 * rho);
        let square = 0.5 * rho * rho * (1.0 + p);
        let variance = square - mean * mean;
        rows.push(Row::sampled(
            format!("mean, rho {rho}"),
            mean,
            all.mean(),
            4.0,
            all.standard_error(),
            2e-3 * mean,
        ));
        // Values lie in [0, 1]: the fourth moment is below the second.
        let error = libm::sqrt((square - square * square).max(0.0) / all.count());
        rows.push(Row::sampled(
            format!("variance, rho {rho}"),
            variance,
            all.variance(),
            4.0,
            error,
            2e-3,
        ));
    }
    rows
}
