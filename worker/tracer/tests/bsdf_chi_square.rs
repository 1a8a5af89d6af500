//! Every sampler against the density it claims: chi-square over 80 x 160 bins,
//! and the density's integral against the share of samples not absorbed.

#[path = "bsdf_support/mod.rs"]
mod support;

use glam::Vec3;
use shearwater_tracer::bsdf::{
    Bsdf, GgxModel, GgxParameters, LayerParameters, Layered, Phong, TableNeeds, Tables, Water,
};
use support::bins::{Chart, INTEGRAL_TOLERANCE, chi_square};
use support::metals::{COPPER, coat};
use support::{direction, sidak_level};

const SAMPLES: u64 = 1_000_000;
/// An odd azimuth, so that no symmetry hides an error in the frame.
const AZIMUTH_DEG: f64 = 37.0;
const ANGLES_DEG: [f64; 4] = [0.0, 60.0, 80.0, 89.0];
const ETA: f32 = 1.333;

const METAL_ALPHAS: [f32; 5] = [0.003, 0.03, 0.2, 0.5, 1.0];
const DIELECTRIC_ALPHAS: [f32; 2] = [0.05, 0.4];
const WATER_ALPHAS: [f32; 3] = [0.0, 0.02, 0.3];
const REPORT_ALPHAS: [f32; 3] = [0.02, 0.2, 0.8];
const PHONG_EXPONENTS: [f32; 5] = [0.0, 1.0, 30.0, 1000.0, 1e6];

/// Alpha of the base and of the coat, and metalness.
const COATED: [(f32, f32, f32); 5] = [
    (0.3, 0.05, 1.0),
    (0.05, 0.3, 1.0),
    (0.2, 0.0, 1.0),
    (0.0, 0.2, 1.0),
    (0.3, 0.1, 0.4),
];

/// All tests of this file; together they would raise a false alarm with one
/// set of seeds in a hundred (Sidak).
const FAMILY: usize = ANGLES_DEG.len()
    * (METAL_ALPHAS.len()
        + DIELECTRIC_ALPHAS.len()
        + WATER_ALPHAS.len()
        + REPORT_ALPHAS.len()
        + PHONG_EXPONENTS.len()
        + COATED.len()
        + 2);

fn tables() -> Tables {
    Tables::build(&TableNeeds {
        schlick: true,
        etas: vec![ETA],
        ..TableNeeds::default()
    })
    .expect("valid needs")
}

fn check(name: &str, parameter: f32, bsdf: &Bsdf, tables: &Tables, chart: Chart) {
    for (i, degrees) in ANGLES_DEG.into_iter().enumerate() {
        let wo = direction(degrees, AZIMUTH_DEG);
        let seed = 1000 + i as u64 + 16 * u64::from(parameter.to_bits());
        let found = chi_square(bsdf, tables, wo, chart, SAMPLES, seed);
        let label = format!("{name} {parameter} at {degrees}");
        println!(
            "{label}: p {:.4}, integral {:.5}, accepted {:.5}",
            found.p, found.integral, found.accepted
        );
        assert!(
            (found.integral - found.accepted).abs()
                <= INTEGRAL_TOLERANCE + 4.0 * (0.25 / SAMPLES as f64).sqrt(),
            "{label}: the pdf integrates to {}, but {} are accepted",
            found.integral,
            found.accepted
        );
        assert!(found.p > sidak_level(FAMILY), "{label}: p = {:e}", found.p);
    }
}

#[test]
fn lambert() {
    let bsdf = Bsdf::Lambert {
        albedo: Vec3::splat(0.5),
    };
    check(
        "lambert",
        1.0,
        &bsdf,
        &Tables::default(),
        Chart::Mirror(1.0),
    );
}

#[test]
fn ggx_metal() {
    let tables = tables();
    for alpha in METAL_ALPHAS {
        let parameters = GgxParameters {
            base_color: Vec3::new(1.0, 0.7, 0.3),
            metalness: 1.0,
            alpha,
            dielectric_f0: 0.04,
        };
        let bsdf = Bsdf::ggx(&tables, GgxModel::Corrected, &parameters).expect("valid");
        check(
            "metal",
            alpha,
            &bsdf,
            &tables,
            Chart::Half(f64::from(alpha)),
        );
    }
}

#[test]
fn ggx_dielectric() {
    let tables = tables();
    for alpha in DIELECTRIC_ALPHAS {
        let parameters = GgxParameters {
            base_color: Vec3::new(0.1, 0.7, 0.3),
            metalness: 0.2,
            alpha,
            dielectric_f0: 0.04,
        };
        let bsdf = Bsdf::ggx(&tables, GgxModel::Corrected, &parameters).expect("valid");
        check(
            "dielectric",
            alpha,
            &bsdf,
            &tables,
            Chart::Half(f64::from(alpha)),
        );
    }
}

#[test]
fn water() {
    let tables = tables();
    for alpha in WATER_ALPHAS {
        let bsdf = Bsdf::Water(
            Water::new(&tables, ETA, Vec3::new(0.02, 0.1, 0.15), alpha).expect("valid"),
        );
        let width = if alpha > 0.0 { f64::from(alpha) } else { 1.0 };
        check("water", alpha, &bsdf, &tables, Chart::Half(width));
    }
}

#[test]
fn ggx_report() {
    let tables = Tables::default();
    for alpha in REPORT_ALPHAS {
        let parameters = GgxParameters {
            base_color: Vec3::splat(0.6),
            metalness: 0.5,
            alpha,
            dielectric_f0: 0.04,
        };
        let bsdf = Bsdf::ggx(&tables, GgxModel::Report, &parameters).expect("valid");
        check(
            "report",
            alpha,
            &bsdf,
            &tables,
            Chart::Half(f64::from(alpha)),
        );
    }
}

#[test]
fn coated_metal() {
    let layer = |coat| LayerParameters {
        metal: COPPER,
        coat: Some(coat),
    };
    let needs = TableNeeds {
        layers: COATED.map(|(_, alpha, _)| layer(coat(0.8, alpha))).to_vec(),
        ..TableNeeds::default()
    };
    let tables = Tables::build(&needs).expect("valid needs");
    for (alpha, coat_alpha, metalness) in COATED {
        let parameters = GgxParameters {
            base_color: Vec3::new(1.0, 0.8, 0.9),
            metalness,
            alpha,
            dielectric_f0: 0.04,
        };
        let metal = Layered::new(&tables, &parameters, &layer(coat(0.8, coat_alpha)));
        let bsdf = Bsdf::Layered(metal.expect("valid"));
        let width = if alpha.min(coat_alpha) > 0.0 {
            alpha.min(coat_alpha)
        } else {
            alpha.max(coat_alpha)
        };
        let name = format!("coat {coat_alpha} over");
        check(&name, alpha, &bsdf, &tables, Chart::Half(f64::from(width)));
    }
}

#[test]
fn phong() {
    let tables = Tables::default();
    for exponent in PHONG_EXPONENTS {
        let width = libm::sqrt(2.0 / (f64::from(exponent) + 2.0));
        let bsdf = Bsdf::Phong(Phong::new(Vec3::ZERO, Vec3::ONE, exponent).expect("valid"));
        check("phong", exponent, &bsdf, &tables, Chart::Mirror(width));
    }
    let bsdf = Bsdf::Phong(Phong::new(Vec3::splat(0.5), Vec3::splat(0.5), 200.0).expect("valid"));
    check("phong mixture", 200.0, &bsdf, &tables, Chart::Mirror(0.1));
}
