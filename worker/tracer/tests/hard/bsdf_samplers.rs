//! Every sampler against the density it claims: chi-square over 80 x 160 bins,
//! and the density's integral against the share of samples not absorbed.

use crate::support::bins::{Chart, INTEGRAL_TOLERANCE, chi_square};
use crate::support::gallery::{ETA, ggx};
use crate::support::metals::{COPPER, coat};
use crate::support::{chi_square_p, direction, sidak_level, uniform, uniform3};
use crate::table::{Case, Form, Row, Section};
use glam::Vec3;
use shearwater_shared::scene::Sun;
use shearwater_tracer::bsdf::leaning::Leaning;
use shearwater_tracer::bsdf::shading_frame::{bend_normal, face_viewer};
use shearwater_tracer::bsdf::{
    Bsdf, GgxModel, GgxParameters, LayerParameters, Layered, Phong, TableNeeds, Tables, Water,
};
use shearwater_tracer::light::SunLight;
use shearwater_tracer::math::frame::Frame;

static SECTION: Section = Section::new(
    "Samplers",
    &[
        Case {
            name: "smallest p-value",
            note: "Chi-square of samples against the integral of their density, 80 x 160 bins along the lobe, bins of less \
                   than 5 pooled; seven roughnesses, six angles, 1e6 samples each. Absorbed samples are left to the rows below.",
            broken_by: "the density of visible normals scaled by 0.99; the cosine of the Phong lobe drawn in f32",
            rows: chi_squares,
        },
        Case {
            name: "integral of the density",
            note: "Largest distance from the share of samples that were not absorbed, beyond four standard errors of \
                   that share.",
            broken_by: "the density of visible normals scaled by 0.99",
            rows: integrals,
        },
        Case {
            name: "folded water: smallest p-value",
            note: "Water about a leaning normal, with directions from below folded up: counts by octant and height \
                   against the integral of the density.",
            broken_by: "the folded direction's density left out",
            rows: folded,
        },
        Case {
            name: "cone of the sun: p-value",
            note: "Uniform in area and azimuth, 64 x 64 bins, from the directions themselves.",
            broken_by: "u^2 in place of u",
            rows: cones,
        },
    ],
);

#[test]
fn bsdf_samplers() {
    SECTION.check();
}

/// An odd azimuth, so that no symmetry hides an error in the frame.
const AZIMUTH_DEG: f64 = 37.0;

/// Smoothness by which the bins follow a model, and the model.
type Model = (String, Chart, Bsdf);

fn grey(metalness: f32, alpha: f32) -> GgxParameters {
    GgxParameters {
        base_color: Vec3::new(0.9, 0.7, 0.3),
        metalness,
        alpha,
        dielectric_f0: 0.04,
    }
}

fn layer(alpha: f32) -> LayerParameters {
    LayerParameters {
        metal: COPPER,
        coat: Some(coat(0.8, alpha)),
    }
}

/// Alpha of the base and of the coat, and metalness.
const COATED: [(f32, f32, f32); 7] = [
    (0.3, 0.05, 1.0),
    (0.05, 0.3, 1.0),
    (0.2, 0.0, 1.0),
    (0.0, 0.2, 1.0),
    (0.3, 0.1, 0.4),
    (0.003, 0.5, 1.0),
    (1.0, 0.1, 1.0),
];

fn build_tables() -> Tables {
    Tables::build(&TableNeeds {
        schlick: true,
        etas: vec![ETA],
        layers: COATED.map(|(_, alpha, _)| layer(alpha)).to_vec(),
    })
    .expect("valid needs")
}

/// All models by kind.
fn kinds(tables: &Tables, form: Form) -> Vec<(&'static str, Vec<Model>)> {
    let half = |alpha: f32| Chart::Half(if alpha > 0.0 { f64::from(alpha) } else { 1.0 });
    // Most of water's samples leave the body: narrower bins about the mirror direction
    // would leave bins at the horizon too wide to be integrated.
    let wide = |alpha: f32| half(if alpha > 0.0 { alpha.max(0.02) } else { 0.0 });
    let pick = |fast: &[f32], full: &[f32]| form.pick(fast.to_vec(), full.to_vec());
    let alphas = pick(&[0.003, 0.2, 1.0], &[0.003, 0.01, 0.03, 0.1, 0.2, 0.5, 1.0]);
    let rough = pick(&[0.05, 0.4], &[0.02, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0]);
    let wet = pick(&[0.0, 0.02, 0.3], &[0.0, 0.005, 0.02, 0.1, 0.3, 0.6, 1.0]);
    let exponents = pick(&[0.0, 30.0, 1e6], &[0.0, 1.0, 10.0, 30.0, 1e3, 1e4, 1e6]);
    let metal = |alpha: &f32| {
        (
            "metal",
            half(*alpha),
            ggx(tables, GgxModel::Corrected, &grey(1.0, *alpha)),
        )
    };
    let dielectric = |alpha: &f32| {
        (
            "dielectric",
            half(*alpha),
            ggx(tables, GgxModel::Corrected, &grey(0.2, *alpha)),
        )
    };
    let report = |alpha: &f32| {
        (
            "report",
            half(*alpha),
            ggx(tables, GgxModel::Report, &grey(0.5, *alpha)),
        )
    };
    let water = |alpha: &f32| {
        let body = Vec3::new(0.02, 0.1, 0.15);
        (
            "water",
            wide(*alpha),
            Bsdf::Water(Water::new(tables, ETA, body, *alpha).expect("valid")),
        )
    };
    let phong = |n: &f32| {
        let width = libm::sqrt(2.0 / (f64::from(*n) + 2.0));
        (
            "phong",
            Chart::Mirror(width),
            Bsdf::Phong(Phong::new(Vec3::ZERO, Vec3::ONE, *n).expect("valid")),
        )
    };
    let mixture = |n: &f32| {
        let half = Vec3::splat(0.5);
        (
            "mixture",
            Chart::Mirror(0.1),
            Bsdf::Phong(Phong::new(half, half, *n).expect("valid")),
        )
    };
    let coated = |&(alpha, over, metalness): &(f32, f32, f32)| {
        let layered = Layered::new(tables, &grey(metalness, alpha), &layer(over)).expect("valid");
        let width = if alpha.min(over) > 0.0 {
            alpha.min(over)
        } else {
            alpha.max(over)
        };
        ("coat", half(width), Bsdf::Layered(layered))
    };
    let named = |(name, chart, bsdf): (&str, Chart, Bsdf)| (name.to_owned(), chart, bsdf);
    let lambert = (
        "lambert".to_owned(),
        Chart::Mirror(1.0),
        Bsdf::Lambert {
            albedo: Vec3::splat(0.5),
        },
    );
    vec![
        ("Lambert", vec![lambert]),
        ("GGX metal", alphas.iter().map(metal).map(named).collect()),
        (
            "GGX dielectric",
            rough.iter().map(dielectric).map(named).collect(),
        ),
        (
            "GGX of the report",
            pick(&[0.02, 0.8], &[0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.0])
                .iter()
                .map(report)
                .map(named)
                .collect(),
        ),
        ("water", wet.iter().map(water).map(named).collect()),
        (
            "Phong lobe",
            exponents.iter().map(phong).map(named).collect(),
        ),
        (
            "Phong mixture",
            pick(&[200.0], &[1.0, 5.0, 20.0, 50.0, 200.0, 1e3, 1e4])
                .iter()
                .map(mixture)
                .map(named)
                .collect(),
        ),
        (
            "coated metal",
            COATED[..form.pick(3, 7)]
                .iter()
                .map(coated)
                .map(named)
                .collect(),
        ),
    ]
}

/// What all tests of one kind found.
struct Found {
    kind: &'static str,
    p: f64,
    gap: f64,
}

const ANGLES_DEG: [f64; 6] = [0.0, 30.0, 60.0, 75.0, 85.0, 89.0];

/// The whole family, and how many tests it holds in full, for both forms: the
/// document states one level.
fn family(form: Form) -> &'static (Vec<Found>, usize) {
    static ONCE: std::sync::OnceLock<(Vec<Found>, usize)> = std::sync::OnceLock::new();
    ONCE.get_or_init(|| {
        let tables = build_tables();
        let samples = form.pick(50_000, 1_000_000);
        let angles = form.pick(vec![60.0, 89.0], ANGLES_DEG.to_vec());
        let mut tests = 0;
        let full: usize = kinds(&tables, Form::Full).iter().map(|k| k.1.len()).sum();
        let mut all = Vec::new();
        for (kind, models) in kinds(&tables, form) {
            let (mut p, mut gap) = (1.0f64, 0.0f64);
            for (number, (_, chart, bsdf)) in models.iter().enumerate() {
                for (i, &degrees) in angles.iter().enumerate() {
                    let seed = 1000 + i as u64 + 16 * number as u64 + 1024 * tests as u64;
                    let wo = direction(degrees, AZIMUTH_DEG);
                    let found = chi_square(bsdf, &tables, wo, *chart, samples, seed);
                    let share = found.accepted;
                    let error = libm::sqrt((share * (1.0 - share)).max(0.0) / samples as f64);
                    p = p.min(found.p);
                    gap = gap.max((found.integral - share).abs() - 4.0 * error);
                    tests += 1;
                }
            }
            all.push(Found { kind, p, gap });
        }
        (all, full * ANGLES_DEG.len())
    })
}

fn chi_squares(form: Form) -> Vec<Row> {
    let (found, tests) = family(form);
    let row = |one: &Found| Row::p_value(one.kind, sidak_level(*tests), one.p);
    found.iter().map(row).collect()
}

fn integrals(form: Form) -> Vec<Row> {
    let (found, _) = family(form);
    let row = |one: &Found| Row::at_most(one.kind, 2.0 * INTEGRAL_TOLERANCE, one.gap.max(0.0));
    found.iter().map(row).collect()
}

/// Bins of a direction above a plane: height and azimuth.
const FOLDED_BINS: [usize; 2] = [12, 24];

fn folded_bin(wi: Vec3) -> usize {
    let turn = libm::atan2(f64::from(wi.y), f64::from(wi.x)) / core::f64::consts::TAU + 0.5;
    let cell = |v: f64, n: usize| ((v * n as f64) as usize).min(n - 1);
    cell(f64::from(wi.z), FOLDED_BINS[0]) * FOLDED_BINS[1] + cell(turn, FOLDED_BINS[1])
}

fn folded(form: Form) -> Vec<Row> {
    let tables = build_tables();
    let samples = form.pick(100_000u64, 1_000_000);
    let lean = |degrees: f64| direction(degrees, 60.0);
    let cases = [(0.2f32, 15.0, 60.0), (0.4, 25.0, 80.0), (0.3, 10.0, 88.0)];
    let bins = FOLDED_BINS[0] * FOLDED_BINS[1];
    cases
        .into_iter()
        .enumerate()
        .map(|(number, (alpha, tilt, degrees))| {
            let bsdf =
                Bsdf::Water(Water::new(&tables, ETA, Vec3::splat(0.5), alpha).expect("valid"));
            // Away from the lean, so that the mirror image lies low.
            let wo = direction(degrees, 200.0);
            let (shading, geometric) = face_viewer(lean(tilt), Vec3::Z, wo);
            let frame = Frame::from_normal(bend_normal(shading, geometric, wo));
            let view = Leaning {
                frame,
                geometric,
                wo_local: frame.to_local(wo),
                water: true,
            };
            let mut counts = vec![0u32; bins + 1];
            for i in 0..samples {
                let u = uniform3(900 + number as u64, i);
                let bin = view
                    .sample(&bsdf, &tables, u)
                    .map_or(bins, |s| folded_bin(s.wi));
                counts[bin] += 1;
            }
            assert!(2 * u64::from(counts[bins]) < samples, "most were absorbed");
            // Uniform in height and azimuth: each point has the same solid angle.
            let points = form.pick(48, 96);
            let [rows, columns] = FOLDED_BINS.map(|n| n * points);
            let mut expected = vec![0.0; bins + 1];
            for y in 0..rows {
                for x in 0..columns {
                    let z = (y as f64 + 0.5) / rows as f64;
                    let turn = core::f64::consts::TAU * ((x as f64 + 0.5) / columns as f64 - 0.5);
                    let r = libm::sqrt(1.0 - z * z);
                    let wi = Vec3::new(
                        (r * libm::cos(turn)) as f32,
                        (r * libm::sin(turn)) as f32,
                        z as f32,
                    );
                    let pdf = view.eval_pdf(&bsdf, &tables, wi).1;
                    let area = core::f64::consts::TAU / (rows * columns) as f64;
                    expected[y / points * FOLDED_BINS[1] + x / points] +=
                        f64::from(pdf) * area * samples as f64;
                }
            }
            let total: f64 = expected.iter().sum();
            expected[bins] = (samples as f64 - total).max(0.0);
            let p = chi_square_p(&counts, &expected);
            Row::p_value(
                format!("alpha {alpha}, leaning {tilt} deg, view at {degrees}"),
                sidak_level(cases.len()),
                p,
            )
        })
        .collect()
}

fn cones(form: Form) -> Vec<Row> {
    let radii = [0.05, 0.27, 5.0, 45.0];
    let samples = form.pick(200_000u64, 2_000_000);
    radii
        .into_iter()
        .map(|radius: f64| {
            let light = SunLight::new(&Sun {
                azimuth_deg: 30.0,
                elevation_deg: 90.0,
                angular_radius_deg: radius,
                radiance: Some([1.0; 3]),
            })
            .expect("light");
            let side = 64;
            let most = libm::sin(radius.to_radians() * 0.5);
            let mut counts = vec![0u32; side * side];
            for i in 0..samples {
                let d = light.sample([uniform(70, i), uniform(71, i)]).as_dvec3();
                // The share of the cone's area within: sin^2 of half the angle.
                let sin2 = d.x * d.x + d.z * d.z;
                let inner = 0.5 * sin2 / (1.0 + libm::sqrt(1.0 - sin2)) / (most * most);
                let turn = libm::atan2(d.z, d.x) / core::f64::consts::TAU + 0.5;
                let cell = |v: f64| ((v * side as f64) as usize).min(side - 1);
                counts[cell(inner) * side + cell(turn)] += 1;
            }
            let expected = vec![samples as f64 / (side * side) as f64; side * side];
            Row::p_value(
                format!("radius {radius} deg"),
                sidak_level(radii.len()),
                chi_square_p(&counts, &expected),
            )
        })
        .collect()
}
